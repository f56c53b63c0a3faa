"""Clips: the frames of a rollout, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.scene import Scene
from physagent_studio.rendering.compositor import Compositor
from physagent_studio.rendering.frame import Frame
from physagent_studio.rendering.shutter import exposed


def render_clip(
    scene: Scene,
    rollout: Rollout,
    frames: Iterable[int] | None = None,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    compositor: Compositor | None = None,
    shutter: float = 0.0,
) -> Iterator[Frame]:
    """Render the frames of a rollout (all, or those numbered from 0 in `frames`), in order.

    cancelled: asked before each frame. progress: told the share done, 0 … 1. compositor: of
    this scene, where there is one already. shutter: for which share of the time to the next frame
    it is open, 0 … 1; what moves meanwhile is blurred.

    Raises:
        InputError: the rollout is of other objects, or a frame does not exist.
        Cancelled: `cancelled` said so.
    """
    compositor = Compositor(scene) if compositor is None else compositor
    if rollout.objects != compositor.names:
        raise InputError(
            f"the rollout is of {', '.join(rollout.objects) or 'nothing'}, "
            f"the scene has {', '.join(compositor.names) or 'nothing'}"
        )
    wanted = list(range(rollout.frames) if frames is None else frames)
    for number in wanted:
        if not 0 <= number < rollout.frames:
            raise InputError(f"there is no frame {number}; the clip has 0 … {rollout.frames - 1}")
    return _frames(compositor, rollout, wanted, cancelled, progress, shutter)


def frame_of(compositor: Compositor, rollout: Rollout, number: int) -> Frame:
    """Frame `number` of a rollout; where the rollout ended early, its last state."""
    step = _last_finite(rollout, int(rollout.frame_steps()[number]))
    vertices = {
        name: deformed[min(number, len(deformed) - 1)] for name, deformed in rollout.vertices
    }
    return compositor.frame(rollout.positions[step], rollout.rotations[step], vertices)


def _last_finite(rollout: Rollout, step: int) -> int:
    """The last step up to `step` whose poses are finite: a blown-up run stands still there."""
    while step > 0 and not (
        np.isfinite(rollout.positions[step]).all() and np.isfinite(rollout.rotations[step]).all()
    ):
        step -= 1
    return step


def _frames(
    compositor: Compositor,
    rollout: Rollout,
    wanted: list[int],
    cancelled: Callable[[], bool] | None,
    progress: Callable[[float], None] | None,
    shutter: float,
) -> Iterator[Frame]:
    for done, number in enumerate(wanted):
        if cancelled is not None and cancelled():
            raise Cancelled("rendering was cancelled")
        frame = frame_of(compositor, rollout, number)
        moves = shutter > 0 and np.isfinite(rollout.positions).all()
        yield exposed(compositor, rollout, frame, number, shutter) if moves else frame
        if progress is not None:
            progress((done + 1) / len(wanted))
