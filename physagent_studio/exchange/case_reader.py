"""Reads `case.yaml`: every finding is one sentence with the file and the line."""

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_clicks import MARKS, marks_of
from physagent_studio.exchange.plain_yaml import MAX_BYTES, Place, PlainYaml, read_yaml
from physagent_studio.program.scene.materials import MATERIALS
from physagent_studio.program.scene.state import (
    Click,
    Grounding,
    Landmark,
    Support,
    SupportShape,
)
from physagent_studio.program.text.problems import problems_of

MAX_OBJECTS = 200
MAX_SUPPORTS = 64
MAX_LANDMARKS = 64
MAX_POINTS = 500
MAX_PROMPT = 4000
RESERVED = ("air",)
_KINDS = ("point", "line", "area", "opening")
CLICKED = ("horizon", "scale", "objects", "supports", "landmarks")
_ROOT = ("image", "size", *CLICKED, "events")
_SHAPE: TypeAdapter[Any] = TypeAdapter(SupportShape)


def slug(name: str) -> str:
    """A name as programs write it: blanks become `_`, other signs go; "" if nothing is left."""
    text = re.sub(r"\s+", "_", name.strip())
    return re.sub(r"[^A-Za-z0-9_\-]", "", text).lstrip("-")[:64]


def _at(place: Place) -> str:
    """Where in the file, as a dotted path for the end of a message."""
    return f" (at {'.'.join(str(part) for part in place)})" if place else ""


def check_inside(x: float, y: float, size: tuple[int, int], what: str, where: str = "") -> None:
    """That a click is in the picture of `size` (width, height).

    what: starts the message; where: ends it.
    """
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError(f"{what}: a click must be finite numbers, not ({x:g}, {y:g}){where}")
    if not (0 <= x < size[0] and 0 <= y < size[1]):
        raise InputError(
            f"{what}: the click ({x:g}, {y:g}) lies outside the picture "
            f"(x 0 … {size[0] - 1}, y 0 … {size[1] - 1}){where}"
        )


SLIPPED = 0.1
"""Part of the picture by which a box may be drawn beyond it."""


def clipped(
    box: tuple[float, float, float, float], size: tuple[int, int]
) -> tuple[float, float, float, float]:
    """The box without what a drag went beyond the picture of `size` (width, height); as it is
    where that is more than a slip, or is not a box."""
    left, top, right, bottom = (
        min(max(value, 0.0), float(end)) for value, end in zip(box, (*size, *size), strict=True)
    )
    beyond = max(abs(a - b) for a, b in zip(box, (left, top, right, bottom), strict=True))
    slip = beyond <= SLIPPED * max(size) and left < right and top < bottom
    return (left, top, right, bottom) if slip else box


def box_fault(box: tuple[float, float, float, float], size: tuple[int, int]) -> str:
    """What is wrong with a box in the picture of `size` (width, height); "" for nothing."""
    left, top, right, bottom = box
    if not (left < right and top < bottom):
        return "a box is [left, top, right, bottom]: left before right, top above bottom"
    if left >= 0 and right <= size[0] and top >= 0 and bottom <= size[1]:
        return ""
    return f"the box must lie in the picture (x 0 … {size[0]}, y 0 … {size[1]})"


def same_spot(found: Sequence[tuple[str, Sequence[Click]]], clicks: Sequence[Click]) -> str:
    """What is wrong with clicks inside a thing that are those of another one; "" for nothing."""
    taken = {(one.x, one.y): name for name, own in found for one in own if one.label}
    both = next((one for one in clicks if one.label and (one.x, one.y) in taken), None)
    if both is None:
        return ""
    return (
        f"({both.x:g}, {both.y:g}) is clicked for '{taken[both.x, both.y]}' too; a place in the"
        " picture shows one thing"
    )


