"""`physagent bench words`: whether free words to the planner do what is meant, or ask."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from physagent_studio.agent.rules.planner.asked import Change, suggested, understood
from physagent_studio.agent.rules.planner.overruled import demands, is_wished
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case

FIELDS = {
    "magnitude": "strength", "timing": "start", "duration": "length", "elevation": "upwards",
    "density": "weight", "restitution": "bounciness", "friction": "friction",
    "rolling": "rolling", "pace": "pace", "direction": "direction",
}  # fmt: skip
"""Factors of the planner, as the file of words calls them."""
WAYS = {"more": 1, "left": 1, "less": -1, "right": -1}
LEAST_RIGHT = 0.8
"""Share of the words that has to do what is meant, or to offer it."""
APART = 0.8
"""How far apart, m, the things of a bare scene stand."""


def bench(cases: Path | None = None, out: Path | None = None) -> list[Row]:
    """Shares of what is done, offered, asked and done wrongly; each wrong one with its words.

    cases: the file of words. out: a Markdown file to write.
    """
    path = cases or Path("tests") / "data" / "free_words.yaml"
    if not path.is_file():
        raise InputError(f"there is no file of words at {path}; name one with --cases")
    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    programs = {name: program_of(one) for name, one in data["programs"].items()}
    rows: list[Row] = []
    for group in [key for key in data if key != "programs"]:
        rows += _rows(group, data[group], programs)
    if out is not None:
        lines = [f"| {row.name} | {row.value} | {row.bound} |" for row in rows]
        out.write_text("\n".join(["| what | value | bound |", "|---|---|---|", *lines, ""]))
    return rows


def _rows(group: str, lines: Sequence[Any], programs: dict[str, PhysicalProgram]) -> list[Row]:
    found = [(outcome(programs[one["program"]], one["words"], one["meant"]), one) for one in lines]
    count = {key: sum(said == key for said, _ in found) for key in OUTCOMES}
    right = (count["done"] + count["offered"]) / max(len(found), 1)
    rows = [
        at_least(f"{group}: does what is meant, or offers it", round(right, 3), LEAST_RIGHT),
        at_most(f"{group}: does something else", count["wrong"], 0),
        *(shown(f"{group}: {OUTCOMES[key]}", value) for key, value in count.items()),
    ]
    wrong = [one["words"] for said, one in found if said in ("wrong", "missed")]
    return rows + [shown(f"{group}: not right", words) for words in wrong]


OUTCOMES = {
    "done": "does it", "offered": "offers it, or asks openly", "missed": "offers something else",
    "wrong": "does something else",
}  # fmt: skip


def outcome(program: PhysicalProgram, words: str, meant: Any) -> str:
    """What became of words: done, offered, missed or wrong."""
    told = understood(program, words)
    event = not told.heard and bool(demands(_case(program), program, words))
    demanded = event and is_wished(words)
    if meant == "nothing":
        return "wrong" if told.changes or told.kept or demanded else "offered"
    wanted = [tuple(one) for one in meant]
    fields = {field for field, _, _ in wanted}
    done = [_is_one(one, wanted) for one in told.changes]
    done += [("keep", "", path.split(".")[-1]) in wanted for path in told.kept]
    done += ["photo" in fields] if told.photo else []
    done += ["demand" in fields] if demanded else []
    if done:
        return "done" if all(done) else "wrong"
    near = told if told.open else suggested(program, words)
    offers = [_is_one(one, wanted) for one in near.shown]
    offers += [near.photo and "photo" in fields, event and "demand" in fields]
    return "offered" if any(offers) else "missed"


def _is_one(one: Change, wanted: Sequence[tuple[str, str, str]]) -> bool:
    return any(
        FIELDS[one.knob.factor] == field
        and owner in ("", one.owner)
        and (one.sign == 0 or WAYS.get(way, one.sign) == one.sign)
        for field, way, owner in wanted
    )


def program_of(told: Any) -> PhysicalProgram:
    """A bare scene with these things in a row, and these actions."""
    shapes = {
        "sphere": {"kind": "sphere", "radius": 0.1},
        "box": {"kind": "box", "size": [0.2, 0.2, 0.3]},
    }
    objects = [
        {
            "name": name,
            "shape": shapes[kind],
            "position": [APART * at, 2.0, 0.1],
            "source": "person",
        }
        for at, (name, kind) in enumerate(told["objects"].items())
    ]
    floor = {"name": "floor", "shape": {"kind": "floor"}}
    scene = {"objects": objects, "supports": [floor]}
    return PhysicalProgram.model_validate(
        {"scene": scene, "event": {"prompt": "", "actions": told["actions"]}}
    )


def _case(program: PhysicalProgram) -> Case:
    names = [(item.name, item.grounding) for item in program.scene.objects]
    return Case("words", None, "", tuple(names), (), (), program.event.prompt)
