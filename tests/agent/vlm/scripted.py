"""What a model that knows its trade says about the ball world."""

from __future__ import annotations

import re
from typing import Any

from tests.agent.vlm.server import Asked, Reply, says


def scene() -> dict[str, Any]:
    ball = {"name": "ball", "points": [{"x": 20, "y": 30, "label": 1}], "material": "rubber"}
    return {"objects": [ball | {"support": "floor"}], "supports": [{"name": "floor"}]}


def event(speed: float = 1.0, distance: float = 1.8) -> dict[str, Any]:
    return {
        "clauses": [{"id": "c1", "text": "The red ball rolls two metres to the right."}],
        "statements": [
            {
                "id": "s1",
                "kind": "moves",
                "clause": "c1",
                "subject": "ball",
                "distance": distance,
                "direction": "right",
            }
        ],
        "actions": [
            {
                "id": "push",
                "operator": "SetVelocity",
                "name": "ball",
                "velocity": {"magnitude": speed, "direction": "right"},
            }
        ],
    }


def fine(reason: str = "as it should be") -> dict[str, Any]:
    return {"ok": True, "reason": reason}


def stage_one(passed: bool = True) -> dict[str, Any]:
    names = ("points", "shapes", "placement", "supports", "camera")
    reply: dict[str, Any] = {"passed": passed, **{name: fine() for name in names}}
    if not passed:
        reply["placement"] = {"ok": False, "reason": "the ball floats"}
        reply["mismatches"] = [
            {"code": "wrong_place", "subject": "ball", "text": "the ball floats above the floor"}
        ]
    return reply


def stage_two(passed: bool) -> dict[str, Any]:
    names = ("object_trajectory", "contact_timing", "force_direction", "material_response")
    reply: dict[str, Any] = {
        "passed": passed,
        "clauses": [{"clause": "c1", "ok": passed, "reason": "see frame x79"}],
        **{name: fine() for name in names},
        "mismatches": [],
    }
    if not passed:
        reply["object_trajectory"] = {"ok": False, "reason": "it stops early"}
        reply["mismatches"] = [
            {"code": "falls_short", "subject": "ball", "text": "it stops early", "frame": 40}
        ]
    return reply


def faster(speed: float, confidence: float = 0.8) -> dict[str, Any]:
    edit = {"op": "set", "path": "event.actions.push.velocity.magnitude", "value": speed}
    return {
        "factor": "magnitude",
        "rationale": "it falls short, so it needs more speed",
        "confidence": confidence,
        "hunks": [{"summary": "faster", "edits": [edit]}],
        "question": "",
    }


def lower(shift: float) -> dict[str, Any]:
    edit = {"op": "set", "path": "scene.objects.ball.position", "value": [shift, 3.0, 0.1]}
    return {
        "factor": "placement",
        "rationale": "it floats",
        "confidence": 0.6,
        "hunks": [{"summary": "down to the floor", "edits": [edit]}],
    }


def holds(asked: Asked) -> bool:
    """Whether the measured contract that the verifier was shown holds."""
    return "[FAILS" not in asked.text("user")


def speed_shown(asked: Asked) -> float:
    found = re.search(r"push\.velocity\.magnitude = ([\d.]+)", asked.text("user"))
    assert found is not None
    return float(found[1])


def competent(asked: Asked) -> Reply:
    """Reads what it is shown and answers truthfully; its first speed is too low."""
    answers = {
        "SceneReply": scene,
        "EventReply": event,
        "StageOneReply": stage_one,
        "StageTwoReply": lambda: stage_two(holds(asked)),
        "ScenePlan": lambda: lower(round(asked.number / 1000, 3)),
        "EventPlan": lambda: faster(round(speed_shown(asked) + 0.5, 2)),
    }
    return says(answers[asked.form]())
