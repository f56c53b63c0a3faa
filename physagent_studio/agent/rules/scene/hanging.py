"""What hangs in the air when the event begins, by the words of the prompt and by the clicks."""

import numpy as np

from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, Layout, level
from physagent_studio.knowledge import grows, is_sheet, kind_of, usual_size
from physagent_studio.language import EventFrame, Reading
from physagent_studio.program.preflight.scaling import farther
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.program.scene.state import Grounding, SceneObject, SceneState
from physagent_studio.records import Case

Spot = tuple[float, float]

_FALLS = ("fall", "land", "descend", "drop")
_COMES = ("move", "leave", "lose_support", *_FALLS)
_LETS_GO = ("slip", "leave", "lose_support")
"""Told of what hung before it falls, where it is not told from what known thing it comes."""
_INTO = ("in", "into", "inside", "on", "onto")


def in_the_air(case: Case, reading: Reading) -> frozenset[str]:
    """Objects that the prompt has above something and not on it when it begins.

    Either it says so ("hangs above the stool"), or it lets a thing fall into or onto another one
    over which the picture shows it with nothing in between.
    """
    spots = {
        name: spot
        for name, grounding in (*case.objects, *((s.name, s.grounding) for s in case.supports))
        if (spot := _spot(grounding)) is not None
    }
    boxes = {s.name: s.grounding.box for s in case.supports if s.grounding.box is not None}
    found: set[str] = set()
    acted: set[str] = set()
    for frame in reading.frames:
        for name in frame.patient:
            if name in acted:
                continue
            said = frame.sense in ("hang", "be") and frame.place("above") is not None
            below = frame.place(*_INTO) if frame.sense in _FALLS else None
            from_there = frame.place("off", "from") is not None
            over = below is not None and _over(name, below.name, spots, boxes.get(below.name))
            if said or (over and not from_there):
                found.add(name)
        if frame.sense not in _LETS_GO or frame.places:
            acted |= set(frame.patient)
    return frozenset(found)


def from_nowhere(case: Case, reading: Reading, layout: Layout) -> frozenset[str]:
    """Objects that fall or swing although the scene has them on the ground: they hung in the air.

    Told of things that nothing pushes, that lie on nothing else and cannot fall over: what is
    round or flat, or comes from something that the picture does not name ("from its branch"), or
    falls straight down.
    And of what is said to swing, or sways though it is round.
    """
    found: set[str] = set()
    told: set[str] = set()
    for index, frame in enumerate(reading.frames):
        later = reading.frames[index:]
        for name in frame.patient:
            first = name not in told
            told.add(name)
            falls = frame.sense in _FALLS and not frame.agent and not frame.negated
            if not layout.has(name) or layout.carrier(name) != layout.ground():
                continue
            place = frame.place("off", "from")
            if place is not None and place.kind == "landmark" and frame.sense in _COMES:
                # "Comes loose from the line and falls down": nothing falls from a mark on the
                # ground.
                falls = not (frame.agent or frame.negated) and any(
                    f.sense in _FALLS and name in f.patient for f in later
                )
                found |= {name} if falls else set()
            elif first and frame.sense == "sway" and _swings(case.prompt, layout, name):
                found |= set() if frame.negated or frame.agent else {name}
            elif not first or not falls or place is not None or _falls_aside(frame, layout):
                continue
            elif (
                "straight" in frame.manner
                or _cannot_topple(layout, name)
                or _from_unknown(case.prompt, reading)
            ):
                found.add(name)
    return frozenset(found)


def _falls_aside(frame: EventFrame, layout: Layout) -> bool:
    """ "Is dropped into the cup", beside which it stands: a hand brings it there. What hangs over
    a thing is told by `in_the_air`."""
    below = frame.place(*_INTO)
    return below is not None and below.kind == "object" and layout.has(below.name)


