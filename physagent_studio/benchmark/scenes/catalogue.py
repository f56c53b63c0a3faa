"""Things out of `things.yaml`: built from their parts with chance in every measure, and placed."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from physagent_studio.arrays import FloatArray
from physagent_studio.benchmark.scenes import forms
from physagent_studio.benchmark.scenes.forms import Form
from physagent_studio.benchmark.scenes.paints import Paint, drawn_colour

LIST = Path(__file__).with_name("things.yaml")
STRAY, STRETCH = 0.06, 0.1
"""Spread (log) of the sizes of round parts, and of heights over widths, among things of a name."""


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """One coloured piece of a thing. form: in the frame of the thing, or of the world."""

    form: Form
    paint: Paint


@dataclass(frozen=True, eq=False, slots=True)
class Thing:
    """name: what it is called. parts: they stand on z = 0 until they are placed."""

    name: str
    parts: tuple[Part, ...]

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest x, y, z."""
        every = np.vstack([part.form.vertices for part in self.parts])
        return every.min(0), every.max(0)


@cache
def listed() -> Mapping[str, Mapping[str, Any]]:
    """What `things.yaml` says, by name."""
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))


def names_of(group: str) -> list[str]:
    """The things that are found together in a kind of place."""
    return [name for name, said in listed().items() if group in np.atleast_1d(said["group"])]


def built(
    name: str, rng: np.random.Generator, said: Mapping[str, Any] | None = None, exact: bool = False
) -> Thing:
    """A thing of that name whose largest side is one metre, at the origin, turned by chance.

    said: its parts and colours, by default those of the list. exact: as said, neither turned nor
    stretched by chance.
    """
    said = said or listed()[name]
    colours = {role: drawn_colour(rng, kind) for role, kind in said["colours"].items()}
    parts: list[Part] = []
    for part in said["parts"]:
        if rng.random() < part.get("chance", 1.0):
            parts += _parts(part, colours, rng)
    faces = 0 if exact else said.get("faces", 180)
    tall = (1.0, 1.0, 1.0 if exact else float(np.exp(rng.normal(0, STRETCH))))
    thing = reshaped(Thing(name, tuple(parts)), lambda points: points * tall)
    thing = turned(thing, math.radians(float(rng.uniform(-faces, faces))))
    low, high = thing.bounds
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return placed(thing, -middle, 1 / float((high - low).max()))


def _parts(
    said: Mapping[str, Any], colours: Mapping[str, FloatArray], rng: np.random.Generator
) -> list[Part]:
    """A part of the list with its mirror image and its repetitions."""
    paint = _paint(said, colours, rng)
    form = _form(said, rng)
    moved = _moved(form, np.asarray(said.get("at", (0, 0, 0)), float), said.get("turn", (0, 0, 0)))
    out = [moved]
    if said.get("mirror"):
        out.append(_with(moved, moved.vertices * (-1, 1, 1)))
    out += [_with(one, one.vertices + by) for one in list(out) for by in said.get("also", ())]
    count = said.get("around", 1)
    for k in range(1, count):
        out.append(_with(moved, moved.vertices @ _about_up(2 * math.pi * k / count).T))
    return [Part(one, paint) for one in out]


def _form(said: Mapping[str, Any], rng: np.random.Generator) -> Form:
    stray = float(np.exp(rng.normal(0, STRAY)))
    if said["form"] == "tube":
        return forms.tube(said["through"], said["thick"] * stray, said.get("sharp", False))
    if said["form"] == "lathe":
        return forms.lathe(said["profile"])
    size = said["size"]
    if said["form"] == "can":
        return forms.can(size, said.get("taper", 1.0))
    if said["form"] == "ring":
        return forms.ring(size)
    if said["form"] == "brick":
        return forms.brick(size, said.get("right", 1.0))
    if said["form"] == "block":
        # Its flat sides need corners rather than many points: a grid's crowd at the edges.
        return forms.ball(size, max(said.get("round", 0.12), 0.02))
    # What is flat has to fit to other parts; only round ones stray.
    return forms.ball([side * stray for side in size])


def _paint(
    said: Mapping[str, Any], colours: Mapping[str, FloatArray], rng: np.random.Generator
) -> Paint:
    spelt = said["paint"]
    words: Sequence[Any] = [spelt] if isinstance(spelt, str) else spelt
    pattern = words[1] if len(words) > 1 else "plain"
    # A pattern may be missing: things of one name are made in plain colours too.
    if pattern != "fur" and rng.random() < 0.15:
        pattern = "plain"
    return Paint(
        colour=colours[words[0]],
        other=colours[words[2]] if len(words) > 2 else colours[words[0]],
        pattern=pattern,
        repeats=float(words[3]) if len(words) > 3 else 1.0,
        gloss=float(said.get("gloss", 0.08)),
        seed=int(rng.integers(2**31)),
    )


def turned(thing: Thing, yaw: float) -> Thing:
    """The thing turned about the vertical."""
    return reshaped(thing, lambda points: points @ _about_up(yaw).T)


def turned_in_place(thing: Thing, yaw: float) -> Thing:
    """The thing turned about the vertical through the middle of its bounds."""
    low, high = thing.bounds
    middle = (low + high) / 2 * (1, 1, 0)
    return placed(turned(placed(thing, -middle), yaw), middle)


def placed(thing: Thing, by: FloatArray, scale: float = 1.0) -> Thing:
    """The thing moved by (3,) metres and then scaled about the origin."""
    return reshaped(thing, lambda points: (points + by) * scale)


def reshaped(thing: Thing, change: Callable[[FloatArray], FloatArray]) -> Thing:
    """The thing with a change of all its vertices (N, 3)."""
    parts = (replace(p, form=_with(p.form, change(p.form.vertices))) for p in thing.parts)
    return replace(thing, parts=tuple(parts))


def _with(form: Form, vertices: FloatArray) -> Form:
    return replace(form, vertices=vertices)


def _moved(form: Form, at: FloatArray, turn: Sequence[float]) -> Form:
    """Turned about x, y and then z by degrees, and moved."""
    a, b, c = (math.radians(value) for value in turn)
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    return _with(form, form.vertices @ (_about_up(c) @ about_y @ about_x).T + at)


def _about_up(yaw: float) -> FloatArray:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
