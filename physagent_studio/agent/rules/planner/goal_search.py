"""A wish, "it should be here then", becomes a proposal: what acts before is turned until it fits.

A person drags a thing to where it should be at some step. Whatever pushes it before that step (or
pushes what hits it) is made stronger or weaker and turned, candidate by candidate in the engine,
so that the distance at that step shrinks. What comes of it is told in centimetres, and decided
on like any other proposal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from pydantic import JsonValue
from scipy.optimize import minimize

from physagent_studio.agent.rules.planner.wording import proposal
from physagent_studio.arrays import FloatArray
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
from physagent_studio.program.base import free_name
from physagent_studio.records import Proposal, Rollout

Run = Callable[[PhysicalProgram], Rollout]


@dataclass(frozen=True, slots=True)
class GoalSettings:
    """How a wish for a place is sought."""

    max_runs: int = 48  # count, 10..200: of one wish
    near_m: float = 0.005  # 0.001..0.05: of the place, where the wish is met
    near_share: float = 0.02  # 0.005..0.1: of the way asked for: a long way is met less exactly
    strength_stride_log: float = 0.25  # 0.05..1: of a strength: a quarter more or less is seen
    turn_stride_rad: float = math.radians(6)  # 0.02..0.5: about the vertical
    # strides, -5..5: of strength and of turn, looked at first: one is near, three is far
    probe_strides: tuple[int, int, int, int] = (1, -1, 3, -3)
    # 0.02..0.5: upwards, where little decides what is passed over
    raise_stride_rad: float = math.radians(5)


GOAL = GoalSettings()

PROBES = (
    (0, 0, 0),
    *((way, 0, 0) for way in GOAL.probe_strides),
    *((0, way, 0) for way in GOAL.probe_strides),
)
"""Strides of strength, turn and raise that are looked at first."""


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
        if key not in self.known and self.runs < GOAL.max_runs:
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
        _close_in(search, _knobs(action), PROBES)
        if search.best <= _near(program, wish):
            break
        if search.best < 0.7 * start:
            break
    if not causes or search.best > 0.9 * start:
        _pushed(search)
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
            SetField(
                path=f"{base}.angle",
                value=_neat(action.angle + math.degrees(GOAL.turn_stride_rad) * x[1]),
            ),
        )
    assert isinstance(action, SetVelocity | ApplyForce)
    name = "velocity" if isinstance(action, SetVelocity) else "force"
    value = getattr(action, name)
    if isinstance(value, Directed):
        return lambda x: _directed(f"{base}.{name}", value, x)
    return lambda x: (SetField(path=f"{base}.{name}", value=turned(value, x)),)


def _directed(path: str, value: Directed, x: FloatArray) -> tuple[Edit, ...]:
    azimuth = (value.azimuth + math.degrees(GOAL.turn_stride_rad) * x[1] + 180.0) % 360.0 - 180.0
    elevation = min(max(value.elevation + math.degrees(GOAL.raise_stride_rad) * x[2], -85.0), 85.0)
    edits = [SetField(path=f"{path}.magnitude", value=_neat(value.magnitude * _ratio(x[0])))]
    if x[1] != 0:
        edits.append(SetField(path=f"{path}.azimuth", value=_neat(azimuth)))
    if x[2] != 0:
        edits.append(SetField(path=f"{path}.elevation", value=_neat(elevation)))
    return tuple(edits)


def turned(vector: Sequence[float], x: FloatArray) -> list[JsonValue]:
    """A vector, scaled, turned about +z and raised by strides."""
    length = math.sqrt(sum(part * part for part in vector)) * _ratio(x[0])
    heading = math.atan2(vector[1], vector[0]) + GOAL.turn_stride_rad * x[1]
    raised = math.atan2(vector[2], math.hypot(vector[0], vector[1])) + GOAL.raise_stride_rad * x[2]
    raised = min(max(raised, -math.pi / 2), math.pi / 2)
    flat = length * math.cos(raised)
    parts = (flat * math.cos(heading), flat * math.sin(heading), length * math.sin(raised))
    return [_neat(part) for part in parts]


def _ratio(strides: float) -> float:
    return math.exp(GOAL.strength_stride_log * strides)


def _neat(value: float) -> float:
    return float(f"{float(value):.4g}")


def _close_in(search: _Search, knobs: Knobs, probes: Sequence[Sequence[float]]) -> None:
    """Looks around coarsely, then closes in on the wish from the best place (Nelder and Mead).

    The height is searched only where the wish asks for it: what rolls does not leave the ground
    for being aimed a little higher.
    """

    def size(x: FloatArray) -> float:
        found = search.miss(knobs(np.append(x, np.zeros(3 - len(x)))))
        return math.inf if found is None else float(np.linalg.norm(found))

    best = min((np.array(probe, float) for probe in probes), key=size)
    if (here := search.miss(knobs(best))) is None:
        return
    free = 3 if abs(float(here[2])) > max(0.02, 0.3 * float(np.linalg.norm(here))) else 2
    corners = best[:free] + np.vstack([np.zeros(free), np.eye(free)])
    near = _near(search.program, search.wish)
    options = {"initial_simplex": corners, "maxfev": GOAL.max_runs, "xatol": 0.1, "fatol": near}
    minimize(size, best[:free], method="Nelder-Mead", options=options)


def _pushed(search: _Search) -> None:
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
    name = free_name(f"go_{wish.name}", {action.id for action in program.event.actions})
    first = (float(flat[0]), float(flat[1]), 0.0)

    def knobs(x: FloatArray) -> tuple[Edit, ...]:
        velocity = turned(first, x)
        item: dict[str, JsonValue] = {
            "operator": "SetVelocity", "id": name, "name": wish.name, "start_step": 0,
            "velocity": velocity,
        }  # fmt: skip
        return (AddItem(path="event.actions", item=item),)

    # Friction takes some of it, so a faster start is tried as well.
    _close_in(search, knobs, [(strides, 0, 0) for strides in (0, 2, 4)])


def _near(program: PhysicalProgram, wish: Wish) -> float:
    """How near is near enough, m."""
    item = program.scene.object(wish.name)
    if item is None or item.position is None:
        return GOAL.near_m
    return max(
        GOAL.near_m,
        GOAL.near_share * float(np.linalg.norm(np.subtract(wish.position, item.position))),
    )


def _told(search: _Search, start: float) -> Proposal:
    wish, program = search.wish, search.program
    frame = wish.step // program.clip.steps_per_frame
    thing = wish.name.replace("_", " ")
    if not search.best_edits or search.best > 0.9 * start:
        why = f"No change of what acts on {thing} before frame {frame} "
        return proposal(
            program, f"{why}brings it to where you put it ({search.runs} runs).",
            simulations=search.runs,
            question=f"What should make {thing} get there: another push, or another path?",
        )  # fmt: skip
    was = f"instead of {_length(start)}" if math.isfinite(start) else "where the run ended before"
    gained = round(min(max(1 - search.best / max(start, 1e-9), 0.1), 0.9), 2)
    return proposal(
        program,
        f"You put {thing} elsewhere at frame {frame}. With this it is then "
        f"{_length(search.best)} from there, {was}.",
        *((edit,) for edit in search.best_edits),
        factor="wish",
        confidence=gained if math.isfinite(start) else 0.5,
        simulations=search.runs,
    )


def _length(metres: float) -> str:
    return f"{metres * 100:.2g} cm" if metres < 1 else f"{metres:.2g} m"