def may_hang(case: Case, reading: Reading, layout: Layout) -> frozenset[str]:
    """Objects that the scene has on the ground, that fly off by themselves and come down, and that
    are seen straight above another one: in the air over it, or far behind it; `sizes_off` tells."""
    spots = {name: spot for name, given in case.objects if (spot := _spot(given)) is not None}
    found: set[str] = set()
    for name in spots:
        told = [f for f in reading.frames if name in f.patient]
        flies = bool(told) and told[0].sense == "fly" and not told[0].agent
        lands = any(f.sense in (*_FALLS, "bounce") and not f.negated for f in told)
        on_ground = layout.has(name) and layout.carrier(name) == layout.ground()
        if flies and lands and on_ground and not told[0].negated:
            found |= {name} if any(_over(name, other, spots, None) for other in spots) else set()
    return frozenset(found)


def sizes_off(state: SceneState) -> float:
    """By how much the sizes of a scene are not the usual ones, in squared spreads."""
    off = 0.0
    for item in state.objects:
        usual = usual_size(item.name)
        if usual.known and item.shape is not None:
            longest = float(outline_of(item.shape).size.max())
            off += float(np.log(longest / usual.metres) / usual.spread) ** 2
    return off


def as_far_as_told(state: SceneState, reading: Reading) -> SceneState:
    """The state with what hangs where the sentence has it: as far from the camera as the thing
    that it is told to hit, or where the ground that it falls to is in the picture.

    How far away a hanging thing is no picture tells; twice as far, it is twice as large.
    """
    layout = Layout(state)
    blows = [f for f in reading.frames if f.sense == "hit" and f.agent and not f.negated]
    met = {name: frame.patient[0] for frame in reversed(blows) for name in frame.agent}
    falling = [f for f in reading.frames if f.sense in (*_FALLS, "break", "bounce")]
    falls = {name for frame in falling if not frame.negated for name in frame.patient}
    items = list(state.objects)
    for index, item in enumerate(items):
        hangs = in_air(item) and item.aloft != "floats"
        if not hangs or item.source in ("given", "person") or item.position is None:
            continue
        share, other = 1.0, met.get(item.name)
        if other is not None and layout.has(other):
            share = _share_to(layout, item, layout.position(other))
        elif item.name in falls:
            share = _share_to_land(layout, item)
        if share != 1.0 and state.camera is not None:
            items[index] = farther(item, np.asarray(state.camera.position), share)
    return state.model_copy(update={"objects": tuple(items)})


def _share_to(layout: Layout, item: SceneObject, other: FloatArray) -> float:
    """Times its distance at which it is level with a place (3,), as the camera looks."""
    camera = layout.state.camera
    if camera is None or item.position is None:
        return 1.0
    eye, ahead = np.asarray(camera.position), level(camera.matrix[:, 2])
    own, wanted = (np.asarray(item.position) - eye) @ ahead, (other - eye) @ ahead
    return float(wanted / own) if own > 0 and wanted > 0 else 1.0


def _share_to_land(layout: Layout, item: SceneObject) -> float:
    """Times its distance at which the ground below it is well in the picture; 1 where it is, or
    where it would have to be much larger for that."""
    camera, place = layout.state.camera, np.asarray(item.position)
    if camera is None:
        return 1.0
    low_share = 0.92  # 0.8..1: of the picture's height, lowest row where it is well seen to land
    eye, shares = np.asarray(camera.position), np.geomspace(1.0, _largest(item), 40)
    feet = eye + shares[:, None] * (place - eye)
    feet[:, 2] = layout.ground_height()
    rows = camera.project(feet)[0][:, 1]
    seen = np.flatnonzero(rows <= low_share * camera.size[1])
    return float(shares[seen[0]]) if len(seen) and rows[0] > camera.size[1] else 1.0


def _largest(item: SceneObject) -> float:
    """Times its size that it may be, by what is known of such things; at least 1."""
    most, many = 5.0, 3.0  # 1.5..8: of what is not known; 1..5: spreads off the usual size
    usual = usual_size(item.name)
    if not usual.known or item.shape is None:
        return most
    longest = float(outline_of(item.shape).size.max())
    return float(np.clip(usual.metres * np.exp(many * usual.spread) / longest, 1.0, most))


