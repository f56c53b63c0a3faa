"""How things hold together, where the event asks for more than a rigid body."""

import math
from dataclasses import dataclass

from physagent_studio.agent.rules.scene.measures import WAYS, Layout
from physagent_studio.agent.rules.scene.mechanics import G
from physagent_studio.knowledge import grows, is_flag, is_loose, is_sheet, stiffness_of
from physagent_studio.language import EventFrame, Reading
from physagent_studio.program.scene.bodies import Body, Breakable, Cloth, Granular, Soft
from physagent_studio.program.scene.materials import density_of
from physagent_studio.program.scene.plants import plant_body


@dataclass(frozen=True, slots=True)
class WobbleSettings:
    """How what is soft swings that is told to."""

    # ratio, 0.01..0.1: of critical damping: gels and foams that are seen to wobble swing some times
    damping_ratio: float = 0.03


WOBBLE = WobbleSettings()


def bodies_for(reading: Reading, layout: Layout) -> dict[str, Body]:
    """Bodies by object name, only for objects that have to bend, break, flow or sway."""
    found: dict[str, Body] = {}
    for frame in reading.frames:
        if frame.negated:
            continue
        names = frame.patient
        if frame.sense == "wind" and not names:
            names = tuple(item.name for item in layout.state.objects)
        if frame.sense == "collapse" and len(names) > 1:
            # A stack that collapses comes apart; the things in it stay whole.
            continue
        for name in names:
            body = _body(frame, name, layout)
            if body is not None:
                found.setdefault(name, body)
    wobbling = {n for f in reading.frames if f.sense == "sway" and not f.negated for n in f.patient}
    return {
        name: _wobbling(body, name, layout) if isinstance(body, Soft) and name in wobbling else body
        for name, body in found.items()
    }


def _wobbling(body: Soft, name: str, layout: Layout) -> Soft:
    """The soft body with so little loss that it swings on for a while, however soft it is."""
    item = layout.state.object(name)
    if item is None or grows(name):
        return body
    waves = math.sqrt(body.young / density_of(item))  # m/s
    swing = math.pi / 2 * waves / max(layout.height(name), 0.01)  # rad/s, fixed at its foot
    seconds = 2 * WOBBLE.damping_ratio / swing
    return body.model_copy(update={"damping": min(body.damping, float(f"{seconds:.3g}"))})


def _body(frame: EventFrame, name: str, layout: Layout) -> Body | None:
    sense = frame.sense
    grains_count = 120  # 50..400: enough to be seen to flow, few enough to be run many times
    if sense in ("collapse", "spread", "knock_over") and is_loose(name):
        return Granular(grains=grains_count, cohesion=0.01)
    if sense in ("collapse", "break", "crush"):
        return Breakable(cuts=(3, 1, 3), release_impulse=round(_blow(frame, name, layout), 4))
    # What the wind takes off a thing is not held to it.
    freed = sense == "wind" and (frame.place("off") or "carried" in frame.manner)
    flag_m = 0.0008  # 0.0003..0.003: thick: of fabric that is 200 g/m², as bunting weighs
    if sense in ("wind", "sway", "bend") and is_flag(name):
        # It streams away from its pole, which is where the wind comes from.
        side = "right" if frame.direction == "left" else "left"
        return Cloth(pinned="none" if freed else side, thickness=flag_m)
    if sense in ("wind", "sway", "bend") and is_sheet(name):
        return Cloth(pinned="none" if freed else "top")
    if sense in ("fall", "land", "descend") and is_sheet(name) and layout.carrier(name) is None:
        # What comes off a line folds up as it comes down.
        return Cloth(pinned="none")
    if sense in ("wind", "sway", "bend", "lean") and grows(name) and not freed:
        return _plant(name, layout)
    pliant_pa = 2e4  # 5e3..1e5: as jelly and soft foam: what is told to behave like them
    pressed_pa = 6e4  # 2e4..2e5: of the same where a hand presses it: softer, it sags for good
    pliant = pressed_pa if sense == "deform" else pliant_pa
    yielding = pliant if "pliant" in frame.manner else stiffness_of(name)
    if yielding is not None and sense in ("sway", "bend", "deform"):
        return Soft(young=yielding)
    if sense == "deform":
        return Soft(young=1e5)
    return None


def _plant(name: str, layout: Layout) -> Soft:
    """What grows, by its height and how broad it is."""
    item = layout.state.object(name)
    kind = "" if item is None or item.shape is None else item.shape.kind
    sides = (WAYS["right"], WAYS["away"])
    wide, deep = (layout.extent(name, way) + layout.extent(name, -way) for way in sides)
    height = max(layout.height(name), 0.01)
    return plant_body(kind, height, max(math.sqrt(wide * deep), 0.02 * height))


def _blow(frame: EventFrame, name: str, layout: Layout) -> float:
    """The blow within a step that its joints just do not bear any more, N·s.

    A part of what the striker brings, m v with v from its fall, and well above what its own
    weight and that of the striker, standing on it, come to in one step.
    """
    strikers = [a for a in frame.agent if layout.has(a)]
    brought = [layout.mass(a) * math.sqrt(2 * G * _height(layout, a, name)) for a in strikers]
    own = layout.mass(name)
    standing = G * 0.01 * (own + sum(layout.mass(a) for a in strikers))
    return max(0.1 * max(brought, default=0.3 * own), 2.5 * standing, 1e-3)


def _height(layout: Layout, name: str, other: str) -> float:
    gap = layout.gap(name, other)
    return max(gap, 0.05) if math.isfinite(gap) else 0.05
