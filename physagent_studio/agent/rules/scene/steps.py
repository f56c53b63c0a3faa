"""Steps, given as supports of their own or as one flight: which of them go down from where."""

import numpy as np

from physagent_studio.agent.rules.scene.measures import UP, FloatArray, Layout, level
from physagent_studio.knowledge import is_step
from physagent_studio.program.scene.stairs import Tread, treads_of
from physagent_studio.program.scene.state import Ramp, Slab


def steps_below(layout: Layout, name: str) -> tuple[str, ...]:
    """Steps below the one that a thing stands on, each beside the one above, from high to low."""
    slabs = [s.name for s in layout.state.supports if isinstance(s.shape, Slab)]
    steps = [one for one in slabs if is_step(one)]
    here, found = layout.carrier(name), list[str]()
    if here not in steps:
        return ()
    while here is not None:
        under = [one for one in steps if _is_next(layout, one, here)]
        here = max(under, key=lambda one: _top(layout, one), default=None)
        found += [here] if here is not None else []
    return tuple(found)


def descents(layout: Layout, name: str) -> tuple[float, ...]:
    """How much lower than the step that a thing stands on each further one is, and in the end the
    ground, m; none where it stands on no step."""
    carrier, ground = layout.carrier(name), layout.ground_height()
    if carrier is None:
        return ()
    if (flight := _flight(layout, name)) is not None:
        ramp, below, here = flight
        tops = [*(ramp.toe[2] + tread.top for tread in reversed(below)), ramp.toe[2]]
        return tuple(ramp.toe[2] + here.top - top for top in tops)
    top = _top(layout, carrier)
    steps = steps_below(layout, name)
    found = [top - _top(layout, step) for step in steps]
    return (*found, top - ground) if steps or is_step(carrier) else ()


def way_down(layout: Layout, name: str, steps: int = 1) -> FloatArray | None:
    """The level way (3,) from the middle of the step that a thing stands on to that of the next
    lower one, or of one so many steps on, m; None where no step goes down from there."""
    if (flight := _flight(layout, name)) is not None:
        ramp, below, here = flight
        ahead = np.array([np.cos(ramp.yaw), np.sin(ramp.yaw), 0.0])
        deep = here.end - here.start if len(below) < steps else _middle(here) - _middle(
            below[-steps]
        )  # fmt: skip
        return -ahead * deep
    below, here = steps_below(layout, name), layout.carrier(name)
    if not below or here is None:
        return None
    last = below[min(steps, len(below)) - 1]
    return level(layout.position(last) - layout.position(here))


def _middle(tread: Tread) -> float:
    return (tread.start + tread.end) / 2


def _flight(layout: Layout, name: str) -> tuple[Ramp, tuple[Tread, ...], Tread] | None:
    """The flight of stairs that a thing stands on, its steps below that, and the one itself."""
    support = layout.state.support(layout.carrier(name) or "")
    ramp = support.shape if support is not None else None
    if not isinstance(ramp, Ramp) or not (treads := treads_of(ramp)):
        return None
    foot = float(layout.position(name)[2]) - layout.extent(name, -UP) - ramp.toe[2]
    here = min(range(len(treads)), key=lambda k: abs(treads[k].top - foot))
    return ramp, treads[:here], treads[here]


def _top(layout: Layout, slab: str) -> float:
    return float(layout.position(slab)[2]) + layout.extent(slab, UP)


def _is_next(layout: Layout, lower: str, upper: str) -> bool:
    rise = _top(layout, upper) - _top(layout, lower)
    return rise > 0.005 and layout.gap(lower, upper) < max(0.02, 0.3 * rise)
