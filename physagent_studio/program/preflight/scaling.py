"""The same action, stronger or weaker, and the same shape, larger or thicker."""

import numpy as np
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.program import actions
from physagent_studio.program.edits import SetField
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.state import SceneObject


def scaled(action: actions.Action, factor: float) -> tuple[SetField, ...]:
    """Edits that multiply the velocity or force of an action; none for other operators."""
    path = f"event.actions.{action.id}"
    match action:
        case actions.ApplyAngledForce():
            return (SetField(path=f"{path}.magnitude", value=_rounded(action.magnitude * factor)),)
        case actions.SetVelocity():
            return _vector(f"{path}.velocity", action.velocity, factor)
        case actions.ApplyForce():
            return _vector(f"{path}.force", action.force, factor)
        case _:
            return ()


def _vector(
    path: str, vector: tuple[float, float, float] | actions.Directed, factor: float
) -> tuple[SetField, ...]:
    if isinstance(vector, actions.Directed):
        return (SetField(path=f"{path}.magnitude", value=_rounded(vector.magnitude * factor)),)
    value: list[JsonValue] = [_rounded(part * factor) for part in vector]
    return (SetField(path=path, value=value),)


def shape_scaled(shape: forms.Shape, factor: float) -> forms.Shape:
    """The shape with all its lengths multiplied."""
    kept = {"kind", "asset", "thickness", "flat", "straight", "turn"}
    lengths = shape.model_dump(mode="json", exclude=kept, exclude_none=True)
    larger = {name: _multiplied(value, factor) for name, value in lengths.items()}
    return type(shape).model_validate({**shape.model_dump(mode="json"), **larger})


def farther(item: SceneObject, eye: FloatArray, share: float) -> SceneObject:
    """The thing so many times as far from the eye (3,) and as much larger, the thread that it hangs
    by too, so that it is seen alike. Its shape and its position are known."""
    assert item.position is not None
    assert item.shape is not None
    place = np.asarray(item.position)
    x, y, z = (round(float(part), 5) for part in eye + share * (place - eye))
    tether = None if item.tether is None else round(share * item.tether, 5)
    shape = shape_scaled(item.shape, share)
    return item.model_copy(update={"position": (x, y, z), "shape": shape, "tether": tether})


def shape_thickened(shape: forms.Shape, thinnest: float, least: float) -> forms.Shape:
    """The shape with its thinnest extent at `least` and not at `thinnest`, m.

    What has no field of its own for that becomes larger as a whole.
    """
    match shape:
        case forms.Box(wall=None) | forms.Inflated() | forms.Meshed():
            x, y, z = (max(edge, least) for edge in shape.size)
            return shape.model_copy(update={"size": (x, y, z)})
        case forms.Ellipsoid():
            x, y, z = (max(radius, least / 2) for radius in shape.radii)
            return shape.model_copy(update={"radii": (x, y, z)})
        case forms.Cylinder():
            radius, height = max(shape.radius, least / 2), max(shape.height, least)
            return shape.model_copy(update={"radius": radius, "height": height})
        case forms.Torus():
            return shape.model_copy(update={"tube": max(shape.tube, least / 2)})
        case forms.Frustum() if shape.height < least:
            return shape.model_copy(update={"height": least})
        case _:
            return shape_scaled(shape, 1.001 * least / thinnest)


def _multiplied(value: JsonValue, factor: float) -> JsonValue:
    if isinstance(value, list):
        return [_multiplied(part, factor) for part in value]
    assert isinstance(value, float | int)
    return float(f"{value * factor:.6g}")


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
