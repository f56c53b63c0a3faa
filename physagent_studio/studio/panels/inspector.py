"""Inspector: a form for the selected thing, made from its pydantic model.

A form is a tree of fields. Every field carries the path of the edit that it makes, so that the
page only has to send (path, value) back and the program's own validation does the rest.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from physagent_studio.agent.rules.planner.parameters import RANGE, VECTORS
from physagent_studio.contract import describe
from physagent_studio.program import MATERIALS, Action, Directed, PhysicalProgram
from physagent_studio.program.preflight.mechanics import mass_of, speed_gain
from physagent_studio.program.scene.aloft import carriage_of, in_air
from physagent_studio.program.timing import PACE
from physagent_studio.studio.panels.forms import Form, seeds_for
from physagent_studio.studio.panels.timeline import choice_of
from physagent_studio.studio.panels.words import OPERATORS, number, plain, spoken
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.aloft_edits import foot_of

ROOTS = {
    "object": "scene.objects",
    "support": "scene.supports",
    "landmark": "scene.landmarks",
    "action": "event.actions",
    "statement": "contract.statements",
}


HELP = {
    "ApplyForce": "A push: how strong, where to, and for how long.",
    "SetVelocity": "A speed that it has at that moment, as if just thrown or let go.",
    "SetAngularVelocity": "A spin that is kept up all the time.",
    "ApplyTorque": "A twist about its middle.",
    "ApplyAngledForce": "A push aside from the way it moves, so that it curves.",
    "ApplyDisturbance": "Wind, a knock or shaking.",
    "SetPosition": "It is somewhere else at once.",
    "SetOrientation": "It is turned at once.",
    "FixObject": "It is held where it is; let go, it starts from rest.",
}
"""What each operator does, in a sentence for whoever sees its form."""


def state_of(snapshot: Snapshot, view: View) -> dict[str, Any]:
    """The form of the selection, or an invitation to select."""
    kind, name = view.selection.kind, view.selection.name
    base = {"kind": kind, "name": name, "readOnly": snapshot.read_only, "names": _names(snapshot)}
    if kind == "camera":
        return base | _form(snapshot.program.scene.camera, "scene.camera", snapshot, "Camera")
    if kind == "clip":
        return base | _clip(snapshot)
    item = _item(snapshot.program, kind, name)
    if item is None:
        return base | {"kind": "none", "title": "", "fields": []}
    title = OPERATORS.get(getattr(item, "operator", ""), "") or name.replace("_", " ")
    if kind == "statement":
        title = spoken(describe(item, snapshot.program), snapshot.program)
    form = base | _form(item, f"{ROOTS[kind]}.{name}", snapshot, title)
    if kind == "action":
        form["target"] = item.name
        form["warnings"] = _warnings(item, snapshot.program)
    if kind == "object":
        form["fields"] = [one for one in form["fields"] if one["path"] not in _held_by(name)]
        form["hold"] = _hold(snapshot, name)
        form["facts"] = _facts(snapshot, name, view.step)
        form["actions"] = [a.id for a in snapshot.program.event.actions if a.name == name]
    return form


FAR_FROM_USUAL = 3.0
"""Ratio, 2..10: how many times the speed that things are usually sent off with is pointed out."""


def _warnings(action: Action, program: PhysicalProgram) -> dict[str, str]:
    """By the path of its strength: that an action is far stronger than usual, or turned around."""
    item, field = program.scene.object(action.name), VECTORS.get(action.operator, "magnitude")
    vector = getattr(action, field, None)
    mass = None if item is None else mass_of(item)
    if vector is None or mass is None:
        return {}
    told = []
    speed, usual = speed_gain(action, mass, program.clip.step_seconds), RANGE.max_speed_mps
    if speed > FAR_FROM_USUAL * usual:
        told.append(f"This may give it {number(speed)} m/s; up to {number(usual)} m/s are usual.")
    if isinstance(vector, Directed):
        field += ".magnitude"
        vector = vector.magnitude
    if isinstance(vector, float | int) and vector < 0:
        told.append("Less than 0: it acts the other way round.")
    return {f"event.actions.{action.id}.{field}": " ".join(told)} if told else {}


def _held_by(name: str) -> tuple[str, str]:
    """What the switch of a thing sets as one."""
    return f"scene.objects.{name}.support", f"scene.objects.{name}.aloft"


def _hold(snapshot: Snapshot, name: str) -> dict[str, Any]:
    """How a thing is held, what it may stand on, and how high above the ground it is, m."""
    scene = snapshot.program.scene
    item = scene.object(name)
    assert item is not None
    others = [o.name for o in (*scene.supports, *scene.objects) if o.name != name]
    foot = foot_of(scene, item) if scene.camera is not None and in_air(item) else None
    return {
        "how": carriage_of(item),
        "on": None if in_air(item) else item.support,
        "others": others,
        "height": None if foot is None else round(foot[1], 4),
    }


def _clip(snapshot: Snapshot) -> dict[str, Any]:
    """The clip: its pace as a choice, and what is free beside it."""
    clip = snapshot.program.clip
    form = _form(clip, "clip", snapshot, "The clip")
    # The pace sets these, together with all starts and lengths.
    form["fields"] = [one for one in form["fields"] if one["path"] not in PACE]
    form["help"] = "How long it is and how fast it is shown; 1 is real time, less is slow motion."
    form["pace"] = choice_of(clip, snapshot.state.pinned)
    shown = f"{number(clip.seconds / clip.time_factor)} s"
    step = f"{number(1000 * clip.step_seconds)} ms, {clip.steps_per_frame} to a frame"
    form["facts"] = [
        {"what": "Shown for", "is": shown, "unit": ""},
        {"what": "In the event", "is": f"{number(clip.seconds)} s", "unit": ""},
        {"what": "One step", "is": step, "unit": ""},
    ]
    return form


def _item(program: PhysicalProgram, kind: str, name: str) -> Any:
    scene = program.scene
    if kind == "object":
        return scene.object(name)
    if kind == "support":
        return scene.support(name)
    if kind == "landmark":
        return scene.landmark(name)
    if kind == "statement":
        return next((one for one in program.contract.statements if one.id == name), None)
    return program.action(name) if kind == "action" else None


def _names(snapshot: Snapshot) -> dict[str, list[str]]:
    scene = snapshot.program.scene
    objects, supports = [o.name for o in scene.objects], [s.name for s in scene.supports]
    return {
        "objects": objects,
        "supports": supports,
        "places": objects + supports + [one.name for one in scene.landmarks],
        "materials": list(MATERIALS),
        "actions": [action.id for action in snapshot.program.event.actions],
        "clauses": [clause.id for clause in snapshot.program.contract.clauses],
        "statements": [one.id for one in snapshot.program.contract.statements],
    }


def _form(item: BaseModel | None, path: str, snapshot: Snapshot, title: str) -> dict[str, Any]:
    if item is None:
        return {"title": title, "fields": [], "path": path}
    fields = Form(type(item), seeds_for(item, snapshot.program)).fields(path, plain(item))
    _add_help(fields, item, snapshot)
    words = HELP.get(getattr(item, "operator", "")) or (type(item).__doc__ or "")
    words = words.split("\n\n")[0].replace("`", "")
    return {
        "title": title,
        "path": path,
        "help": " ".join(words.split()).partition("; ")[0].rstrip(".") + ".",
        "fields": fields,
        "data": plain(item),
    }


def _add_help(fields: list[dict[str, Any]], item: BaseModel, snapshot: Snapshot) -> None:
    """What an empty field stands for: the material's own figure."""
    row = getattr(item, "material", None)
    for field in fields:
        key = field["path"].rpartition(".")[2]
        if row in MATERIALS and key in ("density", "friction", "restitution", "rolling"):
            field["empty"] = f"{number(getattr(MATERIALS[row], key))} (from {row})"
        field["pinned"] = field["path"] in snapshot.state.pinned


def _facts(snapshot: Snapshot, name: str, step: int) -> list[dict[str, str]]:
    """What is measured of an object at the step on view."""
    rollout = snapshot.rollout
    if rollout is None or name not in rollout.objects:
        place = poses_at(snapshot, 0).get(name)
        return [] if place is None else [{"what": "Position", "is": _vector(place[0]), "unit": "m"}]
    at, row = rollout.objects.index(name), min(step, rollout.steps)
    speed = float((rollout.velocities[row, at] ** 2).sum() ** 0.5)
    spin = float((rollout.angular[row, at] ** 2).sum() ** 0.5)
    return [
        {"what": "Mass", "is": number(float(rollout.masses[at])), "unit": "kg"},
        {"what": "Position", "is": _vector(rollout.positions[row, at]), "unit": "m"},
        {"what": "Speed", "is": number(speed), "unit": "m/s"},
        {"what": "Spin", "is": number(spin), "unit": "rad/s"},
    ]


def _vector(value: Any) -> str:
    return "  ".join(f"{float(part):.2f}".replace("-", "−") for part in value)
