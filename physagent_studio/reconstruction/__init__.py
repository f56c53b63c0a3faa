"""Image and clicks → scene: masks, camera, supports, shapes, places, textures, plate, checks."""

from physagent_studio.reconstruction.exif import stated_focal
from physagent_studio.reconstruction.meshes import mesh_of
from physagent_studio.reconstruction.photo import photo_hash, read_photo, read_scaled, reduction_of
from physagent_studio.reconstruction.reconstruct import reconstruct
from physagent_studio.reconstruction.sameness import scene_hash

__all__ = [
    "mesh_of",
    "photo_hash",
    "read_photo",
    "read_scaled",
    "reconstruct",
    "reduction_of",
    "scene_hash",
    "stated_focal",
]
