"""Without the semantic API: every action as a plain world-frame force or torque vector.

A force or torque has a start and a duration and nothing else: no velocity, no direction by name,
no aim at a thing, no start on a condition, no holding or placing. What an action means is worked
out once, for the scene as it is at the start; what cannot be said so is left out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.arrays import FloatArray
from physagent_studio.program.actions import (
    Action,
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    ApplyTorque,
    Directed,
    SetAngularVelocity,
    SetVelocity,
)
from physagent_studio.program.edits import AddItem, Edit, apply
from physagent_studio.program.preflight.mechanics import mass_of
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.records import Case, Proposal, Scene
from physagent_studio.simulation.actions.vectors import support_centre, turned, unit_of

STRIKE = 5
"""Steps over which a force gives a velocity that an action would have set at once."""
LARGEST = 9e6
"""Newtons and newton metres that a program may hold."""


@dataclass(frozen=True)
class PlainGenerator:
    """The embedded generator; its actions compiled to plain vectors."""

    def first(self, case: Case, reconstruct: Callable[[SceneState], Scene]) -> PhysicalProgram:
        """The first program; raises what `reconstruct` raises."""
        return plain(RuleGenerator().first(case, reconstruct))


@dataclass(frozen=True)
class PlainPlanner:
    """The embedded planner, searching and proposing with plain vectors alone."""

    def propose(self, situation: Situation) -> Proposal:
        """Edits of just the failed factor; an action that is added is compiled as well."""

        def try_out(program: PhysicalProgram):  # noqa: ANN202 - a Trial
            return situation.try_out(plain(program))

        proposal = RulePlanner().propose(replace(situation, try_out=try_out, ahead=None))
        hunks = [
            hunk.model_copy(update={"edits": _plain_edits(hunk.edits, situation.program)})
            for hunk in proposal.hunks
        ]
        kept = tuple(hunk for hunk in hunks if hunk.edits)
        return proposal.model_copy(update={"hunks": kept})


def plain_crew() -> Crew:
    """The embedded agent with plain vectors alone."""
    return Crew(PlainGenerator(), RuleVerifier(), PlainPlanner())


def _plain_edits(edits: Sequence[Edit], program: PhysicalProgram) -> tuple[Edit, ...]:
    known = {action.id for action in program.event.actions}
    found: list[Edit] = []
    for edit in edits:
        if isinstance(edit, AddItem) and edit.path == "event.actions":
            compiled = plain(apply(program, (edit,))).event.actions
            found += [
                edit.model_copy(update={"item": action.model_dump(mode="json")})
                for action in compiled
                if action.id not in known
            ]
        else:
            found.append(edit)
    return tuple(found)


def plain(program: PhysicalProgram) -> PhysicalProgram:
    """The program with its actions as plain vectors; a plain one comes back unchanged."""
    actions = _Compiler(program).actions()
    if actions == program.event.actions:
        return program
    event = program.event.model_copy(update={"actions": actions})
    return program.model_copy(update={"event": event})


class _Compiler:
    """Compiles the actions of one program in their order.

    heading: the horizontal way that each object was last sent, for vectors that follow its
    velocity.
    """

    def __init__(self, program: PhysicalProgram) -> None:
        self.scene = program.scene
        self.step = program.clip.step_seconds
        self.steps = program.clip.steps
        self.given = program.event.actions
        self.heading: dict[str, FloatArray] = {}

    def actions(self) -> tuple[Action, ...]:
        """All actions that can be said plainly, with plain starts."""
        found: list[Action] = []
        waiting = [action for action in self.given if action.when is not None]
        for action in self.given:
            start = action.start_step
            if action.when is not None:
                # Conditions cannot be said: their actions spread over the clip, in their order.
                start = self.steps * (waiting.index(action) + 1) // (len(waiting) + 1)
            compiled = self._one(action, min(start, self.steps - 1))
            if compiled is not None:
                found.append(compiled)
        return tuple(found)

    def _one(self, action: Action, start: int) -> Action | None:
        item = self.scene.object(action.name)
        if item is None or item.position is None or item.shape is None:
            return None
        mass = mass_of(item) or 1.0
        match action:
            case SetVelocity():
                way = self._vector(action.velocity, action.name)
                return self._force(action, way * mass / (STRIKE * self.step), start, STRIKE)
            case ApplyForce():
                force = self._meant(action, mass)
                made = self._force(action, force, start, action.duration)
                return made.model_copy(
                    update={"point": action.point, "point_frame": action.point_frame}
                )
            case ApplyAngledForce():
                ahead = self.heading.get(action.name, np.array([1.0, 0.0, 0.0]))
                force = turned(ahead, action.angle) * action.magnitude
                return self._force(action, force, start, action.duration, follow=False)
            case ApplyDisturbance():
                force = self._pushing(action, item)
                return self._force(action, force, start, action.duration)
            case SetAngularVelocity():
                turn = self._vector(action.angular_velocity, action.name)
                inertia = mass * float(np.square(outline_of(item.shape).size).mean()) / 6
                steps = min(STRIKE, action.duration)
                return self._torque(action, turn * inertia / (steps * self.step), start, steps)
            case ApplyTorque():
                torque = self._vector(action.torque, action.name)
                return self._torque(action, torque, start, action.duration)
        return None  # Placing, turning and holding have no force that would say them.

    def _meant(self, action: ApplyForce, mass: float) -> FloatArray:
        force = self._vector(action.force, action.name)
        quantity = action.force.quantity if isinstance(action.force, Directed) else "value"
        if quantity == "acceleration":
            return force * mass
        if quantity == "target_speed":
            return force * mass / (action.duration * self.step)
        return force

    def _vector(self, vector: Sequence[float] | Directed, name: str) -> FloatArray:
        if not isinstance(vector, Directed):
            return np.array(vector, float)
        item = self.scene.object(name)
        assert item is not None
        assert item.position is not None
        position = np.array(item.position)
        place = None if vector.toward is None else self._place(vector.toward, position)
        velocity = self.heading.get(name, np.zeros(3))
        return unit_of(vector, position, velocity, place) * vector.magnitude

    def _place(self, aim: str | Sequence[float], near: FloatArray) -> FloatArray:
        if not isinstance(aim, str):
            return np.array(aim, float)
        item, mark = self.scene.object(aim), self.scene.landmark(aim)
        if item is not None and item.position is not None:
            return np.array(item.position)
        if mark is not None and mark.points:
            return np.array(mark.points, float).mean(axis=0)
        support = self.scene.support(aim)
        if support is not None and support.shape is not None:
            return np.asarray(support_centre(support.shape, near), float)
        return near

    def _pushing(self, action: ApplyDisturbance, item: SceneObject) -> FloatArray:
        """A steady force as strong as the disturbance; of a wind, its pressure on the outline."""
        vector = action.direction or "right"
        if isinstance(vector, str):
            way = self._vector(Directed(magnitude=1.0, direction=vector), item.name)
        else:
            way = np.array(vector, float)
        way = way / max(float(np.linalg.norm(way)), 1e-9)
        strength = action.amplitude
        if action.model == "wind":
            assert item.shape is not None
            width, _, height = outline_of(item.shape).size
            strength = 0.6 * float(width * height) * action.amplitude**2
        return way * strength

    def _force(
        self, action: Action, force: FloatArray, start: int, duration: int, follow: bool = True
    ) -> ApplyForce:
        flat = force * [1, 1, 0]
        if follow and float(np.linalg.norm(flat)) > 1e-9:
            self.heading[action.name] = flat / float(np.linalg.norm(flat))
        return ApplyForce(force=_triple(force), **self._kept(action, start, duration))

    def _torque(self, action: Action, torque: FloatArray, start: int, duration: int) -> ApplyTorque:
        return ApplyTorque(torque=_triple(torque), **self._kept(action, start, duration))

    def _kept(self, action: Action, start: int, duration: int) -> dict[str, Any]:
        """What of an action stays, in its new time."""
        kept = {name: getattr(action, name) for name in ("id", "name", "muted")}
        return kept | {"start_step": start, "duration": max(min(duration, self.steps - start), 1)}


def _triple(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(f"{np.clip(part, -LARGEST, LARGEST):.6g}") for part in vector)
    return (x, y, z)
