"""Stairs: the treads of a ramp that has steps."""

from dataclasses import dataclass

from physagent_studio.program.scene.forms import Ramp


@dataclass(frozen=True, slots=True)
class Tread:
    """A step: from `start` to `end` uphill of the toe, its upper side at `top` over it, m."""

    start: float
    end: float
    top: float


def treads_of(ramp: Ramp) -> tuple[Tread, ...]:
    """The steps of stairs, from the lowest; none of a slope.

    One step alone is a block as long as the whole.
    """
    if ramp.steps < 1:
        return ()
    if ramp.steps == 1:
        return (Tread(0.0, ramp.run + ramp.plateau, ramp.rise),)
    deep, high = ramp.run / (ramp.steps - 1), ramp.rise / ramp.steps
    last = max(ramp.plateau, deep)
    return tuple(
        Tread(k * deep, ramp.run + last if k == ramp.steps - 1 else (k + 1) * deep, (k + 1) * high)
        for k in range(ramp.steps)
    )


def profile_of(ramp: Ramp) -> tuple[tuple[float, float], ...]:
    """Corners (along, height) of the side of a ramp, m; of stairs those of their hull.

    From the toe over the surface to the back and down.
    """
    treads = treads_of(ramp)
    if not treads:
        end = ramp.run + ramp.plateau
        return ((0.0, 0.0), (ramp.run, ramp.rise), (end, ramp.rise), (end, 0.0))
    first, last = treads[0], treads[-1]
    edges = ((0.0, 0.0), (0.0, first.top), (last.start, last.top), (last.end, last.top))
    return tuple(dict.fromkeys((*edges, (last.end, 0.0))))
