"""What stands as it was photographed stands; what was placed badly is told."""

from dataclasses import replace

import pytest

from physagent_studio.benchmark.reconstruction.bench import _with_truth
from physagent_studio.benchmark.reconstruction.cover import movers, standing
from physagent_studio.benchmark.reconstruction.synthetic import scene


@pytest.mark.usefixtures("unfilled_here")
def test_a_reconstructed_scene_stays_as_it_is_and_a_raised_thing_falls():
    made = _with_truth(scene(3))
    assert movers(made) == ()
    assert standing(made) == len(made.state.objects)
    first = made.state.objects[0]
    assert first.position is not None
    x, y, z = first.position
    raised = first.model_copy(update={"position": (x, y, z + 0.3)})
    state = made.state.model_copy(update={"objects": (raised, *made.state.objects[1:])})
    assert movers(replace(made, state=state)) == (first.name,)
    hung = raised.model_copy(update={"support": "air"})
    state = made.state.model_copy(update={"objects": (hung, *made.state.objects[1:])})
    assert movers(replace(made, state=state)) == ()
    # What falls on others moves them, which is not by themselves; of nothing, nothing moves.
    below = made.state.objects[1].position
    assert below is not None
    over = hung.model_copy(update={"position": (below[0], below[1], 1.0)})
    state = made.state.model_copy(update={"objects": (over, *made.state.objects[1:])})
    assert movers(replace(made, state=state)) == ()
    state = made.state.model_copy(update={"objects": (hung,)})
    assert movers(replace(made, state=state)) == ()
    # What stands on something that falls goes with it.
    rider = made.state.objects[1].model_copy(update={"support": hung.name})
    state = made.state.model_copy(update={"objects": (hung, rider)})
    assert movers(replace(made, state=state)) == ()
