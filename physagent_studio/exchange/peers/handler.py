"""The action schedule of a handler file of the PhysAgent and RealWonder releases.

Those releases import the file and run it. Here it is parsed to its syntax tree and walked
(`tree.Walker`), step by step of their simulation: `build_actions`, which lists actions by name, and
`custom_simulation`, which applies forces and velocities where its conditions on the step hold. What
has no counterpart is listed with its line; nothing is dropped silently.
"""

import ast
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from physagent_studio.errors import InputError
from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.peers.effects import (
    ACTIONS,
    HELPERS,
    Effects,
    Schedule,
    numbers,
    until,
)
from physagent_studio.exchange.peers.tree import Place, Thing, TooMuch, Unread, Walker, Way
from physagent_studio.jobs import Limits, within

MAX_BYTES = 200_000
"""Bytes of a handler; the longest published one has 30,000."""
LIMITS = Limits(seconds=0.8, memory=128 * 2**20)
"""What parsing and walking may take."""
_REFUSED = (ArithmeticError, LookupError, TypeError, ValueError)
"""What an operation on values of the wrong kind ends in: it is listed like what is unread."""
_READ_METHODS = ("__init__", "custom_simulation", "build_actions", "add_entities_to_scene")


def read_handler(
    path: Path, count: int, steps: int, config: Mapping[str, Any], names: Sequence[str]
) -> Schedule:
    """The schedule of a handler for `count` objects over so many steps of its simulation.

    names: how the file may call them besides their numbers.

    Raises:
        InputError: it cannot be read, or is no handler.
    """
    text = text_of(path, MAX_BYTES)
    plain = {key: value for key, value in config.items() if isinstance(value, int | float | list)}
    values = (text, path.name, count, steps, plain, tuple(names))
    return within(LIMITS, f"{path} cannot be read", parsed, *values)


def parsed(
    text: str,
    name: str,
    count: int,
    steps: int,
    config: Mapping[str, Any],
    names: tuple[str, ...],
) -> Schedule:
    """The task behind `read_handler`: trusts the text with time and memory."""
    try:
        module = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise InputError(f"{name} is no Python that can be parsed ({type(error).__name__})") from (
            error
        )
    found = [node for node in module.body if isinstance(node, ast.ClassDef)]
    if len(found) != 1:
        raise InputError(f"{name} has {len(found)} classes; a handler has one")
    reader = _Reader(Walker(count, config, ACTIONS | HELPERS), names, Schedule())
    try:
        reader.read(found[0], steps)
    except TooMuch as error:
        raise InputError(f"{name} says too much: it cannot be walked to its end") from error
    except RecursionError as error:
        raise InputError(f"{name} is nested too deeply") from error
    return reader.told


