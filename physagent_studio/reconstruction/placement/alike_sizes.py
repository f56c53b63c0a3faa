"""Things of one kind are about equally large: their feet and their sizes say together how far.

A foot that is read a few pixels too low, where a reflection begins, makes a thing nearer and
smaller than its like. Where several things of one name stand on one plane and look alike, the
height and width that they share and the row of each foot are found together, by least squares.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.grounding.same_kind import kind_name
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.survey.survey import Survey


@dataclass(frozen=True, slots=True)
class AlikeSettings:
    """When things of one name are taken to be equally large."""

    min_upward: float = 0.999  # cosine, 0.99..1: of the own axis of what stands level
    foot_px: float = 2.5  # 0.5..8: doubt of the row of a foot
    foot_share: float = 0.04  # 0..0.2: the same, of the height that is seen
    # 0.2..5: of a height and of a mean width, which many rows tell
    size_doubts_px: tuple[float, float] = (1.5, 0.6)
    same_share: float = 0.3  # 0.1..1: of a kind's spread, that of its like in one picture
    min_spread_log: float = 0.015  # 0.005..0.05: no two things are made more alike
    # 0.05..0.4: what is called the same and differs more is not the same
    max_spread_log: float = 0.12
    max_shape_log: float = 0.18  # 0.05..0.5: by which two silhouettes' proportions may differ
    max_sigmas: float = 3.0  # 2..5: a size that is farther off is another size
    min_change_share: float = 2e-3  # 0..0.01: of a depth: less is not seen
    max_touching_share: float = 0.2  # 0..0.5: of an outline beside others: more of it may be hidden


ALIKE = AlikeSettings()


@dataclass(frozen=True, slots=True)
class Stood:
    """A thing that stands on a level plane. foot, top, horizon: rows, pixels. width: pixels.

    plane: what it stands on. spread: of the logarithm of its kind's size. fixed: somebody stated
    where it is; it speaks for the others and stays.
    """

    name: str
    plane: str
    foot: float
    horizon: float
    top: float
    width: float
    spread: float
    fixed: bool = False

    @property
    def below(self) -> float:
        """Rows from the horizon to its foot: one over its distance, in the camera's terms."""
        return max(self.foot - self.horizon, 1.0)

    @property
    def doubt(self) -> float:
        """Standard deviation of the row of its foot, pixels."""
        return max(ALIKE.foot_px, ALIKE.foot_share * self.pixels[0])

    @property
    def pixels(self) -> tuple[float, float]:
        """Its height and width in the picture."""
        return max(self.foot - self.top, 1.0), max(self.width, 1.0)

    @property
    def sizes(self) -> tuple[float, float]:
        """Logarithms of its height and width, in heights of the camera."""
        return math.log(self.pixels[0] / self.below), math.log(self.pixels[1] / self.below)

    @property
    def gains(self) -> tuple[float, float]:
        """What a row that the foot is moved up adds to `sizes`, its top where it is seen."""
        return 1 / self.below - 1 / self.pixels[0], 1 / self.below

    @property
    def proportion(self) -> float:
        """Logarithm of height over width of the silhouette."""
        return math.log(self.pixels[0] / self.pixels[1])


def shared_places(
    order: Sequence[SceneObject],
    put: Mapping[str, SceneObject],
    stances: Mapping[str, Stance],
    masks: Mapping[str, BoolArray],
    read: Survey,
) -> dict[str, tuple[float, float]]:
    """Where things stand (x, y) that are as large as their like, if not where they were put.

    order: the objects as they are stated, put: in their places. Only what stands by itself on a
    level plane and is seen whole; what a person has set stays.
    """
    stood, camera = [], read.camera
    for item in order:
        name, stance, usual = item.name, stances[item.name], read.usual[item.name]
        level = (
            matrix_of(put[name].rotation)[2, 2] > ALIKE.min_upward and read.on[name] in read.tops
        )
        if not (level and usual.known and seen_whole(name, masks)):
            continue
        fixed = item.shape is not None or item.position is not None
        width = mean_width(masks[name], camera)
        foot, top, row = stance.foot[1], stance.box[1], camera.horizon
        stood.append(Stood(name, read.on[name], foot, row, top, width, usual.spread, fixed))
    out, eye = {}, np.asarray(camera.position[:2])
    for name, factor in shared_distances(stood).items():
        x, y, _ = put[name].position or (0.0, 0.0, 0.0)
        spot = eye + factor * (np.array([x, y]) - eye)
        out[name] = (float(spot[0]), float(spot[1]))
    return out


