"""`Case`: the input image, the event prompt and the clicks that ground names in the image."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding, Landmark, Scale, Support

Image = NDArray[np.uint8]
"""(H, W, 3) uint8, RGB."""


@dataclass(frozen=True, eq=False, slots=True)
class Case:
    """What a person brings.

    image: (H, W, 3) uint8 RGB, or None for a bare program without a photo.
    image_hash: SHA-256 of the decoded pixels; "" without a photo.
    objects: (name, grounding) in the case's order. events: (name, prompt) of all its events.
    horizon: row where a person sees it, pixels, in the middle column; None is open. roll: degrees
    by which it rises to the right, as the camera was turned clockwise.
    scale: a size that a person typed; its default is open. focal: the focal length that the
    picture's file states, pixels; None where it states none. seconds: how long the clip shall be
    shown; None is as usual.
    """

    name: str
    image: Image | None = None
    image_hash: str = ""
    objects: tuple[tuple[str, Grounding], ...] = ()
    supports: tuple[Support, ...] = ()
    landmarks: tuple[Landmark, ...] = ()
    prompt: str = ""
    event: str = ""
    events: tuple[tuple[str, str], ...] = ()
    horizon: float | None = None
    roll: float = 0.0
    scale: Scale = field(default_factory=Scale)
    focal: float | None = None
    seconds: float | None = None