class _Reader(Effects):
    """Walks the methods of a handler."""

    def read(self, handler: ast.ClassDef, steps: int) -> None:
        methods = {node.name: node for node in handler.body if isinstance(node, ast.FunctionDef)}
        self._own_names(handler)
        for name, node in methods.items():
            body = [one for one in node.body if not _silent(one)]
            if name not in _READ_METHODS and body:
                self.note(node, f"the method {name}")
        for name in ("__init__", "add_entities_to_scene", "build_actions"):
            if name in methods:
                self.walker.names = {}
                self._block(methods[name].body)
        if "custom_simulation" in methods:
            self._steps(methods["custom_simulation"], steps)

    def _own_names(self, handler: ast.ClassDef) -> None:
        for node in handler.body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "object_names":
                try:
                    said = self.walker.value(node.value)
                except (Unread, *_REFUSED):
                    continue
                if isinstance(said, tuple):
                    self.names = tuple(str(one) for one in said)

    def _steps(self, method: ast.FunctionDef, steps: int) -> None:
        arguments = [one.arg for one in method.args.args]
        for step in range(steps):
            self.step = step
            self.walker.names = {arguments[1]: step} if len(arguments) > 1 else {}
            self._block(method.body)
            for key in [key for key, one in self.open.items() if until(one) <= step]:
                del self.open[key]

    def _block(self, body: Sequence[ast.stmt]) -> bool:
        """Walks statements; whether it came to a `return`."""
        for node in body:
            if _silent(node):
                continue
            try:
                if self._statement(node):
                    return True
            except (Unread, *_REFUSED) as error:
                reason = error if isinstance(error, Unread) else Unread("values that do not fit")
                self.note(node, f"{ast.unparse(node).splitlines()[0][:80]} ({reason})")
                self._forget(node, reason)
        return False

    def _statement(self, node: ast.stmt) -> bool:
        if isinstance(node, ast.If):
            return self._block(
                node.body if self.walker.truth(self.walker.value(node.test)) else node.orelse
            )
        if isinstance(node, ast.For):
            return self._loop(node)
        if isinstance(node, ast.Return):
            return self._returned(node)
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            self._assign(node)
        elif isinstance(node, ast.AugAssign):
            self._lift(node)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            self._effect(node.value)
        else:
            raise Unread(type(node).__name__)
        return False

    def _loop(self, node: ast.For) -> bool:
        for value in self.walker.value(node.iter):
            if isinstance(node.target, ast.Name):
                self.walker.names[node.target.id] = value
            if self._block(node.body):
                return True
        return False

    def _returned(self, node: ast.Return) -> bool:
        if node.value is None or "super()" in ast.unparse(node.value):
            return True
        said = self.walker.value(node.value)
        for one in said if isinstance(said, tuple) else ():
            self.listed(node, one)
        return True

    def _assign(self, node: ast.Assign | ast.AnnAssign) -> None:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        assert node.value is not None
        value = self.walker.value(node.value)
        for target in targets:
            if isinstance(target, ast.Name):
                self.walker.names[target.id] = value
            elif isinstance(target, ast.Attribute) and ast.unparse(target.value) == "self":
                self.walker.own[target.attr] = value
            elif isinstance(target, ast.Subscript) and isinstance(target.value, ast.Name):
                self._part(target, value)
            else:
                raise Unread("an assignment")

    def _part(self, target: ast.Subscript, value: Any) -> None:
        """One part of a vector; a way of which the third is 0 is horizontal."""
        assert isinstance(target.value, ast.Name)
        held, key = self.walker.value(target.value), self.walker.value(target.slice)
        if isinstance(held, Way) and key == 2 and value == 0 and not held.unit:
            made = Way(held.source, held.target, held.scale, held.unit, True)
            self.walker.names[target.value.id] = made
        elif isinstance(held, tuple) and type(key) is int and 0 <= key < len(held):
            self.walker.names[target.value.id] = (*held[:key], value, *held[key + 1 :])
        else:
            raise Unread("a part of what only the simulation knows")

    def _lift(self, node: ast.AugAssign) -> None:
        said = ast.unparse(node.target)
        found = re.fullmatch(r"self\.all_obj_info\[(.+)\]\['center'\]\[([012])\]", said)
        if found and isinstance(node.op, ast.Add | ast.Sub):
            index = self.walker.value(ast.parse(found[1], mode="eval").body)
            amount = self.walker.value(node.value)
            known = type(index) is int and 0 <= index < self.walker.count
            if known and isinstance(amount, int | float):
                sign = 1 if isinstance(node.op, ast.Add) else -1
                way = self.told.lifts.setdefault(index, [0.0, 0.0, 0.0])
                way[int(found[2])] += sign * amount
                return
        if isinstance(node.target, ast.Name) and isinstance(node.op, ast.Add | ast.Sub | ast.Mult):
            whole = ast.BinOp(ast.Name(node.target.id, ast.Load()), node.op, node.value)
            self.walker.names[node.target.id] = self.walker.value(whole)
            return
        raise Unread("a change of what only the simulation knows")

    def _effect(self, call: ast.Call) -> None:
        name = call.func.attr if isinstance(call.func, ast.Attribute) else ast.unparse(call.func)
        given = {word.arg: word.value for word in call.keywords if word.arg}
        if name in ("apply_links_external_force", "apply_links_external_torque"):
            what = name.rpartition("_")[2]
            vector = given.get(what) or (call.args[0] if call.args else None)
            if vector is None:
                raise Unread(f"no {what}")
            thing = self._thing(ast.unparse(call.func).removesuffix(f".solver.{name}"))
            operator = "ApplyForce" if what == "force" else "ApplyTorque"
            self.act(operator, thing, {what: self.vector(self.walker.value(vector), thing)})
        elif name in ("set_dofs_velocity", "set_pos", "set_quat") and isinstance(
            call.func, ast.Attribute
        ):
            thing = self._thing(ast.unparse(call.func.value))
            word = {"set_dofs_velocity": "velocity", "set_pos": "pos", "set_quat": "quat"}[name]
            vector = given.get(word) or (call.args[0] if call.args else None)
            if vector is None:
                raise Unread(f"no {word}")
            self._placed(name, thing, self.walker.value(vector), given.get("dofs_idx_local"))
        elif name == "append" and call.args:
            self.listed(call, self.walker.value(call.args[0]))
        else:
            raise Unread(f"'{ast.unparse(call)[:80]}'")

    def _placed(self, name: str, thing: int, vector: Any, dofs: ast.expr | None) -> None:
        if name == "set_pos":
            self.act("SetPosition", thing, {"position": list(numbers(vector, 3))})
        elif name == "set_quat":
            self.act("SetOrientation", thing, {"rotation": list(numbers(vector, 4))})
        else:
            which = (0,) if dofs is None else self.walker.value(dofs)
            linear, angular = _parted(vector, isinstance(which, tuple) and which[0] == 3)
            if linear is not None:
                self.act("SetVelocity", thing, {"velocity": self.vector(linear, thing)})
            if angular is not None:
                turn = {"angular_velocity": self.vector(angular, thing)}
                self.act("SetAngularVelocity", thing, turn)

    def _thing(self, said: str) -> int:
        found = self.walker.value(ast.parse(said, mode="eval").body)
        if not isinstance(found, Thing):
            raise Unread(f"'{said[:80]}'")
        return found.index

    def _forget(self, node: ast.stmt, reason: Unread) -> None:
        """What an unread statement would have set is not known any more."""
        for part in ast.walk(node):
            if not (isinstance(part, ast.Name | ast.Subscript) and isinstance(part.ctx, ast.Store)):
                continue
            name = part if isinstance(part, ast.Name) else part.value
            if isinstance(name, ast.Name):
                self.walker.names[name.id] = reason


def _parted(vector: Any, turning: bool) -> tuple[Any, Any]:
    """The linear and the angular part of a velocity of six, or of three and which three."""
    if isinstance(vector, tuple) and len(vector) == 6:
        return vector[:3], vector[3:] if any(vector[3:]) else None
    if isinstance(vector, tuple) and len(vector) == 4 and isinstance(vector[0], Way):
        return vector[0], vector[1:] if any(vector[1:]) else None
    if isinstance(vector, Place):
        raise Unread("a velocity that only the simulation knows")
    return (None, vector) if turning else (vector, None)


def _silent(node: ast.stmt) -> bool:
    """Statements that do nothing to the simulation."""
    if isinstance(node, ast.Pass | ast.Import | ast.ImportFrom):
        return True
    if isinstance(node, ast.Expr):
        said = ast.unparse(node.value) if isinstance(node.value, ast.Call) else ""
        return isinstance(node.value, ast.Constant) or said.startswith(("print(", "super()"))
    return False
