"""What a picture or a sentence leaves open: said with its probability, and asked about."""

import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from physagent_studio.program.scene.camera import Camera
from physagent_studio.records.scene import Scene

SURE_FROM = 0.8
"""Probability from which a mask is sure; the IoU, too, that the probability speaks of."""
DOUBTED_BELOW = 0.5
"""Probability below which something is doubted: more likely wrong than right."""
HORIZON_OFF = 0.21
"""Shares of the picture's height by which a horizon may be off before places come out wrong."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something that is more likely wrong than right, and the one thing that helps most.

    kind: a thing's mask, the camera, or a word of the sentence. name: the thing or the word.
    probability: 0 … 1, that it is right. helps: what a person can do, as a request.
    """

    kind: Literal["mask", "camera", "word"]
    name: str
    probability: float
    helps: str

    @property
    def text(self) -> str:
        """The doubt in one sentence."""
        what = {
            "mask": f"the mask of {self.name} is doubtful",
            "camera": "how the camera was held is doubtful",
            "word": f"'{self.name}' was not understood",
        }[self.kind]
        return f"{what} ({100 * self.probability:.0f} % sure): {self.helps}"


def doubts_of(scene: Scene | None, words: Iterable[str] = ()) -> tuple[Doubt, ...]:
    """All that is doubted of a scene, the least probable first, then words not understood."""
    found: tuple[Doubt, ...] = ()
    if scene is not None:
        height = None if scene.photo is None else scene.photo.shape[0]
        boxed = {o.name for o in scene.state.objects if o.grounding.box is not None}
        found = doubts_about(scene.sureness, scene.state.camera, height, boxed)
    return (*found, *(Doubt("word", word, 0.0, "say it in other words") for word in words))


def doubts_about(
    sureness: Mapping[str, float],
    camera: Camera | None,
    height: int | None,
    boxed: Container[str] = (),
) -> tuple[Doubt, ...]:
    """What is doubted of masks, by how sure each is, and of a camera; the least probable first.

    height: of the photo, pixels; None without one. boxed: things that have a box around them.
    """
    found = [*_of_masks(sureness, boxed), *_of_camera(camera, height)]
    return tuple(sorted(found, key=lambda doubt: (doubt.probability, doubt.name)))


def _of_masks(sureness: Mapping[str, float], boxed: Container[str]) -> list[Doubt]:
    return [
        Doubt("mask", name, probability, _helping(name.replace("_", " "), name in boxed))
        for name, probability in sureness.items()
        if probability < DOUBTED_BELOW
    ]


def _helping(thing: str, is_boxed: bool) -> str:
    if not is_boxed:
        return f"draw a box around {thing}"
    return f"click on what is missing of {thing}, or paint over it in the studio"


def _of_camera(camera: Camera | None, height: int | None) -> list[Doubt]:
    """The horizon is taken as normally distributed about its estimate."""
    if height is None or camera is None or camera.confirmed or not camera.horizon_sigma:
        return []
    allowed = HORIZON_OFF * height
    probability = math.erf(allowed / (math.sqrt(2.0) * camera.horizon_sigma))
    if probability >= DOUBTED_BELOW:
        return []
    return [Doubt("camera", "camera", probability, "click the ends of the horizon")]
