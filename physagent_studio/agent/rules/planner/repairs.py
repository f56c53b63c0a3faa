"""Repairs that add, remove or re-aim an action, where turning numbers cannot help."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.directing import pace_is_pinned
from physagent_studio.agent.rules.planner.factors import bias_of
from physagent_studio.agent.rules.planner.parameters import RANGE
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.paths import PATH, arc_length
from physagent_studio.program.actions import Action, ApplyAngledForce, ApplyForce, Directed
from physagent_studio.program.base import free_name
from physagent_studio.program.edits import AddItem, Edit, RemoveItem, SetField
from physagent_studio.program.scene.materials import touch_of
from physagent_studio.program.statements import Contacts
from physagent_studio.program.timing import SLOWEST, retimed
from physagent_studio.records import Mismatch, Rollout


@dataclass(frozen=True, slots=True)
class RepairSettings:
    """How much harder a blow is tried that does not do its work."""

    # ratio, 1.5..12: of its speed, gently first; each further one hands on the most of the last
    harder_ratios: tuple[float, ...] = (2.0, 4.0, 7.0)
    # degrees, -10..10: beside the middle of a group, through a gap of it
    aside_deg: tuple[float, ...] = (0.0, 4.0, -4.0)
    # ratio, 0.5..0.95: bounciness of what shall come back from what it meets, and of both
    bouncy_ratios: tuple[float, ...] = (0.7, 0.9)
    # ratio, 0.1..0.9: of its speed, of the blow that sends a row over
    gentler_ratios: tuple[float, ...] = (0.6, 0.4, 0.25)
    # of its height, 0.1..1: that what shall be knocked over slides along, and is shoved
    shoved_share: float = 0.25
    gripping_friction: float = 2.0  # ratio, 1..3: of a rubber foot: it tips before it slides
    bouncing_ratios: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0)  # ratio, 1..12: faster with that


REPAIRS = RepairSettings()


def structural(situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """Candidate repairs, the most natural first; at most a handful."""
    seen: set[str] = set()
    for mismatch in situation.assessment.diagnosis[:4]:
        found = (
            *_held(mismatch, situation), *_harder(mismatch, situation),
            *_bouncier(mismatch, situation), *_gentler(mismatch, situation),
            *_added(mismatch, situation),
            *_removed(mismatch, situation), *_other_arcs(mismatch, situation),
        )  # fmt: skip
        for edits in found:
            key = repr(edits)
            if key not in seen:
                seen.add(key)
                yield edits


def _driven(situation: Situation) -> set[str]:
    return {a.name for a in situation.program.event.actions if not a.muted}


def _added(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """Something that shall move, arrive, fall over or stop and that nothing sets going."""
    layout, name = Layout(situation.program.scene), mismatch.subject
    if not layout.has(name):
        return
    driven = _driven(situation)
    # What something else shall hit is not pushed by an unseen hand.
    at_rest = name not in driven and not _struck(situation, name, driven)
    other = mismatch.other if layout.is_known(mismatch.other) else ""
    if mismatch.code in ("does_not_move", "falls_short", "misses", "no_contact") and other:
        if at_rest:
            speed = max(0.8, 2.0 * layout.size(name))
            yield _add(situation, act.push(name, act.toward_or_along(speed, toward=other)))
        elif name in driven:
            yield from _reaimed(name, other, situation)
    if at_rest and mismatch.code in ("not_toppled", "too_little_turn", "not_fallen", "not_left"):
        yield from _tipped(name, situation, layout)
    if mismatch.code in ("not_stopped", "overshoots", "not_resting"):
        force = Directed(magnitude=1.0, along="against_velocity", quantity="acceleration")
        start = situation.program.clip.steps // 2
        brake = act.push(
            name, force, start=start, duration=situation.program.clip.steps - start, label="brake"
        )
        yield _add(situation, brake)
    if mismatch.code in ("falls_short", "not_visible") and not other and at_rest:
        yield _add(situation, act.push(name, act.toward_or_along(0.8, way=_said(mismatch))))


def _other_arcs(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """What curves to its target and hits what it shall not, or misses: along a wider or a flatter
    arc, its three numbers turned together."""
    if mismatch.code not in ("unwanted_contact", "misses", "no_contact", "toppled"):
        return
    actions = situation.program.event.actions
    for bend in (a for a in actions if isinstance(a, ApplyAngledForce)):
        start = next((a for a in actions if a.name == bend.name and _is_aimed(a)), None)
        force = getattr(start, "force", None)
        if start is None or not isinstance(force, Directed) or abs(force.azimuth) < 1.0:
            continue
        turn = 2 * abs(force.azimuth)
        for other in (t for t in PATH.turns_deg if abs(t - turn) > 4.0):
            longer = arc_length(1.0, other) / arc_length(1.0, turn)
            base = f"event.actions.{bend.id}"
            room = situation.program.clip.steps - bend.start_step
            azimuth = round(math.copysign(other / 2, force.azimuth), 3)
            yield (
                SetField(path=f"event.actions.{start.id}.force.azimuth", value=azimuth),
                SetField(
                    path=f"{base}.magnitude",
                    value=float(f"{bend.magnitude * other / turn / longer:.5g}"),
                ),
                SetField(
                    path=f"{base}.duration", value=min(round(bend.duration * longer), max(room, 1))
                ),
            )


def _is_aimed(action: Action) -> bool:
    return isinstance(action, ApplyForce) and getattr(action.force, "toward", None) is not None


def _harder(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """A blow that does not fell or shift what it shall: much harder, and a little to either side,
    so that a group passes it on; what is thrown flies the flatter for it."""
    layout, name, program = Layout(situation.program.scene), mismatch.subject, situation.program
    driven = _driven(situation)
    gentler = ("magnitude", -1.0) in bias_of(situation).wanted
    if mismatch.code not in _WITHSTANDS or not layout.has(name) or name in driven or gentler:
        return
    several = len({m.subject for m in situation.assessment.diagnosis if m.code == mismatch.code})
    asides = REPAIRS.aside_deg if several > 1 else (0.0,)
    for action in program.event.actions:
        force = getattr(action, "force", None)
        if not isinstance(force, Directed) or force.toward is None or action.muted:
            continue
        if force.quantity != "target_speed" or not _struck(situation, name, driven):
            continue
        path = f"event.actions.{action.id}.force"
        for factor in REPAIRS.harder_ratios:
            speed, elevation = _sooner(action.name, force, layout, factor)
            for aside in asides:
                edits = [SetField(path=f"{path}.magnitude", value=float(f"{speed:.5g}"))]
                if aside:
                    aimed = round(force.azimuth + aside, 3)
                    edits.append(SetField(path=f"{path}.azimuth", value=aimed))
                if elevation != force.elevation:
                    edits.append(SetField(path=f"{path}.elevation", value=round(elevation, 3)))
                yield tuple(edits)
                grip = _gripping(mismatch, situation)
                if grip and not aside:
                    yield (*edits, *grip)
                if several == 1 and not pace_is_pinned(situation):
                    # What is too fast for the eye then is shown slower at once.
                    slower = max(program.clip.time_factor / factor, SLOWEST)
                    yield (*edits, *retimed(program, slower))


def _gripping(mismatch: Mismatch, situation: Situation) -> tuple[Edit, ...]:
    """What shall be knocked over and was shoved along instead stands on a foot that grips."""
    item = situation.program.scene.object(mismatch.subject)
    rollout = situation.rollout
    if mismatch.code != "not_toppled" or item is None or rollout is None:
        return ()
    path = rollout.positions[:, rollout.index(item.name), :2]
    slid = float(np.linalg.norm(path - path[0], axis=1).max())
    if slid < REPAIRS.shoved_share * Layout(situation.program.scene).height(item.name):
        return ()
    if touch_of(item).friction >= REPAIRS.gripping_friction:
        return ()
    path = f"scene.objects.{item.name}.friction"
    return (SetField(path=path, value=REPAIRS.gripping_friction),)


_WITHSTANDS = ("not_toppled", "falls_short", "not_left", "not_fallen")


def _sooner(name: str, force: Directed, layout: Layout, factor: float) -> tuple[float, float]:
    """Speed, m/s, and elevation, degrees, with which it is at its aim so many times sooner."""
    fastest, tilt = RANGE.max_speed_mps, math.radians(force.elevation)
    if force.elevation <= 0 or not isinstance(force.toward, str):
        return min(factor * force.magnitude, fastest), force.elevation
    way = layout.position(force.toward) - layout.position(name)
    across = float(np.linalg.norm(way[:2]))
    seconds = across / max(force.magnitude * math.cos(tilt), 0.01) / factor
    speed, elevation = mech.launch(across, float(way[2]), max(seconds, across / fastest))
    return min(speed, fastest), elevation


def _gentler(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """A row that shall go over one after another and goes as one: the blow that begins it. What
    turns too far: all that pushes it."""
    too_far = mismatch.code == "too_much_turn"
    if not too_far and (mismatch.code != "wrong_order" or not goes_in_turn(situation)):
        return
    for action in situation.program.event.actions:
        if too_far and action.name != mismatch.subject:
            continue
        force = getattr(action, "force", None)
        if isinstance(force, Directed) and force.quantity == "target_speed" and not action.muted:
            path = f"event.actions.{action.id}.force.magnitude"
            for ratio in REPAIRS.gentler_ratios:
                yield (SetField(path=path, value=float(f"{ratio * force.magnitude:.5g}")),)


def goes_in_turn(situation: Situation) -> bool:
    """Whether several things shall fall over one after another."""
    statements = situation.program.contract.statements
    over = {s.id for s in statements if s.kind == "topples"}
    return any(s.kind == "in_turn" and set(s.of) <= over for s in statements)


def _bouncier(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """What meets a thing and does not come back from it: both give back more of the blow, which
    may have to be faster for the way back to be seen."""
    name, program = mismatch.subject, situation.program
    if mismatch.code != "not_reversed":
        return
    met = [s.other for s in program.contract.statements
           if isinstance(s, Contacts) and s.subject == name and not s.negated]  # fmt: skip
    bodies = [item for item in program.scene.objects if item.name in (name, *met)]
    pushes = [a for a in program.event.actions if a.name == name and not a.muted]
    forces = [(a, f) for a in pushes if isinstance(f := getattr(a, "force", None), Directed)]
    aimed = [(a, f) for a, f in forces if f.quantity == "target_speed"]
    for ratio, faster in product(REPAIRS.bouncy_ratios, REPAIRS.bouncing_ratios):
        softer = [b for b in bodies if touch_of(b).restitution < ratio]
        yield (
            *(SetField(path=f"scene.objects.{b.name}.restitution", value=ratio) for b in softer),
            *(
                SetField(
                    path=f"event.actions.{a.id}.force.magnitude",
                    value=float(f"{min(faster * f.magnitude, RANGE.max_speed_mps):.5g}"),
                )
                for a, f in aimed
                if faster > 1
            ),
        )


def _said(mismatch: Mismatch):  # noqa: ANN202 - a Direction
    for way in ("left", "right", "away", "toward_camera", "up"):
        if way in mismatch.check or way in mismatch.text:
            return way
    return "right"


def _tipped(name: str, situation: Situation, layout: Layout) -> Iterator[tuple[Edit, ...]]:
    for way in ("left", "right"):
        force = act.toward_or_along(0.8, way=way)
        point = act.top_point(layout, name)
        yield _add(situation, act.push(name, force, point=point, duration=15, label="tip"))


def _struck(situation: Situation, name: str, driven: set[str]) -> bool:
    """Whether the prompt has something else set it going: no unseen hand may do that work."""
    return bool(driven) and any(
        isinstance(s, Contacts)
        and not s.negated
        and name in (s.subject, s.other)
        and {s.subject, s.other} <= {item.name for item in situation.program.scene.objects}
        for s in situation.program.contract.statements
    )


def _reaimed(name: str, other: str, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """A push along a named direction becomes one towards the thing that is to be met."""
    for action in situation.program.event.actions:
        force = getattr(action, "force", None)
        if action.name != name or not isinstance(action, ApplyForce):
            continue
        if isinstance(force, Directed) and force.toward != other and force.along is None:
            aimed = force.model_copy(update={"toward": other, "direction": None, "azimuth": 0.0})
            path = f"event.actions.{action.id}.force"
            yield (SetField(path=path, value=aimed.model_dump(mode="json")),)


def _held(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """Things that stood in the photo and now fall over by themselves are held as they stood,
    until something touches them."""
    if mismatch.code not in ("toppled", "moved", "wrong_order", "no_cause", "not_toppled"):
        return
    rollout, program = situation.rollout, situation.program
    if rollout is None or rollout.blown_up is not None:
        return
    edits: list[Edit] = []
    for name in rollout.objects:
        starts, touched = _first_motion(rollout, name), _first_touch(rollout, name)
        early = starts is not None and (touched is None or touched > starts)
        if early and name not in _driven(situation) and Layout(program.scene).carrier(name):
            last = program.clip.steps if touched is None else touched
            edits += _add(situation, act.hold(name, max(last - 1, 1)))
    if edits:
        yield tuple(edits)


def _first_motion(rollout: Rollout, name: str) -> int | None:
    """The first step on which an object has visibly left its place or its pose."""
    index = rollout.objects.index(name)
    away = np.linalg.norm(rollout.positions[:, index] - rollout.positions[0, index], axis=1)
    turned = 1 - np.abs(rollout.rotations[:, index] @ rollout.rotations[0, index])
    moved = np.nonzero((away > 0.01) | (turned > 0.004))[0]
    return int(moved[0]) if len(moved) else None


def _first_touch(rollout: Rollout, name: str) -> int | None:
    """The first step on which another object touches it that did not from the start."""
    index, count = rollout.objects.index(name), len(rollout.objects)
    rows = rollout.contacts
    mine = rows[(rows["a"] == index) | (rows["b"] == index)]
    partner = np.where(mine["a"] == index, mine["b"], mine["a"])
    early = {int(p) for p, step in zip(partner, mine["step"], strict=True) if step <= 2}
    later = [
        int(step)
        for p, step in zip(partner, mine["step"], strict=True)
        if p < count and int(p) not in early
    ]
    return min(later, default=None)


def _removed(mismatch: Mismatch, situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """What shall stay and is pushed itself."""
    if mismatch.code not in ("moved", "toppled", "unwanted_contact", "fell"):
        return
    for action in situation.program.event.actions:
        if action.name == mismatch.subject and len(situation.program.event.actions) > 1:
            yield (RemoveItem(path=f"event.actions.{action.id}"),)


def _add(situation: Situation, action: Action) -> tuple[Edit, ...]:
    name = free_name(action.id, {a.id for a in situation.program.event.actions})
    item = action.model_copy(update={"id": name}).model_dump(mode="json")
    return (AddItem(path="event.actions", item=item),)
