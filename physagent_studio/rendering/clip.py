"""Clips: the frames of a rollout, one after the other, blurred over an open shutter if asked."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import Cancelled, InputError
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.scene import Scene
from physagent_studio.rendering.compositor import Compositor
from physagent_studio.rendering.frame import Frame


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


MOMENTS = 8
"""Moments that a frame is the mean of."""
GAMMA = 2.2
"""Exponent from what is stored to light; light is what adds up."""


def exposed(
    compositor: Compositor, rollout: Rollout, at_rest: Frame, number: int, shutter: float
) -> Frame:
    """Frame `number` with the shutter open from it on, a share of the time to the next frame.

    at_rest: the same frame without blur, whose ids and depth are kept.
    """
    times = number + shutter * (np.arange(MOMENTS) + 0.5) / MOMENTS
    states = [_state(rollout, float(time)) for time in (number, *times)]
    if all(_alike(states[0], one) for one in states[1:]):
        return at_rest
    light = np.zeros(at_rest.rgb.shape, np.float64)
    for positions, rotations, vertices in states[1:]:
        rgb = compositor.frame(positions, rotations, vertices).rgb
        light += (rgb / 255.0) ** GAMMA
    mean = 255.0 * (light / MOMENTS) ** (1 / GAMMA)
    return replace(at_rest, rgb=np.clip(np.rint(mean), 0, 255).astype(np.uint8))


def _state(rollout: Rollout, time: float) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Positions (N, 3), rotations (N, 4) and deformed vertices (V, 3) between two steps.

    time: in frames. Rotations go straight from one to the next, which are near.
    """
    before, after, share = _between(time * rollout.steps_per_frame, len(rollout.positions))
    positions = _mixed(rollout.positions, before, after, share)
    first, second = rollout.rotations[before], rollout.rotations[after]
    second = np.where((first * second).sum(1, keepdims=True) < 0, -second, second)
    rotations = (1 - share) * first + share * second
    rotations /= np.maximum(np.linalg.norm(rotations, axis=1, keepdims=True), 1e-12)
    bent = {name: _mixed(rows, *_between(time, len(rows))) for name, rows in rollout.vertices}
    return positions, rotations, bent


def _between(at: float, count: int) -> tuple[int, int, float]:
    """The entries before and after a place in a row of so many, and how far it is between them."""
    before = min(int(at), count - 1)
    return before, min(before + 1, count - 1), at - int(at)


def _mixed(rows: FloatArray, before: int, after: int, share: float) -> FloatArray:
    return (1 - share) * rows[before] + share * rows[after]


def _alike(
    one: tuple[FloatArray, FloatArray, dict[str, FloatArray]],
    other: tuple[FloatArray, FloatArray, dict[str, FloatArray]],
) -> bool:
    poses = all(np.array_equal(a, b) for a, b in zip(one[:2], other[:2], strict=True))
    return poses and all(np.array_equal(rows, other[2][name]) for name, rows in one[2].items())
