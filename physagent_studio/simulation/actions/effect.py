"""What an action does while it acts: the common form of the effects of the nine operators.

An effect lives from the first step of its action to the last. `begin` runs once, `act` before
each control step, or before each engine step where `each_substep`, `end` once after the last.
Effects account for the work that they do on their target.
"""

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from physagent_studio.program import Action, Directed
from physagent_studio.simulation.actions.vectors import unit_of
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.surfaces import FloatArray


class Effect(ABC):
    """One action while it acts.

    work: J put into the target so far. kept: the attributes that make up its memory while it
    acts, plain numbers or arrays.
    """

    kept: tuple[str, ...] = ("work",)

    def __init__(self, action: Action) -> None:
        self.action = action
        self.work = 0.0

    @property
    def acts(self) -> bool:
        """Whether `act` does anything at all."""
        return True

    @property
    def each_substep(self) -> bool:
        """Whether `act` runs before every engine step."""
        return False

    def most_gain(self, world: World) -> float:
        """m/s² that no point of the target exceeds by what `act` does for a control step."""
        return math.inf

    @property
    def name(self) -> str:
        """The target object."""
        return self.action.name

    def begin(self, world: World) -> None:
        """Runs once, at the start of the first step; most effects have nothing to do."""
        return

    @abstractmethod
    def act(self, world: World, time: float) -> None:
        """Runs before each (engine or control) step; time: s since the action began."""

    def end(self, world: World) -> None:
        """Runs once, after the last step; most effects have nothing to do."""
        return

    def resume(self, world: World) -> None:
        """Runs after `recall`, to restore what is not in the engine's state."""
        return

    def memory(self) -> dict[str, Any]:
        """Everything that it has learned since it began, as JSON."""
        return {name: _as_json(getattr(self, name)) for name in self.kept}

    def recall(self, memory: dict[str, Any]) -> None:
        """Takes up where `memory` was taken."""
        for name in self.kept:
            value = memory[name]
            setattr(self, name, np.array(value) if isinstance(value, list) else value)


def _as_json(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_as_json(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def direction_of(world: World, name: str, vector: Directed) -> FloatArray:
    """(3,) unit vector of a semantic vector, for an object as it is now."""
    position = world.part(name).position()
    place = None
    if isinstance(vector.toward, str):
        place = world.place(vector.toward, position)
    elif vector.toward is not None:
        place = np.array(vector.toward, float)
    return unit_of(vector, position, world.part(name).velocity(), place)


def plain_vector(world: World, name: str, vector: tuple[float, ...] | Directed) -> FloatArray:
    """A vector whose magnitude is the quantity itself."""
    if isinstance(vector, Directed):
        return vector.magnitude * direction_of(world, name, vector)
    return np.array(vector, float)
