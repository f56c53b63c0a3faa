"""What rests on a slope is tilted with it: it is seen in a frame in which the slope is level."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.program.rotations import about_axis, matrix_of, multiply, quaternion_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SupportShape
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.shapes.primitives import Base


@dataclass(frozen=True, slots=True)
class Tilt:
    """A frame turned by `turn` (R_world_frame, wxyz) about the world point `pivot`, m."""

    turn: tuple[float, float, float, float]
    pivot: tuple[float, float, float]

    def camera(self, camera: Camera) -> Camera:
        """The camera as it stands in the frame."""
        back = matrix_of(self.turn).T
        away = np.asarray(camera.position) - self.pivot
        x, y, z = (float(v) for v in back @ away + self.pivot)
        turned = quaternion_of(back @ camera.matrix)
        return camera.model_copy(update={"position": (x, y, z), "rotation": turned})

    def in_world(self, form: Form) -> Form:
        """A form that was found in the frame, in the world."""
        away = np.asarray(form.position) - self.pivot
        x, y, z = (float(v) for v in matrix_of(self.turn) @ away + self.pivot)
        return replace(form, position=(x, y, z), rotation=multiply(self.turn, form.rotation))


def tilt_of(base: Base, shape: SupportShape | None, shapes: Sequence[str]) -> Tilt | None:
    """The frame of the slope under a base; None on level ground, and for balls.

    shape: of what it stands on. shapes: kinds that the thing's name suggests.
    """
    if not isinstance(shape, Ramp) or base.free_z or tuple(shapes) == ("sphere",):
        return None
    if shape.steps:
        return None
    cos, sin = math.cos(shape.yaw), math.sin(shape.yaw)
    along = (base.x - shape.toe[0]) * cos + (base.y - shape.toe[1]) * sin
    # 0..0.2: of a slope at either end, where a thing lies on the edge, not on the slope
    end_share = 0.03
    if not end_share * shape.run < along < (1 - end_share) * shape.run:
        return None
    slope = math.atan2(shape.rise, shape.run)
    return Tilt(about_axis((sin, -cos, 0.0), slope), (base.x, base.y, base.z))
