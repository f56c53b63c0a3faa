"""Supports that the prompt takes away: they are gone from the scene when the clip begins.

A support cannot move in the physics; what stood on it is held for a moment and then let go.
"""

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import Reading
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.state import SceneState


def without_withdrawn(state: SceneState, reading: Reading) -> SceneState:
    """The state without what is pulled away, said as a flag; the ground always stays."""
    ground = Layout(state).ground()
    named = {
        place.name
        for frame in reading.frames
        if frame.sense == "withdrawn"
        for _, place in frame.places
    }
    gone = {s.name for s in state.supports if s.name in named and s.name != ground}
    if not gone:
        return state
    layout = Layout(state)
    objects = tuple(
        item.model_copy(update={"support": AIR})
        if {item.support, layout.carrier(item.name)} & gone
        else item
        for item in state.objects
    )
    marks = tuple(
        mark.model_copy(update={"on": None}) if mark.on in gone else mark
        for mark in state.landmarks
    )
    said = tuple(
        f"'{name}' is taken away: it carries nothing in this clip" for name in sorted(gone)
    )
    return state.model_copy(
        update={
            "objects": objects,
            "supports": tuple(s for s in state.supports if s.name not in gone),
            "landmarks": marks,
            "flags": tuple(dict.fromkeys((*state.flags, *said)))[:64],
        }
    )
