"""The events of `events.yaml`, and the benchmark's scenes written as case folders."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import yaml

from physagent_studio.benchmark.paper import pictures
from physagent_studio.program.contract import Contract

EVENTS = Path(__file__).with_name("events.yaml")
FAMILIES = {
    "fine": "fine object dynamics",
    "force": "force interactions",
    "path": "complex trajectories",
    "ordered": "ordered events",
    "material": "materials",
}


@dataclass(frozen=True, slots=True)
class Event:
    """One event: which picture, its sentence, its family and its reference contract."""

    scene: str
    name: str
    family: str
    prompt: str
    reference: Contract

    @property
    def label(self) -> str:
        """`scene/event`."""
        return f"{self.scene}/{self.name}"


@cache
def events() -> tuple[Event, ...]:
    """All events, in the order of the pictures."""
    said = yaml.safe_load(EVENTS.read_text(encoding="utf-8"))
    return tuple(
        Event(scene, name, row["family"], row["prompt"], _contract(row["prompt"], row["holds"]))
        for scene in pictures.said_of_scenes()["scenes"]
        for name, row in said[scene].items()
    )


def _contract(prompt: str, holds: Sequence[Mapping[str, Any]]) -> Contract:
    """A contract whose statements all speak of the whole sentence."""
    statements = [{"id": f"s{k}", "clause": "all", **row} for k, row in enumerate(holds, 1)]
    clauses = [{"id": "all", "text": prompt}]
    return Contract.model_validate({"clauses": clauses, "statements": statements})


def write_case(scene: str, folder: Path) -> Path:
    """Draws a scene and writes it as a case folder with its references beside it.

    Returns the case folder, `folder`/cases/`scene`; references go to `folder`/references. A picture
    that was drawn from the same lines before is left as it is.
    """
    case, references = folder / "cases" / scene, folder / "references"
    mine = [event for event in events() if event.scene == scene]
    references.mkdir(parents=True, exist_ok=True)
    for event in mine:
        held = {"contract": event.reference.model_dump(mode="json", exclude_none=True)}
        path = references / f"{scene}__{event.name}.yaml"
        path.write_text(yaml.safe_dump(held), encoding="utf-8")
    stamp = case / "drawn_from.txt"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == _lines(scene):
        return case
    case.mkdir(parents=True, exist_ok=True)
    shot = pictures.taken(scene)
    cv2.imwrite(str(case / "input.png"), shot.image[..., ::-1])
    text = yaml.safe_dump(_case(shot, mine), sort_keys=False, width=1000)
    (case / "case.yaml").write_text(text, encoding="utf-8")
    stamp.write_text(_lines(scene), encoding="utf-8")
    return case


def _lines(scene: str) -> str:
    """What decides about a picture and its sentences."""
    every = pictures.said_of_scenes()
    drawn = {"kinds": every["kinds"], "colours": every["colours"], "scene": every["scenes"][scene]}
    told = {event.name: event.prompt for event in events() if event.scene == scene}
    return yaml.safe_dump(drawn | {"seed": pictures.seed_of(scene), "events": told})


def _case(shot: pictures.Taken, mine: Sequence[Event]) -> dict[str, Any]:
    """What a person gives: a click into each thing and a box around it; no box for supports."""
    height, width = shot.image.shape[:2]
    supports = {p.name: _grounding(shot, p) for p in shot.props if p.said.get("support")}
    marks = {
        p.name: {
            "kind": p.said["landmark"],
            "points": pictures.ends_of(shot.camera, p).round(1).tolist(),
        }
        for p in shot.props
        if "landmark" in p.said
    }
    return {
        "image": "input.png",
        "size": [width, height],
        "objects": {p.name: _grounding(shot, p) for p in shot.props if p.asked},
        **({"supports": supports} if supports else {}),
        **({"landmarks": marks} if marks else {}),
        "events": {event.name: event.prompt for event in mine},
    }


def _grounding(shot: pictures.Taken, prop: pictures.Prop) -> dict[str, Any]:
    mask = shot.masks[prop.name]
    said: dict[str, Any] = {"points": [[*pictures.click_on(mask), 1]]}
    if prop.asked:
        said["box"] = pictures.box_around(mask)
    return said
