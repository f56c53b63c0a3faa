"""The same action, stronger or weaker: edits that multiply what it gives."""

from __future__ import annotations

from pydantic import JsonValue

from physagent_studio.program.actions import (
    Action,
    ApplyAngledForce,
    ApplyForce,
    Directed,
    SetVelocity,
)
from physagent_studio.program.edits import SetField


def scaled(action: Action, factor: float) -> tuple[SetField, ...]:
    """Edits that multiply the velocity or force of an action; none for other operators."""
    path = f"event.actions.{action.id}"
    match action:
        case ApplyAngledForce():
            return (SetField(path=f"{path}.magnitude", value=_rounded(action.magnitude * factor)),)
        case SetVelocity():
            return _vector(f"{path}.velocity", action.velocity, factor)
        case ApplyForce():
            return _vector(f"{path}.force", action.force, factor)
        case _:
            return ()


def _vector(
    path: str, vector: tuple[float, float, float] | Directed, factor: float
) -> tuple[SetField, ...]:
    if isinstance(vector, Directed):
        return (SetField(path=f"{path}.magnitude", value=_rounded(vector.magnitude * factor)),)
    value: list[JsonValue] = [_rounded(part * factor) for part in vector]
    return (SetField(path=path, value=value),)


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