def bounces_unseen(reading: Reading, layout: Layout, name: str) -> bool:
    """Whether it hangs where it would come down below the picture, and is told to bounce there:
    then it lies on the ground and has to be tossed up first."""
    camera = layout.state.camera
    told = any(f.sense == "bounce" and name in f.patient for f in reading.frames)
    if camera is None or not told or not layout.has(name):
        return False
    x, y, _ = layout.position(name)
    foot = np.array([[x, y, layout.ground_height()]])
    return float(camera.project(foot)[0][0, 1]) > camera.size[1]


def _swings(prompt: str, layout: Layout, name: str) -> bool:
    """Whether it hangs that sways: what is round cannot sway where it lies, and what stands
    rocks but does not swing, if it has no root."""
    said = any(word.startswith(("swing", "swung")) for word in prompt.lower().split())
    return layout.rolls(name) or (said and not grows(name) and not is_sheet(name))


def _cannot_topple(layout: Layout, name: str) -> bool:
    """Whether it has no side to fall over to: it is round, or lies already."""
    flat = 0.6  # 0.3..0.9: of its height over its length
    kind = kind_of(name)
    if layout.rolls(name):
        return True
    if kind is not None and kind.is_alive:
        return False
    across = (WAYS["right"], WAYS["away"])
    long = max(layout.extent(name, one) + layout.extent(name, -one) for one in across)
    return layout.height(name) < flat * long


def _from_unknown(prompt: str, reading: Reading) -> bool:
    """Whether something comes from, or off, what the picture does not name."""
    words = "".join(c if c.isalpha() else " " for c in prompt.lower()).split()
    strange = {word for said in reading.not_understood for word in said.lower().split()}
    return any(
        word in ("from", "off") and strange & set(words[i + 1 : i + 4])
        for i, word in enumerate(words)
    )


def _spot(grounding: Grounding) -> Spot | None:
    """The middle of the clicks inside, else that of the box, in pixels."""
    inside = [(click.x, click.y) for click in grounding.points if click.label]
    if inside:
        return sum(x for x, _ in inside) / len(inside), sum(y for _, y in inside) / len(inside)
    if grounding.box is None:
        return None
    x0, y0, x1, y1 = grounding.box
    return (x0 + x1) / 2, (y0 + y1) / 2


def _over(
    name: str, below: str, spots: dict[str, Spot], box: tuple[float, float, float, float] | None
) -> bool:
    """Whether the picture shows one thing straight above the other and nothing between them.

    box: around the lower one, left, top, right, bottom: what is above it is above any part of it.
    """
    if name not in spots or below not in spots:
        return False
    (x, y), (to_x, to_y) = spots[name], spots[below]
    if box is not None and y < box[1]:
        to_x, to_y = min(max(x, box[0]), box[2]), box[1]
    drop = to_y - y
    if drop <= 0 or abs(to_x - x) > 0.35 * drop:
        return False
    return not any(
        y < other_y < to_y and abs(other_x - x) < 0.35 * drop
        for other, (other_x, other_y) in spots.items()
        if other not in (name, below)
    )


_BORNE = frozenset({"wind", "drift", "push"})
"""What moves a thing that floats without taking it up or down."""


def kept_afloat(state: SceneState, reading: Reading) -> SceneState:
    """What is lighter than air, hangs in it and is only blown or pushed along keeps its height."""
    told: dict[str, set[str]] = {}
    for frame in reading.frames:
        for name in frame.patient:
            told.setdefault(name, set()).add(frame.sense)

    def floating(item: SceneObject) -> bool:
        kind = kind_of(item.name)
        borne = told.get(item.name, set())
        buoyant = kind is not None and kind.buoyant and item.body.kind == "rigid"
        return buoyant and item.aloft == "hangs" and bool(borne) and borne <= _BORNE

    objects = [
        item.model_copy(update={"aloft": "floats"}) if floating(item) else item
        for item in state.objects
    ]
    return state.model_copy(update={"objects": tuple(objects)})
