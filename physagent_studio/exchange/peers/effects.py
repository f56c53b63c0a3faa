"""What a handler does to things, as the operators of our programs."""

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from physagent_studio.exchange.peers.tree import Made, Unread, Walker, Way

MOST_ACTIONS = 200
"""Actions that one file gives: a force that is another one at every step is not a schedule."""
HELPERS = frozenset({"DirectionTo", "CurrentVelocityDirection", "direction_to"})
_ARGUMENTS: Mapping[str, tuple[str, ...]] = {
    "SetVelocity": ("name", "velocity", "frame"),
    "SetAngularVelocity": ("name", "angular_velocity", "frame"),
    "ApplyForce": ("name", "force", "point", "duration", "frame"),
    "ApplyTorque": ("name", "torque", "duration", "frame"),
    "ApplyAngledForce": ("name", "magnitude", "angle", "duration", "frame", "horizontal"),
    "ApplyDisturbance": ("name", "model", "amplitude", "duration", "frame"),
    "SetPosition": ("name", "position", "frame"),
    "SetOrientation": ("name", "rotation", "frame"),
    "FixObject": ("name", "duration", "frame"),
    "DirectionTo": ("target", "magnitude", "source", "horizontal"),
    "direction_to": ("target", "magnitude", "source", "horizontal"),
    "CurrentVelocityDirection": ("magnitude", "angle", "horizontal"),
}
"""Their parameters in order (physics_actions.py of the release)."""
ACTIONS = frozenset(_ARGUMENTS) - HELPERS


@dataclass(slots=True)
class Schedule:
    """What a handler says. actions: our operators as plain data, objects by number and without ids.

    lifts: m (x, y, z) by which an object is moved before the start. left_out: what is not taken
    over, each with its line.
    """

    actions: list[dict[str, Any]] = field(default_factory=list)
    lifts: dict[int, list[float]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)


