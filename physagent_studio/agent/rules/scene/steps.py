"""Steps that were given as supports of their own: which of them go down from where."""

from __future__ import annotations

from physagent_studio.agent.rules.scene.measures import UP, Layout
from physagent_studio.knowledge import is_step
from physagent_studio.program.scene.state import Slab


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


def drop(layout: Layout, name: str, lower: str) -> float:
    """How much lower a step is than the one on which something stands, m."""
    carrier = layout.carrier(name)
    return _top(layout, carrier) - _top(layout, lower) if carrier is not None else 0.0


def _top(layout: Layout, slab: str) -> float:
    return float(layout.position(slab)[2]) + layout.extent(slab, UP)


def _is_next(layout: Layout, lower: str, upper: str) -> bool:
    rise = _top(layout, upper) - _top(layout, lower)
    return rise > 0.005 and layout.gap(lower, upper) < max(0.02, 0.3 * rise)
