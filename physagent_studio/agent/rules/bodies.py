"""How things hold together, where the event asks for more than a rigid body."""

from __future__ import annotations

from physagent_studio.agent.rules.layout import Layout
from physagent_studio.agent.rules.look import is_loose, is_rooted, is_sheet
from physagent_studio.agent.rules.reading import Reading
from physagent_studio.program.bodies import Body, Breakable, Cloth, Granular, Soft


def bodies_for(reading: Reading, layout: Layout) -> dict[str, Body]:
    """Bodies by object name, only for objects that have to bend, break, flow or sway."""
    found: dict[str, Body] = {}
    for frame in reading.frames:
        if frame.negated:
            continue
        names = frame.patient
        if frame.sense == "wind" and not names:
            names = tuple(item.name for item in layout.state.objects)
        for name in names:
            body = _body(frame.sense, name, layout)
            if body is not None:
                found.setdefault(name, body)
    return found


def _body(sense: str, name: str, layout: Layout) -> Body | None:
    if sense in ("collapse", "spread") and is_loose(name):
        return Granular(cohesion=0.5)
    if sense in ("collapse", "break", "crush"):
        # Cut finer where it is longer; lets go at the blow of its own weight falling a little.
        impulse = max(0.3 * layout.mass(name), 1e-3)
        return Breakable(cuts=(2, 1, 3), release_impulse=round(impulse, 4))
    if sense in ("wind", "sway", "bend") and is_sheet(name):
        return Cloth(pinned="top")
    if sense in ("wind", "sway", "bend") and is_rooted(name):
        return Soft(pinned="bottom", young=3e5)
    if sense == "deform":
        return Soft(young=1e5)
    return None
