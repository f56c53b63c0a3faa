"""What a person clicks or types beside object points: horizon, one size, parts of supports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

from physagent_studio.exchange.plain_yaml import Place
from physagent_studio.knowledge import is_stairs, support_kind
from physagent_studio.program.scene.state import Mark, Scale

if TYPE_CHECKING:
    from physagent_studio.exchange.case_reader import CaseReader

Role = Literal["toe", "top", "foot", "end"]
MARKS: tuple[Role, ...] = get_args(Role)
SMALLEST, LARGEST = 1e-3, 1e3
"""Sizes that may be typed, m."""
STEEPEST, LEVEL, APART = 45.0, 0.3, 0.2
"""Degrees by which a horizon is tilted at most, and below which it is level for all that clicks
tell; and how far apart these have to be to tell it, in widths of the picture."""

_COUNTS: dict[str, dict[Role, tuple[int, int]]] = {
    "ramp": {"toe": (1, 2), "top": (1, 1), "foot": (0, 1), "end": (0, 1)},
    "stairs": {"toe": (1, 2), "top": (1, 12), "foot": (0, 1), "end": (0, 1)},
    "slab": {"top": (3, 8), "foot": (0, 1)},
    "wall": {"foot": (2, 2)},
    "floor": {},
}
"""How many clicks each kind of support takes, for each part."""

_NEEDS = {
    "ramp": "a ramp takes toe (one click, or both corners of the lower edge), top, and if they "
    "are seen foot and end",
    "stairs": "stairs take toe (one click, or both corners of the lowest edge), top (the edge of "
    "the uppermost step, or of every step from below), and if they are seen foot and end",
    "slab": "a level support takes top (3 to 8 corners of its upper side), and foot if it is seen",
    "wall": "a wall takes foot (two clicks on the line where it meets the ground)",
    "floor": "the ground takes none of toe, top, foot and end",
}


def marks_of(
    reader: CaseReader, name: str, place: Place, entry: Mapping[str, Any], size: tuple[int, int]
) -> tuple[Mark, ...]:
    """The marks of a support's entry, in the order of `MARKS`. size: (width, height) of the photo.

    Raises InputError where their number does not fit what a support of that name is.
    """
    clicks: dict[Role, tuple[tuple[float, float], ...]] = {
        role: _clicks(reader, (*place, role), entry[role], size) for role in MARKS if role in entry
    }
    if not clicks:
        return ()
    kind = "stairs" if is_stairs(name) else support_kind(name)
    counts = _COUNTS[kind]
    for role in (*clicks, *counts):
        least, most = counts.get(role, (0, 0))
        given = len(clicks.get(role, ()))
        if not least <= given <= most:
            where = (*place, role) if role in clicks else place
            raise reader.fail(where, f"'{name}' has {given} clicks for {role}: {_NEEDS[kind]}")
    return tuple(Mark(role=role, x=x, y=y) for role in clicks for x, y in clicks[role])


@dataclass(frozen=True, slots=True)
class StatedHorizon:
    """The horizon's row in the middle column, pixels, and the camera's roll, degrees clockwise."""

    row: float
    roll: float = 0.0


def horizon_of(reader: CaseReader, size: tuple[int, int]) -> StatedHorizon | None:
    """The horizon of a photo of `size`; None where it is open.

    A number is the row itself and may lie outside the picture; two clicks are on the horizon, and
    say how it is tilted; four clicks are two edges that are level and parallel in the world, and
    meet on it.
    """
    data = reader.doc.data.get("horizon")
    place: Place = ("horizon",)
    if data is None:
        return None
    if not isinstance(data, list):
        row = reader.number(place, data)
        if too_far(row, size[1]):
            raise reader.fail(place, f"the horizon at row {row:g} is too far from the picture")
        return StatedHorizon(row)
    clicks = _clicks(reader, place, data, size)
    row = _level_row(clicks, size[0] / 2)
    if row is None:
        raise reader.fail(
            place,
            "horizon must be a row, two clicks on it from left to right, or four clicks: two "
            "level edges that are parallel in the world and meet in the picture's plane",
        )
    roll = _roll(clicks, size[0]) if len(clicks) == 2 else 0.0
    if abs(roll) > STEEPEST:
        raise reader.fail(
            place, f"the horizon is tilted by {abs(roll):.0f}°; at most {STEEPEST:.0f}° are allowed"
        )
    return StatedHorizon(row, roll)


def too_far(row: float, height: int) -> bool:
    """Whether a row, pixels, cannot be the horizon of a picture of that height."""
    return not abs(row - height / 2) <= 10 * height


def _roll(clicks: Sequence[tuple[float, float]], width: int) -> float:
    """Degrees by which the camera is turned clockwise that sees two places on the horizon."""
    (x0, y0), (x1, y1) = sorted(clicks)
    roll = math.degrees(math.atan2(y0 - y1, x1 - x0))
    return round(roll, 3) if abs(roll) > LEVEL and x1 - x0 > APART * width else 0.0


def _level_row(clicks: Sequence[tuple[float, float]], middle: float) -> float | None:
    """The row that two clicks on the horizon, or two parallel edges, give; None for neither."""
    if len(clicks) == 2:
        (x0, y0), (x1, y1) = clicks
        return y0 + (middle - x0) * (y1 - y0) / (x1 - x0) if abs(x1 - x0) > 1 else None
    if len(clicks) != 4:
        return None
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = clicks
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    cross = ux * vy - uy * vx
    if abs(cross) < 1e-3 * math.hypot(ux, uy) * math.hypot(vx, vy) or not cross:
        return None
    along = ((cx - ax) * vy - (cy - ay) * vx) / cross
    return ay + along * uy


def scale_of(reader: CaseReader, known: Sequence[str]) -> Scale:
    """`scale: {reference: name, metres: size}` with source `given`; open where there is none."""
    data = reader.doc.data.get("scale")
    place: Place = ("scale",)
    if data is None:
        return Scale()
    if not isinstance(data, dict):
        raise reader.fail(place, "scale must be {reference: name, metres: size}")
    reader.known(place, data, ("reference", "metres"))
    name = data.get("reference")
    if name not in known:
        listed = ", ".join(known) or "none"
        raise reader.fail(
            (*place, "reference"), f"scale needs one of the objects as reference (known: {listed})"
        )
    metres = reader.number((*place, "metres"), data.get("metres"))
    if not SMALLEST <= metres <= LARGEST:
        raise reader.fail(
            (*place, "metres"), f"{metres:g} m is no size of a thing ({SMALLEST:g} … {LARGEST:g})"
        )
    return Scale(reference=str(name), metres=metres, source="given")


def _clicks(
    reader: CaseReader, place: Place, data: Any, size: tuple[int, int]
) -> tuple[tuple[float, float], ...]:
    """[x, y], or a list of such, as clicks inside the picture."""
    single = isinstance(data, list) and data and not any(isinstance(one, list) for one in data)
    listed = [data] if single else data
    if not isinstance(listed, list) or not listed or len(listed) > 16:
        raise reader.fail(place, "needs a click [x, y], or a list of at most 16 of them")
    found = []
    for index, point in enumerate(listed):
        where = place if single else (*place, index)
        if not isinstance(point, list) or len(point) != 2:
            raise reader.fail(where, "a click must be [x, y]")
        found.append(reader.pair(where, point, size))
    return tuple(found)