def shared_distances(things: Iterable[Stood]) -> dict[str, float]:
    """What each thing's distance is to be multiplied by; those that stay are left out."""
    groups: dict[tuple[str, str], list[Stood]] = {}
    for thing in things:
        groups.setdefault((kind_name(thing.name), thing.plane), []).append(thing)
    out: dict[str, float] = {}
    for members in groups.values():
        out.update(_shared(_like(members)))
    return out


def _like(members: list[Stood]) -> list[Stood]:
    """Those whose silhouettes have the proportions of most."""
    middle = float(np.median([one.proportion for one in members]))
    return [one for one in members if abs(one.proportion - middle) <= ALIKE.max_shape_log]


def _shared(members: list[Stood]) -> dict[str, float]:
    """Factors of the distances, from the rows e by which the feet are moved up.

    They minimise Σ (eᵢ / footᵢ)² + Σ ((lᵢ + gᵢ eᵢ − L) / same)² over e and both L. l: logarithms
    of height and width, g: their gain by row; L: of the height and the width that all share.
    """
    if len(members) < 2 or all(one.fixed for one in members):
        return {}
    same = float(
        np.clip(
            ALIKE.same_share * min(one.spread for one in members),
            ALIKE.min_spread_log,
            ALIKE.max_spread_log,
        )
    )
    count = len(members)
    sizes = np.array([one.sizes for one in members])
    gains = np.array([one.gains for one in members])
    rows, values = np.zeros((3 * count, count + 2)), np.zeros(3 * count)
    for k, one in enumerate(members):
        rows[k, k] = 1 / (1e-6 if one.fixed else one.doubt)
        for axis in range(2):
            at = count + 2 * k + axis
            doubt = math.hypot(same, ALIKE.size_doubts_px[axis] / one.pixels[axis])
            rows[at, k], rows[at, count + axis] = gains[k, axis] / doubt, -1 / doubt
            values[at] = -sizes[k, axis] / doubt
    found = np.linalg.lstsq(rows, values, rcond=None)[0]
    off = _misfits(rows @ found - values, count)
    if off.max() > ALIKE.max_sigmas:
        return _shared([one for k, one in enumerate(members) if k != int(off.argmax())])
    below = np.array([one.below for one in members])
    factors = below / np.maximum(below - found[:count], 0.2 * below)
    return {
        one.name: float(factor)
        for one, factor in zip(members, factors, strict=True)
        if abs(factor - 1) > ALIKE.min_change_share and not one.fixed
    }


def _misfits(residuals: FloatArray, count: int) -> FloatArray:
    """(count,) the largest misfit of each thing, in standard deviations."""
    feet, sizes = np.abs(residuals[:count]), np.abs(residuals[count:]).reshape(count, 2)
    return np.maximum(feet, sizes.max(axis=1))


def mean_width(mask: BoolArray, camera: Camera) -> float:
    """Mean width in pixels of what a mask (H, W) shows, as if it were seen in the middle.

    Uprights lean where the camera looks down, so the width of the whole box would not do; beside
    the middle a picture is stretched.
    """
    x0, y0, x1, y1 = bounds(mask)
    aside = ((x0 + x1) / 2 - camera.principal[0]) / camera.focal
    return float(np.count_nonzero(mask)) / max(y1 - y0, 1) / math.hypot(1.0, aside)


def seen_whole(name: str, masks: Mapping[str, BoolArray]) -> bool:
    """Whether a silhouette shows all of a thing: nothing in front of it, no border cuts it off."""
    mask = masks[name]
    x0, y0, x1, y1 = bounds(mask)
    rows, columns = mask.shape
    if x0 <= 1 or y0 <= 1 or x1 >= columns - 1 or y1 >= rows - 1:
        return False
    around = grow(mask, 2) & ~mask
    others = [other for key, other in masks.items() if key != name]
    if not others:
        return True
    beside = np.any(others, axis=0) & around
    return int(np.count_nonzero(beside)) <= ALIKE.max_touching_share * int(np.count_nonzero(around))
