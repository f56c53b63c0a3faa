"""A wish, "it should be here then", becomes a proposal: what acts before is turned until it fits.

A person drags a thing to where it should be at some step. Whatever pushes it before that step (or
pushes what hits it) is made stronger or weaker and turned, candidate by candidate in the engine,
so that the distance at that step shrinks. What comes of it is told in centimetres, and decided
on like any other proposal.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from physagent_studio.agent.rules.planner.wording import summary_of
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.program import (
    Action,
    AddItem,
    Directed,
    Edit,
    PhysicalProgram,
    SetField,
    apply,
)
from physagent_studio.program.actions import ApplyAngledForce, ApplyForce, SetVelocity
from physagent_studio.records import Hunk, Proposal, Rollout

FloatArray = NDArray[np.float64]
Run = Callable[[PhysicalProgram], Rollout]
LIMIT = 48
"""Most candidate runs of one wish."""
NEAR, SHARE = 0.005, 0.02
"""A wish is met within so many m, or within this share of the way asked for."""
STRENGTH, TURN, RAISE = 0.25, math.radians(6), math.radians(5)
"""What one stride is: a ratio of strength (logarithm), a turn about +z, and one upwards."""
PROBES = ((1.0, 0.0), (-1.0, 0.0), (3.0, 0.0), (-3.0, 0.0), (0, 1.0), (0, -1.0), (0, 3.0), (0, -3))
DAMPING = 1e-6
LARGEST = 12.0
"""Strides that an action may be changed by."""


@dataclass(frozen=True, eq=False, slots=True)
class Wish:
    """The object that should be at `position`, world, m, on the control step `step`."""

    name: str
    position: tuple[float, float, float]
    step: int


@dataclass(eq=False, slots=True)
class _Search:
    """Runs candidates and measures how far from the wish they end; remembers the best."""

    program: PhysicalProgram
    wish: Wish
    run: Run
    best_edits: tuple[Edit, ...] = ()
    best: float = math.inf
    runs: int = 0
    known: dict[str, FloatArray | None] = field(default_factory=dict)

    def miss(self, edits: tuple[Edit, ...]) -> FloatArray | None:
        """(3,) m from the wished place to where the thing then is; None where it cannot run."""
        try:
            program = apply(self.program, edits)
        except StudioError:
            return None
        key = program.hash
        if key not in self.known and self.runs < LIMIT:
            self.runs += 1
            self.known[key] = self._measured(program)
            found = self.known[key]
            if found is not None and float(np.linalg.norm(found)) < self.best - 1e-9:
                self.best, self.best_edits = float(np.linalg.norm(found)), edits
        return self.known.get(key)

    def _measured(self, program: PhysicalProgram) -> FloatArray | None:
        try:
            rollout = self.run(program)
        except Cancelled:
            raise
        except StudioError:
            return None
        return missed(rollout, self.wish)


def missed(rollout: Rollout, wish: Wish) -> FloatArray | None:
    """(3,) m from the wished place to where the thing is; None where the run ended before."""
    if wish.step > rollout.steps:
        return None
    place = rollout.positions[wish.step, rollout.objects.index(wish.name)]
    return place - np.array(wish.position)


def proposal_for(
    program: PhysicalProgram,
    rollout: Rollout,
    wish: Wish,
    run: Run,
    pinned: Sequence[str] = (),
) -> Proposal:
    """Edits that bring a thing nearer to where a person wants it, found by running candidates.

    `rollout`: of `program`. Without hunks, and with a question, where nothing that may be
    changed brings it nearer.
    """
    now = missed(rollout, wish)
    start = math.inf if now is None else float(np.linalg.norm(now))
    search = _Search(program, wish, run, best=start)
    causes = causes_of(program, rollout, wish, pinned)
    for action in causes[:3]:
        _turned(search, _knobs(action), start)
        if search.best <= _near(program, wish):
            break
        if search.best < 0.7 * start:
            break
    if not causes or search.best > 0.9 * start:
        _pushed(search, start)
    return _told(search, start)


def causes_of(
    program: PhysicalProgram, rollout: Rollout, wish: Wish, pinned: Sequence[str]
) -> list[Action]:
    """Actions that can have moved the thing before the step: its own, the latest first."""
    begun = {span.id: span.start for span in rollout.spans}
    found = [
        action
        for action in program.event.actions
        if isinstance(action, SetVelocity | ApplyForce | ApplyAngledForce)
        and not action.muted
        and begun.get(action.id) is not None
        and (begun[action.id] or 0) < wish.step
        and not any(path.startswith(f"event.actions.{action.id}") for path in pinned)
    ]
    return sorted(found, key=lambda one: (one.name != wish.name, -(begun[one.id] or 0)))


Knobs = Callable[[FloatArray], tuple[Edit, ...]]
"""Strides of strength, turn and raise → the edits that make them."""


def _knobs(action: Action) -> Knobs:
    base = f"event.actions.{action.id}"
    if isinstance(action, ApplyAngledForce):
        return lambda x: (
            SetField(path=f"{base}.magnitude", value=_neat(action.magnitude * _ratio(x[0]))),
            SetField(path=f"{base}.angle", value=_neat(action.angle + math.degrees(TURN) * x[1])),
        )
    assert isinstance(action, SetVelocity | ApplyForce)
    name = "velocity" if isinstance(action, SetVelocity) else "force"
    value = getattr(action, name)
    if isinstance(value, Directed):
        return lambda x: _directed(f"{base}.{name}", value, x)
    return lambda x: (SetField(path=f"{base}.{name}", value=turned(value, x)),)


def _directed(path: str, value: Directed, x: FloatArray) -> tuple[Edit, ...]:
    azimuth = _wrapped(value.azimuth + math.degrees(TURN) * x[1])
    elevation = min(max(value.elevation + math.degrees(RAISE) * x[2], -85.0), 85.0)
    edits = [SetField(path=f"{path}.magnitude", value=_neat(value.magnitude * _ratio(x[0])))]
    if x[1] != 0:
        edits.append(SetField(path=f"{path}.azimuth", value=_neat(azimuth)))
    if x[2] != 0:
        edits.append(SetField(path=f"{path}.elevation", value=_neat(elevation)))
    return tuple(edits)


def turned(vector: Sequence[float], x: FloatArray) -> list[JsonValue]:
    """A vector, scaled, turned about +z and raised by strides."""
    length = math.sqrt(sum(part * part for part in vector)) * _ratio(x[0])
    heading = math.atan2(vector[1], vector[0]) + TURN * x[1]
    raised = math.atan2(vector[2], math.hypot(vector[0], vector[1])) + RAISE * x[2]
    raised = min(max(raised, -math.pi / 2), math.pi / 2)
    flat = length * math.cos(raised)
    parts = (flat * math.cos(heading), flat * math.sin(heading), length * math.sin(raised))
    return [_neat(part) for part in parts]


def _ratio(strides: float) -> float:
    return math.exp(STRENGTH * strides)


def _neat(value: float) -> float:
    return float(f"{float(value):.4g}")


def _wrapped(angle: float) -> float:
    return (angle + 180.0) % 360.0 - 180.0


def _turned(search: _Search, knobs: Knobs, start: float) -> None:
    """Looks around coarsely, then closes in on the wish from the best place."""
    at, size = np.zeros(3), start
    for strong, aside in PROBES:
        there = np.array([strong, aside, 0.0])
        found = search.miss(knobs(there))
        if found is not None and float(np.linalg.norm(found)) < size:
            at, size = there, float(np.linalg.norm(found))
    _close_in(search, knobs, at)


def _close_in(search: _Search, knobs: Knobs, at: FloatArray) -> None:
    """Damped Gauss-Newton steps; the height is searched only where the wish asks for it."""
    here = search.miss(knobs(at)) if at.any() else search.miss(())
    near = _near(search.program, search.wish)
    for _ in range(6):
        if here is None or float(np.linalg.norm(here)) <= near:
            return None
        # What rolls does not leave the ground for being aimed a little higher.
        free = 3 if abs(float(here[2])) > max(0.02, 0.3 * float(np.linalg.norm(here))) else 2
        slopes = np.zeros((3, free))
        for column in range(free):
            shifted = at.copy()
            shifted[column] += 0.5
            there = search.miss(knobs(shifted))
            slopes[:, column] = 0.0 if there is None else (there - here) / 0.5
        found = _stepped(search, knobs, at, here, slopes)
        if found is None:
            return _feel(search, knobs, at, near)
        at, here = found
    return None


def _feel(search: _Search, knobs: Knobs, at: FloatArray, near: float) -> None:
    """Steps along each number, ever smaller: bounces make slopes that lead nowhere."""
    size, width = search.best, 1.0
    while size > near and width > 0.06 and search.runs < LIMIT:
        for column, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
            shifted = at.copy()
            shifted[column] += sign * width
            there = search.miss(knobs(shifted))
            if there is not None and float(np.linalg.norm(there)) < size:
                at, size = shifted, float(np.linalg.norm(there))
                break
        else:
            width /= 2


def _stepped(
    search: _Search,
    knobs: Knobs,
    at: FloatArray,
    here: FloatArray,
    slopes: FloatArray,
) -> tuple[FloatArray, FloatArray] | None:
    """The step that brings it nearer, halved until it does; None where none does."""
    square = slopes.T @ slopes + DAMPING * np.eye(slopes.shape[1])
    step = np.zeros(3)
    step[: slopes.shape[1]] = -np.linalg.solve(square, slopes.T @ here)
    length = float(np.linalg.norm(step))
    if length < 1e-3:
        return None
    step *= min(1.0, 4.0 / length)
    for share in (1.0, 0.5, 0.2):
        next_at = np.clip(at + share * step, -LARGEST, LARGEST)
        there = search.miss(knobs(next_at))
        if there is not None and np.linalg.norm(there) < 0.98 * np.linalg.norm(here):
            return next_at, there
    return None


def _pushed(search: _Search, start: float) -> None:
    """A new start speed for the thing itself, where nothing that is there moves it so."""
    wish, program = search.wish, search.program
    item = program.scene.object(wish.name)
    if item is None or item.position is None or wish.step < 1:
        return
    seconds = wish.step * program.clip.step_seconds
    way = np.subtract(wish.position, item.position)
    flat = way[:2] / seconds
    if float(np.linalg.norm(flat)) < 1e-3:
        return
    known = {action.id for action in program.event.actions}
    name = next(
        one for n in range(1, 1000) if (one := f"go_{wish.name}_{n}".replace("_1", "")) not in known
    )
    first = (float(flat[0]), float(flat[1]), 0.0)

    def knobs(x: FloatArray) -> tuple[Edit, ...]:
        velocity = turned(first, x)
        item: dict[str, JsonValue] = {
            "operator": "SetVelocity", "id": name, "name": wish.name, "start_step": 0,
            "velocity": velocity,
        }  # fmt: skip
        return (AddItem(path="event.actions", item=item),)

    # Friction takes some of it, so a faster start is tried as well.
    tries = [(n, search.miss(knobs(np.array([n, 0.0, 0.0])))) for n in (0.0, 2.0, 4.0)]
    held = [(float(np.linalg.norm(miss)), strides) for strides, miss in tries if miss is not None]
    if held:
        _close_in(search, knobs, np.array([min(held)[1] or 1e-9, 0.0, 0.0]))


def _near(program: PhysicalProgram, wish: Wish) -> float:
    """How near is near enough, m."""
    item = program.scene.object(wish.name)
    if item is None or item.position is None:
        return NEAR
    return max(NEAR, SHARE * float(np.linalg.norm(np.subtract(wish.position, item.position))))


def _told(search: _Search, start: float) -> Proposal:
    wish, program = search.wish, search.program
    frame = wish.step // program.clip.steps_per_frame
    mark = f"{program.hash}{wish.name}{wish.position}{wish.step}"
    name = f"w{hashlib.sha256(mark.encode()).hexdigest()[:12]}"
    thing = wish.name.replace("_", " ")
    if not search.best_edits or search.best > 0.9 * start:
        return Proposal(
            id=name, hunks=(), rationale=f"No change of what acts on {thing} before frame {frame} "
            f"brings it to where you put it ({search.runs} runs).",
            factor="none", confidence=0.0, simulations=search.runs,
            question=f"What should make {thing} get there: another push, or another path?",
        )  # fmt: skip
    hunks = tuple(
        Hunk(id=f"h{number}", summary=summary_of(program, (edit,)), edits=(edit,))
        for number, edit in enumerate(search.best_edits, 1)
    )
    was = f"instead of {_length(start)}" if math.isfinite(start) else "where the run ended before"
    return Proposal(
        id=name, hunks=hunks, factor="wish", simulations=search.runs,
        rationale=f"You put {thing} elsewhere at frame {frame}. With this it is then "
        f"{_length(search.best)} from there, {was}.",
        confidence=round(min(max(1 - search.best / max(start, 1e-9), 0.1), 0.9), 2)
        if math.isfinite(start) else 0.5,
    )  # fmt: skip


def _length(metres: float) -> str:
    return f"{metres * 100:.2g} cm" if metres < 1 else f"{metres:.2g} m"
