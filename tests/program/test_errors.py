"""What a person reads when a program is wrong: golden texts, one per mistake.

To write them anew after a deliberate change:

    PHYSAGENT_REGENERATE=1 python -m pytest tests/program/test_errors.py
"""

import os
from pathlib import Path

import pytest

from physagent_studio.errors import ProgramError
from physagent_studio.program import AddItem, MoveItem, RemoveItem, SetField, apply
from physagent_studio.program.text.document import load_program
from physagent_studio.program.text.fuzz import SEED_TEXT, fuzz_programs

GOLDEN = Path(__file__).resolve().parent.parent / "golden" / "program_errors.txt"

MISTAKES = {
    "unknown field": ("support: floor", "suport: floor"),
    "missing field": ("    duration: 10\n", ""),
    "unknown operator": ("operator: ApplyForce", "operator: AplyForce"),
    "no operator": ("    operator: ApplyForce\n", ""),
    "unknown shape": ("kind: sphere", "kind: sfere"),
    "unknown statement": ("kind: contacts, ", "kind: contact, "),
    "unknown word": ("magnitude: 3, toward: crate", "magnitude: 3, direction: lefft"),
    "two meanings of a vector": ("toward: crate", "toward: crate, direction: left"),
    "a vector that is a number": ("force: [5, 0, 0]", "force: 5"),
    "a vector with two numbers": ("force: [5, 0, 0]", "force: [5, 0]"),
    "a vector with four numbers": ("force: [5, 0, 0]", "force: [5, 0, 0, 0]"),
    "a word in a vector": ("force: [5, 0, 0]", "force: [5, fast, 0]"),
    "text for a number": ("radius: 0.11", "radius: '0.11'"),
    "a number for text": ("- id: kick", "- id: 3"),
    "a comma as decimal point": ("density: 120.0", "density: 120,0"),
    "a fraction of a step": ("duration: 10", "duration: 10.5"),
    "a negative size": ("radius: 0.11", "radius: -0.11"),
    "a force beyond bounds": ("force: [5, 0, 0]", "force: [5e9, 0, 0]"),
    "infinity": ("density: 120.0", "density: .inf"),
    "not a number": ("density: 120.0", "density: .nan"),
    "too large a number": ("density: 120.0", "density: 1e999"),
    "a leading zero": ("duration: 10", "duration: 010"),
    "a word for true or false": ("duration: 10\n", "duration: 10\n    muted: yes\n"),
    "a zero rotation": ("[0.9238795325112867, 0.0, 0.0, 0.3826834323650898]", "[0, 0, 0, 0]"),
    "a name with a space": ("- name: crate", "- name: my crate"),
    "unknown target": ("name: ball\n    operator", "name: bal\n    operator"),
    "unknown place": ("toward: crate", "toward: crat"),
    "unknown support": ("support: floor", "support: flor"),
    "unknown material": ("material: leather", "material: lether"),
    "unknown subject": ("clause: c1, subject: ball", "clause: c1, subject: boll"),
    "unknown clause": ("kind: contacts, clause: c1", "kind: contacts, clause: c2"),
    "unknown statement in before": ("second: s2", "second: s9"),
    "a statement about itself": ("second: s2", "second: s3"),
    "a name used twice": ("- name: crate", "- name: ball"),
    "an id used twice": ("- id: push", "- id: kick"),
    "a start past the end": ("start_step: 60", "start_step: 600"),
    "a window past the end": ("start_step: 60, duration: 20", "start_step: 60, duration: 21"),
    "a duplicate key": ("duration: 10", "duration: 10\n    duration: 20"),
    "an anchor": ("duration: 10", "duration: &ten 10"),
    "an alias": ("duration: 10", "duration: *ten"),
    "a tag": ("duration: 10", "duration: !!int 10"),
    "a tab": ("    duration: 10", "\tduration: 10"),
    "an open bracket": ("force: [5, 0, 0]", "force: [5, 0, 0"),
    "an odd indent": ("    duration: 10", "   duration: 10"),
    "a second document": ("contract:", "---\ncontract:"),
    "a control character": ("a comment", "a \x07 comment"),
    "a list for the program": (SEED_TEXT, "- 1\n- 2\n"),
    "an empty text": (SEED_TEXT, ""),
    "only a comment": (SEED_TEXT, "# nothing\n"),
    "depth": (SEED_TEXT, "a: " + "[" * 60),
    "another version": ("version: 1", "version: 2"),
}

EDITS = {
    "an unknown item": SetField(path="event.actions.kik.muted", value=True),
    "an unknown field": SetField(path="event.actions.kick.velocty", value=1),
    "a field of a number": SetField(path="clip.frames.x", value=1),
    "a bad value": SetField(path="event.actions.push.duration", value=0),
    "text for a number": SetField(path="event.actions.push.duration", value="10"),
    "an item in no list": AddItem(path="clip", item={}),
    "a place past the end": AddItem(path="event.actions", item={}, index=9),
    "a move past the end": MoveItem(path="event.actions.kick", index=9),
    "removing a field": RemoveItem(path="clip.frames"),
    "removing what is needed": RemoveItem(path="scene.objects.crate"),
}


def told() -> str:
    parts = []
    for name, (before, after) in MISTAKES.items():
        assert before in SEED_TEXT, name
        with pytest.raises(ProgramError) as caught:
            load_program(SEED_TEXT.replace(before, after, 1))
        parts.append(f"[{name}]\n" + "\n".join(map(str, caught.value.problems)))
    program = load_program(SEED_TEXT)
    for name, edit in EDITS.items():
        with pytest.raises(ProgramError) as caught:
            apply(program, [edit])
        parts.append(f"[edit: {name}]\n" + "\n".join(map(str, caught.value.problems)))
    return "\n\n".join(parts) + "\n"


def test_error_texts_are_the_golden_ones():
    text = told()
    if os.environ.get("PHYSAGENT_REGENERATE"):
        GOLDEN.write_text(text, encoding="utf-8")
    assert text == GOLDEN.read_text(encoding="utf-8")


def test_every_mistake_names_its_line():
    for name, (before, after) in MISTAKES.items():
        with pytest.raises(ProgramError) as caught:
            load_program(SEED_TEXT.replace(before, after, 1))
        assert all(problem.line is not None for problem in caught.value.problems), name


def test_a_failed_edit_changes_nothing():
    program = load_program(SEED_TEXT)
    before = program.hash
    for edit in EDITS.values():
        with pytest.raises(ProgramError):
            apply(program, [SetField(path="clip.substeps", value=5), edit])
    assert program.hash == before


def test_malformed_programs_are_refused_with_path_and_line():
    report = fuzz_programs(400, seed=7)
    assert not report.failures
    assert report.accepted + report.refused == 400
    assert report.refused > 300
