"""Things that a person marks although other things stand on them: they become supports.

One who boxes "the ball" and "the plank" that it rolls down does not tell things from supports. A
name that knowledge has for a surface, on which another marked thing is seen to stand or on which
the sentence has something roll, and which the sentence itself leaves where it is, is one. So is
what something is told to stand on, or to come off, and is seen on, whatever its name.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from physagent_studio.knowledge import Kind, kind_of, support_kind
from physagent_studio.language import Reading, inventory, read
from physagent_studio.language.bearing import stands_on
from physagent_studio.program.base import Pixel
from physagent_studio.program.scene.state import Click, Grounding, Mark, Support
from physagent_studio.records import Case

Box = tuple[float, float, float, float]

_STILL = frozenset(("be", "rest", "stay", "hit", "touch", "lean"))
"""Senses that leave what they are about in its place, where it is what others stand on."""
_ON = ("down", "up", "along", "on", "off", "from", "over", "atop", "at")
_LEFT = ("off", "from", "along")
"""What is told to go off something, or along it, stands on it to begin with."""


@dataclass(frozen=True, slots=True)
class BearerSettings:
    """Where a marked surface is clicked that other things stand on."""

    below_foot_share: float = 0.05  # 0.01..0.2: of a thing's height, below its box: the surface
    top_share: float = 0.25  # 0.05..0.5: of a surface's box, from above: of what bears nothing yet
    max_click_count: int = 3  # 1..6: of feet that show one surface
    # 0.4..0.9: of the box of what is seen whole, from above: lower down are its legs and the floor
    max_foot_share: float = 0.6
    wide_ratio: float = 2.5  # 1.5..5: of a block's width over what stands on it: it is its ground
    # share, 0.1..0.8: of a thing's height, up to which it is seen before the top of a wall
    max_sunk_share: float = 0.5
    # share, 0.1..0.4: of the box of what bears others, from above, where a top seen edge-on is
    side_share: float = 0.25
    prop_share: float = 0.15  # 0.05..0.3: of a slope's box, from below: what props it ends there


BEARER = BearerSettings()


def with_supports(case: Case) -> Case:
    """The case with those of its objects as supports that others stand on or roll along.

    What props up a slope, and is not spoken of, is part of the picture and no thing.
    """
    marks = dict(case.objects)
    if case.image is None:
        return case
    stock = inventory(case.objects, [(s.name, s.grounding) for s in case.supports], ())
    reading = read(case.prompt, stock)
    seen = {name: _support(name, marks, reading, case.image.shape[0]) for name in marks}
    found = {name: support for name, support in seen.items() if support is not None}
    said = {
        one
        for f in reading.frames
        for one in (*f.patient, *f.agent, *(p.name for _, p in f.places))
    }
    idle = {name: grounding for name, grounding in marks.items() if name not in (*said, *found)}
    slopes = [marks[n].box for n, s in found.items() if support_kind(s.name) == "ramp"]
    props = {n for n, one in idle.items() if any(_is_under(one.box, box) for box in slopes)}
    objects = tuple((n, one) for n, one in case.objects if n not in found and n not in props)
    taken = {one.name for one in case.supports} | {name for name, _ in objects}
    if not found or not objects or any(one.name in taken for one in found.values()):
        return case
    return replace(case, objects=objects, supports=(*case.supports, *found.values()))


def _is_under(own: Box | None, slope: Box | None) -> bool:
    """Whether a thing ends where the box of a slope ends, within its sides: it props that slope."""
    if own is None or slope is None:
        return False
    middle = (own[0] + own[2]) / 2
    low = slope[3] - BEARER.prop_share * (slope[3] - slope[1])
    return slope[0] <= middle <= slope[2] and own[1] > slope[1] and own[3] >= low


def _is_surface(name: str) -> bool:
    kind = kind_of(name)
    return kind is not None and (kind.support is not None or bool(kind.surface))


def _is_wide(name: str, marks: Mapping[str, Grounding], rows: int) -> bool:
    """Whether it carries something and is decidedly wider than all that stands on it."""
    boxes = [marks[one].box for one in _feet_on(name, marks, rows)]
    own, widths = marks[name].box, [box[2] - box[0] for box in boxes if box is not None]
    return bool(widths) and own is not None and own[2] - own[0] > BEARER.wide_ratio * max(widths)


def _support(
    name: str, marks: Mapping[str, Grounding], reading: Reading, rows: int
) -> Support | None:
    """The support that a marked thing is in a picture of so many rows; None for a thing."""
    kind = kind_of(name)
    if kind is not None and kind.support == "wall":
        return _topped(name, marks, reading)
    if any(name in frame.patient and frame.sense not in _STILL for frame in reading.frames):
        return None
    wide = _is_wide(name, marks, rows)
    if not (_is_surface(name) or (wide and (kind is None or bool(kind.top)))):
        return _told(name, marks, reading, rows)
    told = {
        relation
        for frame in reading.frames
        for relation, place in (*frame.places, *frame.begins)
        if place.name == name
    }
    slopes = support_kind(name) == "ramp"
    tilts = kind is not None and kind.surface == "flat" and bool(told & {"down", "up"})
    on = {
        one
        for frame in reading.frames
        if any(place.name == name and relation in _LEFT for relation, place in frame.places)
        for one in frame.patient
    }
    feet = list(_feet_on(name, marks, rows if not (slopes or tilts) else 0, on).values())
    if not feet and not told.intersection(_ON):
        return None
    grounding = _clicked(marks[name], feet, slopes or tilts)
    return Support(name=f"{name}_ramp" if tilts else name, grounding=grounding)


def _told(name: str, marks: Mapping[str, Grounding], reading: Reading, rows: int) -> Support | None:
    """What the sentence has others stand on, and the picture shows them on, whatever it is called.

    Where they stand near its upper end and above it, it is seen from the side: its top ends before
    their feet, and it is as high as what is seen of it below. Of what is known, only that is taken
    for ground: apples hang in a tree. Things of a plain form carry others as they are.
    """
    box, on = marks[name].box, {one for one, below in stands_on(reading).items() if below == name}
    feet = {one: foot for one, foot in _feet_on(name, marks, 0, on).items() if one in on}
    kind = kind_of(name)
    if box is None or not feet or (_is_plain(kind) and not _is_wide(name, marks, rows)):
        return None
    left, top, right, bottom = box
    clicks = _clicked(marks[name], [*feet.values()], slopes=False)
    lowest, over = max(y for _, y in feet.values()), all(_is_over(marks[o].box, top) for o in feet)
    if not over or lowest > top + BEARER.side_share * (bottom - top):
        return Support(name=name, grounding=clicks) if kind is None else None
    corners = ((left, lowest), (right, lowest), (right, top), (left, top))
    ends = [Mark(role="top", x=x, y=y) for x, y in corners]
    # What goes on below the picture shows no foot.
    ends += [Mark(role="foot", x=left, y=bottom)] if bottom < rows - 2 else []
    return Support(name=name, grounding=clicks.model_copy(update={"marks": tuple(ends)}))


def _is_over(box: Box | None, row: float) -> bool:
    """Whether most of a thing is seen above a row of the picture."""
    return box is not None and row > box[3] - BEARER.max_sunk_share * (box[3] - box[1])


def _is_plain(kind: Kind | None) -> bool:
    """Whether things of that kind are fitted by a form with a top, as a box is."""
    return kind is not None and bool(kind.shapes) and kind.shapes[0] != "inflated"


def _topped(name: str, marks: Mapping[str, Grounding], reading: Reading) -> Support | None:
    """The top of a wall, where things are seen to stand on it and to stick out above it: as deep
    as they need it: of a top seen nearly edge-on the front edge is not told from a joint."""
    box, feet, lowest = marks[name].box, list[Pixel](), 0.0
    if box is None or any(name in f.patient and f.sense not in _STILL for f in reading.frames):
        return None
    for other, said in marks.items():
        if other == name or said.box is None:
            continue
        left, top, right, bottom = said.box
        sunk = (bottom - box[1]) / (bottom - top)
        if top < box[1] and 0 <= sunk < BEARER.max_sunk_share and left < box[2] and right > box[0]:
            feet.append(((left + right) / 2, bottom))
            lowest = max(lowest, bottom + BEARER.below_foot_share * (bottom - top))
    if not feet:
        return None
    corners = ((box[0], lowest), (box[2], lowest), (box[2], box[1]), (box[0], box[1]))
    points = tuple(Click(x=x, y=y) for x, y in feet[: BEARER.max_click_count])
    top = tuple(Mark(role="top", x=x, y=y) for x, y in corners)
    return Support(name=f"{name}_ledge", grounding=Grounding(points=points, box=box, marks=top))


def _feet_on(
    name: str, marks: Mapping[str, Grounding], rows: int, on: Collection[str] = ()
) -> dict[str, tuple[float, float]]:
    """By their names, pixels just below the boxes of what is seen to stand within its own box.

    rows: of the picture, where below the upper part of the box there are legs; else 0. on: what
    the sentence has stand there, in whatever part of the box.
    """
    box, found = marks[name].box, {}
    if box is None:
        return {}
    lowest = box[1] + BEARER.max_foot_share * (box[3] - box[1])
    if not rows or box[3] >= rows - 2:
        lowest = box[3]
    for other, said in marks.items():
        if other == name or said.box is None:
            continue
        left, top, right, bottom = said.box
        x, y = (left + right) / 2, bottom + BEARER.below_foot_share * (bottom - top)
        hidden = any(
            one.box[0] <= x <= one.box[2] and one.box[1] <= y <= one.box[3]
            for third, one in marks.items()
            if third not in (name, other) and one.box is not None
        )
        low = box[3] if other in on else lowest
        if box[0] <= x <= box[2] and box[1] <= y <= low and not hidden:
            found[other] = (x, y)
    return found


def _clicked(said: Grounding, feet: Sequence[Pixel], slopes: bool) -> Grounding:
    """What shows the surface: its own clicks, else where others stand on it, within its box."""
    if said.points or said.box is None:
        return said
    left, top, right, bottom = said.box
    spots = feet or [((left + right) / 2, top + BEARER.top_share * (bottom - top))]
    if slopes and not feet:
        return said
    points = tuple(Click(x=round(x, 1), y=round(y, 1)) for x, y in spots[: BEARER.max_click_count])
    return Grounding(points=points, box=said.box)
