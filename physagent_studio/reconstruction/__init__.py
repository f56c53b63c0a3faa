"""Image and clicks → scene: masks, camera, supports, shapes, places, textures, plate, checks."""

from physagent_studio.reconstruction.cache import scene_hash
from physagent_studio.reconstruction.photo.exif import stated_focal
from physagent_studio.reconstruction.photo.reading import (
    photo_hash,
    read_photo,
    read_scaled,
    reduction_of,
)
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.reconstruction.shapes.meshes import mesh_of