@dataclass(slots=True)
class Effects:
    """Collects actions. names: of the things. open: effects that went on at the last step, by what
    they are; each becomes one action."""

    walker: Walker
    names: tuple[str, ...]
    told: Schedule
    step: int = 0
    open: dict[Any, dict[str, Any]] = field(default_factory=dict)
    noted: set[str] = field(default_factory=set)

    def vector(self, value: Any, thing: int) -> Any:
        """A vector as our programs say it."""
        if isinstance(value, Way):
            if value.source != thing or not value.unit:
                raise Unread("a vector whose length or start only the simulation knows")
            toward = {"toward": value.target, "horizontal": value.horizontal}
            return {"magnitude": value.scale, **toward}
        if isinstance(value, Made):
            return self._directed(value, thing)
        return list(numbers(value, 3))

    def _directed(self, made: Made, thing: int) -> dict[str, Any]:
        said = self._arguments(made)
        magnitude = float(said.get("magnitude", 1.0))
        if made.name == "CurrentVelocityDirection":
            turn = float(said.get("angle", 0.0))
            return {"magnitude": magnitude, "along": "velocity", "azimuth": turn}
        source = said.get("source")
        if source is not None and self._index(source) != thing:
            raise Unread("a direction from another thing")
        flat = bool(said.get("horizontal", False))
        return {"magnitude": magnitude, "toward": self._index(said["target"]), "horizontal": flat}

    def act(self, operator: str, thing: int, said: dict[str, Any]) -> None:
        """At this step; what went on at the step before goes on."""
        key = repr((operator, thing, sorted(said.items(), key=repr)))
        lasting = operator in ("ApplyForce", "ApplyTorque")
        going = self.open.get(key)
        if lasting and going is not None and until(going) == self.step:
            going["duration"] += 1
            return
        action = {"operator": operator, "object": thing, "start_step": self.step, **said}
        if lasting:
            action["duration"] = 1
        self.open[key] = action
        self._kept(action)

    def _kept(self, action: dict[str, Any]) -> None:
        if len(self.told.actions) == MOST_ACTIONS:
            raise Unread(f"more than {MOST_ACTIONS} actions")
        self.told.actions.append(action)

    def listed(self, node: ast.AST, made: Any) -> None:
        """An action of the releases' own classes."""
        if not isinstance(made, Made) or made.name not in ACTIONS:
            raise Unread("no action")
        try:
            said = self._arguments(made)
            thing = self._index(said.pop("name"))
            start = max(0, int(said.pop("frame", 0)))
            action: dict[str, Any] = {"operator": made.name, "object": thing, "start_step": start}
            for key, value in said.items():
                action |= self._field(node, made.name, key, value, thing)
        except (KeyError, TypeError, ValueError) as error:
            raise Unread(f"{made.name} with these arguments") from error
        if made.name.startswith("Apply") or made.name == "FixObject":
            action.setdefault("duration", 1)
        if made.name == "FixObject" and start:
            self.note(node, "FixObject later than the start holds where it is, not where it began")
        self._kept(action)

    def _field(self, node: ast.AST, operator: str, key: str, value: Any, thing: int) -> Any:
        if key in ("velocity", "angular_velocity", "force", "torque"):
            return {key: self.vector(value, thing)}
        if key == "duration":
            return {key: max(1, int(value))}
        if key == "point":
            return {} if value is None else {key: list(numbers(value, 3)), "point_frame": "world"}
        if key == "position":
            return {key: list(numbers(value, 3))}
        if key == "rotation":
            return {key: _quaternion(value)}
        if key == "horizontal":
            if not value:
                self.note(node, f"{operator}: horizontal=False")
            return {}
        if key == "model":
            return {key: self._model(node, str(value).lower())}
        return {key: float(value)}

    def _model(self, node: ast.AST, word: str) -> str:
        models = {"up": "bump", "vertical": "bump", "lateral": "side", "random": "jitter"}
        found = models.get(word, word)
        if found not in ("bump", "side", "shake", "jitter"):
            raise Unread(f"the disturbance '{word[:40]}'")
        self.note(node, f"the course in time of the disturbance '{word}' (ours is used)")
        return found

    def _arguments(self, made: Made) -> dict[str, Any]:
        names = _ARGUMENTS[made.name]
        if len(made.values) > len(names) or any(key not in names for key in made.named):
            raise Unread(f"{made.name} with these arguments")
        return dict(zip(names, made.values, strict=False)) | dict(made.named)

    def _index(self, said: Any) -> int:
        found = re.fullmatch(r"(?:obj(?:ect)?[_ -]?)?(\d{1,3})", str(said).strip().lower())
        plain = [re.sub(r"[^a-z0-9]+", "_", one.lower()).strip("_") for one in self.names]
        word = re.sub(r"[^a-z0-9]+", "_", str(said).lower()).strip("_")
        index = int(found[1]) if found else plain.index(word) if word in plain else -1
        if not 0 <= index < self.walker.count:
            raise Unread(f"the object '{str(said)[:40]}'")
        return index

    def note(self, node: ast.AST, what: str) -> None:
        line = f"line {getattr(node, 'lineno', 0)}: {what}"
        if line not in self.noted:
            self.noted.add(line)
            self.told.left_out.append(line)


def until(action: Mapping[str, Any]) -> int:
    """The step after the last on which an action acts."""
    return action["start_step"] + action.get("duration", 1)


def numbers(value: Any, count: int) -> Iterator[float]:
    """The parts of a vector of so many. Raises Unread."""
    if not isinstance(value, tuple) or len(value) != count:
        raise Unread(f"no {count} numbers")
    if not all(isinstance(part, int | float) for part in value):
        raise Unread("numbers that only the simulation knows")
    return (float(part) for part in value)


def _quaternion(value: Any) -> list[float]:
    """wxyz of theirs, or of their angles about x, y and z in degrees."""
    from scipy.spatial.transform import Rotation

    if isinstance(value, tuple) and len(value) == 3:
        turn = Rotation.from_euler("xyz", list(numbers(value, 3)), degrees=True)
        x, y, z, w = turn.as_quat()
        return [float(w), float(x), float(y), float(z)]
    return list(numbers(value, 4))
