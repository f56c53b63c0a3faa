"""Metres: how high the camera is above each level plane, from things of known size."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.knowledge import Usual
from physagent_studio.program.scene.state import Scale
from physagent_studio.reconstruction.camera.estimate import weighted_median

FLOOR = "floor"


@dataclass(frozen=True, slots=True)
class Measured:
    """An object seen with the camera one unit above its plane.

    units: its longer visible side in units of the camera's height above `plane`.
    """

    name: str
    plane: str
    units: float
    usual: Usual


@dataclass(frozen=True, slots=True)
class Heights:
    """camera: above z = 0, m. tops: height of each plane above the floor, m."""

    camera: float
    tops: Mapping[str, float]
    scale: Scale


def is_stated(scale: Scale) -> bool:
    """Whether a person or a case gave the size; what was assumed before is found anew."""
    return scale.metres is not None and scale.source in ("given", "person")


def solve(
    measured: Sequence[Measured],
    usual_tops: Mapping[str, float],
    given: Scale,
    camera: float | None,
) -> Heights:
    """The camera's height and the tops of slabs, consistent with what is known.

    usual_tops: usual height of each slab's top. given: a size that a person or case states wins
    over every usual size. camera: height above the floor where it is known, else None.
    """
    over = {plane: _above(measured, plane, given) for plane in (FLOOR, *usual_tops)}
    known = {plane: value for plane, value in over.items() if value is not None}
    floor = camera if camera is not None else _floor_height(known, usual_tops)
    tops: dict[str, float] = {FLOOR: 0.0}
    for plane, usual in usual_tops.items():
        tops[plane] = _top(known.get(plane), floor, usual, FLOOR in known or camera is not None)
    if camera is None and FLOOR not in known:
        # Only things on slabs are of known size: the floor is the usual height below them.
        planes = [plane for plane in usual_tops if plane in known]
        if planes:
            best = max(planes, key=lambda plane: known[plane][1])
            floor = known[best][0] + usual_tops[best]
            tops[best] = usual_tops[best]
    return Heights(floor, tops, _source(measured, given))


def _above(measured: Sequence[Measured], plane: str, given: Scale) -> tuple[float, float] | None:
    """Camera height above a plane, m, and the weight of the evidence."""
    items = [item for item in measured if item.plane == plane and item.units > 0]
    if given.metres is not None and is_stated(given):
        for item in items:
            if item.name == given.reference:
                return given.metres / item.units, 1e6
    items = [item for item in items if item.usual.known] or items
    if not items:
        return None
    logs = np.array([np.log(item.usual.metres / item.units) for item in items])
    weights = np.array([1 / item.usual.spread**2 for item in items])
    return float(np.exp(weighted_median(logs, weights))), float(weights.sum())


def _floor_height(
    known: Mapping[str, tuple[float, float]], usual_tops: Mapping[str, float]
) -> float:
    if FLOOR in known:
        stronger = [p for p in known if known[p][1] > 20 * known[FLOOR][1]]
        if stronger:
            best = max(stronger, key=lambda plane: known[plane][1])
            return known[best][0] + usual_tops[best]
        return known[FLOOR][0]
    for plane, usual in usual_tops.items():
        if plane in known:
            return known[plane][0] + usual
    usual_height_m = 1.2  # 0.5..2: of a camera over what it looks at
    return usual_height_m + max(usual_tops.values(), default=0.0)


def _top(over: tuple[float, float] | None, floor: float, usual: float, floor_known: bool) -> float:
    """Height of a slab's top: from sizes seen on it and on the floor, if that is plausible.

    Things whose size is well known on both planes say more than the slab's usual height.
    """
    sure_weight = 20.0  # 1/variance, 5..100: one thing known to 22 % and better
    if over is not None and floor_known:
        top = floor - over[0]
        sure = over[1] > sure_weight
        if (0.05 if sure else 0.25) * usual < top < (5 if sure else 2.5) * usual:
            return top
    return usual if usual < 0.9 * floor else 0.5 * floor


def _source(measured: Sequence[Measured], given: Scale) -> Scale:
    if given.metres is not None and is_stated(given):
        return given
    known = [item for item in measured if item.usual.known]
    if not known:
        first = next(iter(measured), None)
        return Scale(
            reference=first.name if first else None,
            metres=first.usual.metres if first else None,
            source="assumed",
        )
    best = min(known, key=lambda item: item.usual.spread)
    return Scale(reference=best.name, metres=best.usual.metres, source="estimated")