class CaseReader:
    """One case.yaml being read; every message carries its file and line.

    known: which entries the file may have.
    """

    def __init__(self, path: Path, known: Sequence[str] = _ROOT) -> None:
        self.path = path
        self.names: dict[str, Place] = {}
        self.doc: PlainYaml = read_yaml(_text(path), str(path))
        if not isinstance(self.doc.data, dict):
            raise InputError(f"{path}: a case is a mapping with image, objects and events")
        self.known((), self.doc.data, known)

    def fail(self, place: Place, what: str) -> InputError:
        return InputError(f"{self._line(place)}: {what}{_at(place)}")

    def _line(self, place: Place) -> str:
        return f"{self.path}, line {self.doc.line(place)}"

    def image_path(self) -> Path:
        """The photo's path, inside the case folder."""
        given = self.doc.data.get("image")
        if not isinstance(given, str) or not given:
            raise self.fail(("image",), "image must name the photo's file")
        folder = self.path.parent.resolve()
        image = (folder / given).resolve()
        if not image.is_relative_to(folder):
            raise self.fail(("image",), f"image '{given}' lies outside the case folder")
        if not image.is_file():
            raise self.fail(("image",), f"image '{given}' does not exist in {self.path.parent}")
        return image

    def check_size(self, image: Path, size: tuple[int, int]) -> None:
        """That the stated size, if any, is the photo's, so that the clicks mean its pixels."""
        stated = self.doc.data.get("size")
        if stated is None:
            return
        whole = isinstance(stated, list) and len(stated) == 2
        if not whole or not all(type(v) is int and v > 0 for v in stated):
            raise self.fail(("size",), "size must be [width, height] in whole pixels")
        if tuple(stated) != size:
            raise self.fail(
                ("size",),
                f"size is {stated[0]}×{stated[1]}, but {image.name} is {size[0]}×{size[1]}",
            )

    def objects(self, size: tuple[int, int]) -> tuple[tuple[str, Grounding], ...]:
        """Names and groundings, in the file's order."""
        found: list[tuple[str, Grounding]] = []
        for name, place, entry in self.things("objects", MAX_OBJECTS):
            self.known(place, entry, ("points", "box"))
            grounding = self.grounding(place, entry, size)
            if twice := same_spot([(one, own.points) for one, own in found], grounding.points):
                raise self.fail(place, f"object '{name}': {twice}")
            said = bool(entry.get("points") or entry.get("box"))
            if said and not grounding.shows_something:
                raise self.fail(place, f"object '{name}' needs a click inside it, or a box")
            found.append((name, grounding))
        if not found:
            raise self.fail(
                ("objects",),
                "objects must name at least one object: `ball: {points: [[x, y, 1]]}`,"
                " or `ball: {}` to have it found by its name",
            )
        return tuple(found)

    def supports(self, size: tuple[int, int]) -> tuple[Support, ...]:
        """Supports with their clicks and, where the case states it, their shape."""
        found = []
        for name, place, entry in self.things("supports", MAX_SUPPORTS):
            self.known(place, entry, ("points", "box", "shape", "material", *MARKS))
            material = entry.get("material", Support.model_fields["material"].default)
            if material not in MATERIALS:
                raise self.fail(
                    (*place, "material"),
                    f"there is no material '{material}' (known: {', '.join(MATERIALS)})",
                )
            shape = self._shape(place, entry.get("shape"))
            grounding = self.grounding(place, entry, size).model_copy(
                update={"marks": marks_of(self, name, place, entry, size)}
            )
            source = "estimated" if shape is None else "given"
            found.append(
                Support(
                    name=name, grounding=grounding, shape=shape, material=material, source=source
                )
            )
        return tuple(found)

    def landmarks(self, size: tuple[int, int], others: Sequence[str] = ()) -> tuple[Landmark, ...]:
        """Named places with their pixels. others: further names that they may be `on`."""
        solid = tuple(dict.fromkeys((*others, *self.names)))
        found = []
        for name, place, entry in self.things("landmarks", MAX_LANDMARKS):
            self.known(place, entry, ("kind", "points", "on"))
            kind = entry.get("kind")
            if kind not in _KINDS:
                raise self.fail((*place, "kind"), f"kind must be one of {', '.join(_KINDS)}")
            points = [self.pair(p, q, size) for p, q in self._points(place, entry)]
            if not points:
                raise self.fail(place, f"landmark '{name}' needs points [[x, y], …]")
            on = entry.get("on")
            if on is not None and (not isinstance(on, str) or slug(on) not in solid):
                raise self.fail(
                    (*place, "on"), f"there is no support '{on}' (known: {', '.join(solid)})"
                )
            found.append(
                Landmark(
                    name=name,
                    kind=kind,
                    on=slug(on) if on else None,
                    pixels=tuple(points[:64]),
                    source="given",
                )
            )
        return tuple(found)

    def events(self) -> tuple[tuple[str, str], ...]:
        """(name, prompt) in the file's order."""
        entries = self.doc.data.get("events") or {}
        if not isinstance(entries, dict):
            raise self.fail(("events",), "events must be a mapping of names to prompts")
        for name, prompt in entries.items():
            place = ("events", name)
            if not isinstance(prompt, str) or not prompt.strip():
                raise self.fail(place, f"event '{name}' needs a sentence as its prompt")
            if len(prompt) > MAX_PROMPT:
                raise self.fail(place, f"event '{name}' has more than {MAX_PROMPT} characters")
        return tuple((name, " ".join(prompt.split())) for name, prompt in entries.items())

    def check_names(self) -> None:
        """That nothing is called what the program keeps for itself."""
        for name in RESERVED:
            if name in self.names:
                raise self.fail(self.names[name], f"'{name}' is a reserved name")

    # --- parts -------------------------------------------------------------------------------

    def things(self, room: str, limit: int) -> list[tuple[str, Place, dict[str, Any]]]:
        entries = self.doc.data.get(room)
        if entries is None:
            return []
        if not isinstance(entries, dict):
            raise self.fail((room,), f"{room} must be a mapping of names")
        if len(entries) > limit:
            raise self.fail((room,), f"there are {len(entries)} {room} (at most {limit})")
        found = []
        for given, entry in entries.items():
            place: Place = (room, given)
            name = slug(given)
            if not name:
                raise self.fail(place, f"'{given}' is no name (letters, digits, _ and -)")
            if name in self.names:
                raise self.fail(place, f"the name '{name}' is used twice")
            self.names[name] = place
            if entry is not None and not isinstance(entry, dict):
                raise self.fail(place, f"'{given}' must be a mapping with points")
            found.append((name, place, entry or {}))
        return found

    def known(self, place: Place, entry: Mapping[str, Any], known: Sequence[str]) -> None:
        for key in entry:
            if key not in known:
                near = difflib.get_close_matches(key, known, 1, 0.6)
                hint = f"; did you mean '{near[0]}'?" if near else ""
                raise self.fail(
                    (*place, key), f"'{key}' is not known here (known: {', '.join(known)}{hint})"
                )

    def _points(self, place: Place, entry: Mapping[str, Any]) -> list[tuple[Place, list[Any]]]:
        points = entry.get("points") or []
        where = (*place, "points")
        if not isinstance(points, list):
            raise self.fail(where, "points must be a list of [x, y, label]")
        if len(points) > MAX_POINTS:
            raise self.fail(where, f"there are {len(points)} points (at most {MAX_POINTS})")
        return [((*where, index), point) for index, point in enumerate(points)]

    def grounding(self, place: Place, entry: Mapping[str, Any], size: tuple[int, int]) -> Grounding:
        clicks = []
        for where, point in self._points(place, entry):
            x, y = self.pair(where, point, size)
            label = point[2] if len(point) > 2 else 1
            if type(label) is not int or label not in (0, 1):
                raise self.fail(where, f"a label is 1 (inside) or 0 (outside), not {label!r}")
            clicks.append(Click(x=x, y=y, label=1 if label else 0))
        return Grounding(points=tuple(clicks), box=self._box(place, entry.get("box"), size))

    def pair(self, where: Place, point: Any, size: tuple[int, int]) -> tuple[float, float]:
        if not isinstance(point, list) or len(point) not in (2, 3):
            raise self.fail(where, "a point must be [x, y, label]")
        x, y = (self.number(where, value) for value in point[:2])
        check_inside(x, y, size, self._line(where), _at(where))
        return x, y

    def number(self, where: Place, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(where, f"{value!r} is no number")
        if not math.isfinite(value):
            raise self.fail(where, f"{value!r} is not finite")
        return float(value)

    def _box(
        self, place: Place, box: Any, size: tuple[int, int]
    ) -> tuple[float, float, float, float] | None:
        if box is None:
            return None
        where = (*place, "box")
        if not isinstance(box, list) or len(box) != 4:
            raise self.fail(where, "a box must be [left, top, right, bottom]")
        left, top, right, bottom = (self.number(where, value) for value in box)
        if fault := box_fault((left, top, right, bottom), size):
            raise self.fail(where, fault)
        return left, top, right, bottom

    def _shape(self, place: Place, data: Any) -> Any:
        if data is None:
            return None
        try:
            return _SHAPE.validate_python(data)
        except ValidationError as error:
            problem = problems_of(error, data)[0]
            where = f"shape.{problem.path}".rstrip(".")
            allowed = f" ({problem.allowed})" if problem.allowed else ""
            text = f"{where} {problem.message}{allowed}"
            raise self.fail((*place, "shape"), text) from error


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path} is larger than a case may be ({MAX_BYTES} bytes)")
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no UTF-8 text") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error
