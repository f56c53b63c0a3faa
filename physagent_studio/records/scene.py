"""`Scene`: what reconstruction derives from a picture and a `SceneState`."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.state import SceneState
from physagent_studio.records.case import Image

IntArray = NDArray[np.int32]


@dataclass(frozen=True, eq=False, slots=True)
class Shading:
    """How light falls on a thing, by the direction in which its surface faces.

    terms: for red, green and blue, the log of brightness, 1 where it is 0: the factors of the 16
    functions of the unit normal, world frame, that `rendering.lit` lists. towards: unit, from the
    thing to the camera, world: normals are told about that side alone. built: wxyz R_world_body as
    the photo shows it. gloss: (K, K) uint8, the share of white in the colours, in 255ths, by the
    normal as seen from `towards`, its right and its up from −1 to 1 (the first row is up); None
    for none. shade: (K, K) or, by colour, (K, K, 3) uint8, the same of the brightness that is left
    where the ground or what stands by keeps light off.
    """

    terms: tuple[tuple[float, ...], ...]
    towards: tuple[float, float, float]
    built: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    gloss: NDArray[np.uint8] | None = None
    shade: NDArray[np.uint8] | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """A textured triangle mesh in the body frame (origin at the centre of mass), m.

    vertices: (V, 3) float64. faces: (F, 3) int32, counter-clockwise seen from outside.
    uv: (V, 2) float64 pixels in `texture`, (0, 0) its top left corner; None without texture.
    texture: (h, w, 3) uint8 RGB, or None. color: RGB 0–255 where there is no texture.
    shading: the light that the texture is without; None where it carries the photo's own.
    solid: vertices and faces of what collides; None where that is what is drawn.
    """

    vertices: FloatArray
    faces: IntArray
    uv: FloatArray | None = None
    texture: Image | None = None
    color: tuple[int, int, int] = (160, 160, 160)
    shading: Shading | None = None
    solid: tuple[FloatArray, IntArray] | None = None

    @property
    def colliding(self) -> Mesh:
        """The surface that collides, without a look of its own where it has none."""
        return self if self.solid is None else Mesh(*self.solid)


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """One mask that a segmenter offers: (H, W) bool, and how it scores it (0 … 1)."""

    mask: BoolArray
    score: float
    method: str


@dataclass(frozen=True, slots=True)
class ShapeOffer:
    """One kind of shape that an object's mask may be: how its silhouette covers the mask (IoU),

    and its merit, which counts the kind's freedom against it and the object's name for it.
    """

    kind: str
    merit: float
    iou: float


@dataclass(frozen=True, slots=True)
class LearnedUse:
    """What a learned model did for a scene. made: the things whose masks are its, or `background`.

    failed: why the embedded way did all of its work, "" where it did not fail.
    """

    model: str
    made: tuple[str, ...] = ()
    failed: str = ""


@dataclass(frozen=True, slots=True)
class Finding:
    """One check of stage 1: what was measured in the reconstruction and whether that is fine."""

    name: str
    subject: str
    measured: float
    threshold: float
    unit: str
    ok: bool
    kind: Literal["points", "mask", "camera", "geometry", "placement", "support"]
    text: str


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """A reconstructed scene; `state` is the given one with every open field filled.

    masks: (H, W) bool per object. meshes: visual mesh per object, body frame.
    candidates: alternatives per object, best first. plate: the photo with the objects filled
    in; None without a photo. support_meshes: for display, world frame.
    findings: the checks that stage 1 judges. hash: of everything that went in.
    shapes: the kinds of shape that each object's mask may be, best first.
    sureness: per object whose mask nobody chose, the probability (0 … 1) that its IoU with the
    thing is above .8.
    learned: the learned models that were there for it; without any the embedded way made it all.
    """

    state: SceneState
    photo: Image | None
    plate: Image | None
    masks: MappingProxyType[str, BoolArray]
    meshes: MappingProxyType[str, Mesh]
    support_meshes: MappingProxyType[str, Mesh]
    candidates: MappingProxyType[str, tuple[Candidate, ...]]
    findings: tuple[Finding, ...]
    hash: str
    shapes: MappingProxyType[str, tuple[ShapeOffer, ...]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    sureness: MappingProxyType[str, float] = field(default_factory=lambda: MappingProxyType({}))
    learned: tuple[LearnedUse, ...] = ()
