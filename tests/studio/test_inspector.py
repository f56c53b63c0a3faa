"""Forms: every choice that is offered is a program at once, and has the units that it should."""

from __future__ import annotations

from typing import Any

import pytest

from physagent_studio.program import PhysicalProgram, SetField, apply
from physagent_studio.program.text.document import load_program
from physagent_studio.studio.panels import inspector
from physagent_studio.studio.panels.words import spoken
from physagent_studio.studio.view import Selection, View
from physagent_studio.workbench import Snapshot

PROGRAM = """
scene:
  objects:
    - {name: red_ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
    - {name: box, shape: {kind: box, size: [0.2, 0.3, 0.4]}, position: [1, 2, 0.2]}
  supports:
    - {name: floor, shape: {kind: floor}}
    - {name: table, shape: {kind: box, position: [3, 2, 0.4], size: [1, 0.8, 0.8]}}
event:
  prompt: The ball hits the box.
  actions:
    - {operator: SetVelocity, id: go, name: red_ball, velocity: [3, 4, 0], start_step: 0}
    - {operator: ApplyDisturbance, id: gust, name: box, model: wind, amplitude: 2, start_step: 9,
       duration: 20}
contract:
  clauses: [{id: c1, text: hits the box}]
  statements: [{id: hit, kind: contacts, subject: red_ball, other: box, clause: c1}]
"""
THINGS = [
    ("object", "red_ball"),
    ("object", "box"),
    ("support", "floor"),
    ("support", "table"),
    ("action", "go"),
    ("action", "gust"),
    ("statement", "hit"),
]


def _form(kind: str, name: str) -> tuple[PhysicalProgram, dict[str, Any]]:
    program = load_program(PROGRAM)
    snapshot = Snapshot(revision=1, program=program)
    return program, inspector.state_of(snapshot, View(selection=Selection(kind, name)))


def _all(fields: list[dict[str, Any]]) -> list[dict[str, Any]]:
    inner = [sub for one in fields for sub in _all(one.get("fields", []))]
    chosen = [choice.get("fields", []) for one in fields for choice in one.get("choices", [])]
    return [*fields, *inner, *(sub for part in chosen for sub in _all(part))]


@pytest.mark.parametrize(("kind", "name"), THINGS)
def test_every_choice_is_a_program_at_once(kind: str, name: str) -> None:
    program, form = _form(kind, name)
    offered = 0
    for field in _all(form["fields"]):
        for choice in field.get("choices", ()):
            apply(program, [SetField(path=field["path"], value=choice["seed"])])
            offered += 1
    assert offered or kind == "statement"


def test_the_shape_of_a_thing_has_its_numbers() -> None:
    _, form = _form("object", "red_ball")
    shape = next(one for one in form["fields"] if one["label"] == "Shape")
    titles = [one["title"] for one in shape["choices"]]
    assert titles[:3] == ["ball", "ellipsoid", "box"]
    assert "ring" in titles
    assert not {"mesh", "round, by its outline", "its outline, rounded"} & set(titles), (
        "nothing to make them from"
    )
    ball = shape["choices"][0]["fields"]
    assert [(one["label"], one["value"], one["unit"]) for one in ball] == [("Radius", 0.1, "m")]
    # Another kind is of the same size.
    box = next(one for one in shape["choices"] if one["tag"] == "box")
    assert box["seed"] == {"kind": "box", "size": [0.2, 0.2, 0.2]}


def test_an_action_may_wait_for_something() -> None:
    _, form = _form("action", "go")
    starts = next(one for one in form["fields"] if one["label"] == "Starts")
    seeds = {one["title"]: one["seed"] for one in starts["choices"]}
    assert seeds["when two things touch"] == {"kind": "on_contact", "a": "red_ball", "b": "box"}
    assert seeds["after another action"] == {"kind": "after", "action": "gust"}
    held = seeds["when something has happened"]["statement"]
    assert (held["kind"], held["subject"]) == ("moves", "red_ball")


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("velocity", [3, 4, 0], ""),
        ("velocity", [300, 400, 0], "may give it 500 m/s; up to 12 m/s are usual"),
        ("velocity", {"magnitude": -99999, "direction": "left"}, "99999 m/s"),
        ("velocity", {"magnitude": -2, "direction": "left"}, "the other way round"),
    ],
)
def test_what_is_far_from_usual_is_said(path: str, value: Any, said: str) -> None:
    whole = f"event.actions.go.{path}"
    program = apply(load_program(PROGRAM), [SetField(path=whole, value=value)])
    snapshot = Snapshot(revision=1, program=program)
    form = inspector.state_of(snapshot, View(selection=Selection("action", "go")))
    where = f"{whole}.magnitude" if isinstance(value, dict) else whole
    assert set(form["warnings"]) == ({where} if said else set())
    assert said in form["warnings"].get(where, "")


def test_names_and_paths_in_sentences_are_spoken() -> None:
    program = load_program(PROGRAM)
    assert spoken("red_ball hits box at -3.5", program) == "red ball hits box at −3.5"
    missed = "Because red_ball tilts 0° ≥ 45°: no: push it"
    assert spoken(missed, program) == "Because red ball tilts 0°, less than 45°: push it"
    assert (
        spoken("it moves 2 m ≥ 3 m: no, at all", program) == "it moves 2 m, less than 3 m, at all"
    )
    assert spoken("scene.objects.red_ball.position", program) == "red ball · position"
    assert spoken("my_red_ball and red_ball_2", program) == "my_red_ball and red_ball_2"
