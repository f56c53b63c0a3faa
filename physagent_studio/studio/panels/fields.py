"""Fields: every number of a program that a person may choose by clicks, with its words and unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from physagent_studio.program import MATERIALS, Action, PhysicalProgram
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.studio.panels.words import (
    DIRECTED_UNITS,
    OF_MATERIAL,
    plain,
    unit_of,
)

SPOKEN = {
    "start_step": "start",
    "duration": "length",
    "magnitude": "strength",
    "elevation": "upwards",
    "azimuth": "aside",
    "amplitude": "strength",
    "angle": "direction",
    "frequency": "frequency",
    "delay": "delay",
    "density": "density",
    "friction": "friction",
    "restitution": "bounciness",
    "rolling": "rolling resistance",
}
"""Numbers that are offered, as a person calls them."""


def fields_of(program: PhysicalProgram) -> list[dict[str, Any]]:
    """One row for each number: whose it is, what it is, where it stands, and how it is shown."""
    rows = [row for action in program.event.actions for row in _of_action(action, program)]
    return rows + [row for item in program.scene.objects for row in _of_object(item)]


def _of_action(action: Action, program: PhysicalProgram) -> Iterator[dict[str, Any]]:
    base, step = f"event.actions.{action.id}", program.clip.step_seconds
    for path, field, value, quantity in _numbers(plain(action), base, ""):
        steps = unit_of(path) == "steps"
        unit = DIRECTED_UNITS.get(quantity, "") if field == "magnitude" else ""
        yield {
            "of": action.id.replace("_", " "),
            "what": SPOKEN[field],
            "path": path,
            "value": value,
            "unit": "s" if steps else unit or unit_of(path),
            "scale": step if steps else 1.0,
            "whole": steps,
        }


def _numbers(
    data: dict[str, Any], base: str, quantity: str
) -> Iterator[tuple[str, str, float, str]]:
    for key, value in data.items():
        if isinstance(value, dict) and key != "statement":
            yield from _numbers(value, f"{base}.{key}", str(value.get("quantity", "")))
        elif key in SPOKEN and isinstance(value, int | float) and not isinstance(value, bool):
            yield f"{base}.{key}", key, value, quantity


def _of_object(item: SceneObject) -> Iterator[dict[str, Any]]:
    for field in sorted(OF_MATERIAL):
        own = getattr(item, field)
        value = own if own is not None else getattr(MATERIALS[item.material], field)
        yield {
            "of": item.name.replace("_", " "),
            "what": SPOKEN[field],
            "path": f"scene.objects.{item.name}.{field}",
            "value": value,
            "unit": unit_of(field),
            "scale": 1.0,
            "whole": False,
        }
