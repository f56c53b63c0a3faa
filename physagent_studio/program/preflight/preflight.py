"""What will probably go wrong, before anything runs: each finding with reason and suggestion."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from physagent_studio.program import actions
from physagent_studio.program.edits import RemoveItem, SetField
from physagent_studio.program.preflight import mechanics
from physagent_studio.program.preflight.clashes import (
    PreflightFinding,
    clashes,
    finding,
    path_of_action,
)
from physagent_studio.program.preflight.placement import scene_findings
from physagent_studio.program.preflight.scaling import scaled
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.shapes import gap, outline_of
from physagent_studio.program.scene.state import SceneObject


def preflight(program: PhysicalProgram) -> tuple[PreflightFinding, ...]:
    """Findings about a valid program, the scene's first; open geometry is passed over.

    None of them stops a run: a person may mean it.
    """
    return (*scene_findings(program), *_event_findings(program), *_contract_findings(program))


def _event_findings(program: PhysicalProgram) -> Iterator[PreflightFinding]:
    live = [action for action in program.event.actions if not action.muted]
    for action in live:
        yield from _condition(program, action)
        yield from _late(program, action)
        yield from _material(program, action)
        yield from _idle(action)
        yield from _friction(program, action)
    for first, second in combinations(live, 2):
        if first.name == second.name:
            yield from clashes(first, second)


# --- conditions and times ---------------------------------------------------------------------


def _condition(program: PhysicalProgram, action: actions.Action) -> Iterator[PreflightFinding]:
    reason = ""
    match action.when:
        case actions.OnContact(a=a, b=b) if a == b:
            reason = f"{a} cannot touch itself"
        case actions.OnContact(a=a, b=b) if not {a, b} & {o.name for o in program.scene.objects}:
            reason = f"{a} and {b} are supports and never move"
        case actions.OnContact(timeout=0) if not _touch_at_start(program, action.when):
            reason = "its time-out is step 0 and they do not touch at the start"
        case actions.After():
            reason = _never_after(program, action)
        case actions.When(statement=statement) if (statement.from_step or 0) >= program.clip.steps:
            reason = "its statement looks only at steps past the end of the clip"
    if reason:
        edits = (SetField(path=f"{path_of_action(action)}.when", value=None),)
        message = f"it never starts: {reason}"
        yield finding("never_starts", f"{path_of_action(action)}.when", message, edits)


def _touch_at_start(program: PhysicalProgram, when: actions.OnContact) -> bool:
    placed = mechanics.standing(program.scene)
    if when.a not in placed or when.b not in placed:
        return True
    return float(gap(placed[when.a], placed[when.b])[0]) < 5e-3


def _never_after(program: PhysicalProgram, action: actions.Action) -> str:
    """Why the chain of actions that this one waits for never ends, or ""."""
    seen = {action.id}
    current: actions.Action | None = action
    while current is not None and isinstance(current.when, actions.After):
        current = program.action(current.when.action)
        if current is None:
            return ""
        if current.muted:
            return f"it waits for {current.id}, which is muted"
        if current.id in seen:
            return f"it waits for {current.id}, which waits for it"
        seen.add(current.id)
    return ""


def _earliest(program: PhysicalProgram, action: actions.Action) -> int:
    """The first step at which an action can start, chains of `after` followed."""
    total, current, seen = 0, action, {action.id}
    while isinstance(current.when, actions.After):
        ahead = program.action(current.when.action)
        total += current.when.delay
        if ahead is None or ahead.id in seen:
            return total
        seen.add(ahead.id)
        total += actions.duration_of(ahead)
        current = ahead
    if current.when is None:
        return total + current.start_step
    return total + current.when.delay


def _late(program: PhysicalProgram, action: actions.Action) -> Iterator[PreflightFinding]:
    """A conditional action whose window cannot lie inside the clip."""
    if action.when is None or _never_after(program, action):
        return
    start, steps = _earliest(program, action), program.clip.steps
    length = actions.duration_of(action)
    if start >= steps:
        message = f"it cannot start before step {start}, but the clip ends at step {steps - 1}"
        edits = (SetField(path=f"{path_of_action(action)}.when.delay", value=0),)
        yield finding("past_end", f"{path_of_action(action)}.when", message, edits)
    elif start + length > steps:
        message = f"{length} steps from step {start} at the earliest run past the end of the clip"
        edits = (SetField(path=f"{path_of_action(action)}.duration", value=steps - start),)
        yield finding("past_end", f"{path_of_action(action)}.duration", message, edits)


# --- one action -------------------------------------------------------------------------------


def _material(program: PhysicalProgram, action: actions.Action) -> Iterator[PreflightFinding]:
    """What a body of this kind cannot take."""
    item = program.scene.object(action.name)
    if item is None or item.body.kind == "rigid":
        return
    kind, reason = item.body.kind, ""
    turned = isinstance(action, actions.SetOrientation | actions.SetAngularVelocity)
    if turned and kind in ("granular", "liquid"):
        reason = f"{item.name} is {kind}: many grains that have no common orientation"
    elif kind in ("cloth", "rope") and isinstance(action, actions.SetAngularVelocity):
        reason = f"{item.name} is a {kind} and does not turn as one body"
    elif isinstance(action, actions.ApplyForce | actions.FixObject) and action.point is not None:
        reason = f"{item.name} is {kind}: a single point of it cannot be held or pushed"
    if reason:
        edits = (RemoveItem(path=path_of_action(action)),)
        yield finding("cannot_act", path_of_action(action), reason, edits)


def _idle(action: actions.Action) -> Iterator[PreflightFinding]:
    """An action that adds nothing."""
    for field in ("force", "torque", "magnitude", "amplitude"):
        value = getattr(action, field, None)
        if isinstance(value, actions.Directed):
            value = value.magnitude
        if value is not None and not np.any(np.asarray(value, float)):
            message = f"its {field} is zero, so it does nothing"
            yield finding(
                "no_effect",
                f"{path_of_action(action)}.{field}",
                message,
                (RemoveItem(path=path_of_action(action)),),
            )


def _friction(program: PhysicalProgram, action: actions.Action) -> Iterator[PreflightFinding]:
    """A push that is smaller than the friction it has to overcome, on what stands still."""
    item = program.scene.object(action.name)
    if not isinstance(action, actions.ApplyForce | actions.ApplyAngledForce) or item is None:
        return
    if _set_in_motion(program, action) or item.shape is None or item.support in (None, AIR):
        return
    if outline_of(item.shape).is_ball or item.body.kind != "rigid":
        return
    held = _static_friction(program, item)
    push = _push(action, item)
    if held is None or push is None or not 0 < push[0] < held[0] - held[1] * push[1]:
        return
    needed = held[0] - held[1] * push[1]
    message = f"a push of {push[0]:.3g} N stays below the static friction of {needed:.3g} N"
    yield finding(
        "below_friction", path_of_action(action), message, scaled(action, 1.5 * needed / push[0])
    )


def _set_in_motion(program: PhysicalProgram, action: actions.Action) -> bool:
    return any(
        isinstance(other, actions.SetVelocity | actions.SetAngularVelocity)
        for other in program.event.actions
        if other.name == action.name and other.id != action.id and not other.muted
    )


def _static_friction(program: PhysicalProgram, item: SceneObject) -> tuple[float, float] | None:
    """Static friction in N of what stands on a level support, and its coefficient."""
    scene = program.scene
    under = scene.support(item.support or "") or scene.object(item.support or "")
    mass = mechanics.mass_of(item)
    if under is None or mass is None:
        return None
    if under.shape is not None and under.shape.kind in ("ramp", "wall", "vessel", "mesh"):
        return None
    wheels = item.wheels
    coefficient = mechanics.friction_between(item, under) if wheels is None else wheels.rolling
    return coefficient * mass * mechanics.gravity_of(scene), coefficient


def _push(
    action: actions.ApplyForce | actions.ApplyAngledForce, item: SceneObject
) -> tuple[float, float] | None:
    """Horizontal and upward part of a push, N; None where only the run can tell."""
    if isinstance(action, actions.ApplyAngledForce):
        return abs(action.magnitude), 0.0
    vector = mechanics.vector_of(action.force)
    mass = mechanics.mass_of(item)
    if vector is None or mass is None:
        return None
    factor = 1.0
    if isinstance(action.force, actions.Directed):
        if action.force.quantity == "target_speed":
            return None
        factor = mass if action.force.quantity == "acceleration" else 1.0
    return factor * float(np.hypot(vector[0], vector[1])), factor * vector[2]


# --- the contract -----------------------------------------------------------------------------


def _contract_findings(program: PhysicalProgram) -> Iterator[PreflightFinding]:
    """Statements that look only at what the clip does not show."""
    steps = program.clip.steps
    for statement in program.contract.statements:
        path = f"contract.statements.{statement.id}"
        if statement.from_step is not None and statement.from_step >= steps:
            message = f"it looks from step {statement.from_step} on; the clip ends at {steps}"
            edits = (SetField(path=f"{path}.from_step", value=None),)
            yield finding("untestable", f"{path}.from_step", message, edits)
