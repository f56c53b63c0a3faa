"""The background plate of a scene, taken over from an earlier scene where it would be the same."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from physagent_studio.knowledge import grows
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Support
from physagent_studio.reconstruction.background.lines_behind import edges_of
from physagent_studio.reconstruction.background.plate import Inpaint, background, hole_of
from physagent_studio.reconstruction.background.shift_map import to_level
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Scene


def scene_plate(
    image: Image,
    masks: Mapping[str, BoolArray],
    found: Segments,
    camera: Camera,
    solid: Sequence[Support],
    previous: Scene | None = None,
    aloft: Collection[str] = (),
    inpaint: Inpaint | None = None,
    between: Callable[[], None] = lambda: None,
) -> Image:
    """The photo (H, W, 3) without the masked things; that of an earlier scene if it is the same.

    found: the photo's edges. camera, solid: what the scene's ground and supports were found to be.
    aloft: names of things in the air. inpaint, between: see `background`.
    """
    if (
        previous is not None
        and previous.plate is not None
        and _same_masks(previous, image, masks)
        and _same_ways(previous, masks, camera, solid)
    ):
        return previous.plate
    rooted = [mask for name, mask in masks.items() if grows(name)]
    return background(
        image,
        list(masks.values()),
        camera=camera,
        found=found,
        solid=solid,
        rooted=rooted,
        aloft=[mask for name, mask in masks.items() if name in aloft],
        inpaint=inpaint,
        between=between,
    )


def _same_masks(previous: Scene, image: Image, masks: Mapping[str, BoolArray]) -> bool:
    """Whether the same is to be taken out of the same photo.

    What was set down beside it has an empty mask: nothing of the photo is behind that.
    """
    old, new = _seen(previous.masks), _seen(masks)
    if previous.photo is None or old.keys() != new.keys():
        return False
    same = np.array_equal(previous.photo, image)
    return same and all(np.array_equal(old[name], new[name]) for name in new)


def _seen(masks: Mapping[str, BoolArray]) -> dict[str, BoolArray]:
    return {name: mask for name, mask in masks.items() if mask.any()}


def _same_ways(
    previous: Scene, masks: Mapping[str, BoolArray], camera: Camera, solid: Sequence[Support]
) -> bool:
    """Whether level ground and the supports' edges run through the photo as they did."""
    before, photo = previous.state.camera, previous.photo
    if before is None or photo is None:
        return False
    if not np.allclose(to_level(before), to_level(camera), rtol=0, atol=1e-9):
        return False
    hole = hole_of(list(masks.values()), photo.shape[:2])
    old = edges_of(photo, hole, before, previous.state.supports)
    new = edges_of(photo, hole, camera, solid)
    return old.shape == new.shape and bool(np.allclose(old, new, rtol=0, atol=1e-6))
