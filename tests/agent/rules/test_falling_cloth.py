"""A cloth that comes off a line falls as a cloth, and not as a board."""

from __future__ import annotations

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.program.scene.bodies import Cloth
from physagent_studio.program.scene.state import Box
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

LINE = Stage("line", {"towel": (Box(size=(0.5, 0.02, 0.6)), (0.0, 3.0, 1.4), "air")})


def test_a_towel_that_comes_loose_folds_up_on_the_ground():
    program = RuleGenerator().first(
        LINE.case("The towel comes loose and falls to the floor."), LINE.reconstruct
    )
    towel = program.scene.object("towel")
    assert towel is not None
    assert isinstance(towel.body, Cloth)
    assert towel.body.pinned == "none"
    rollout = simulate(program)
    assert all(check.ok for check in measure(program, rollout) if check.clause is not None)
    heights = dict(rollout.vertices)["towel"][..., 2]
    assert heights[0].max() - heights[0].min() > 0.5
    assert heights[-1].max() - heights[-1].min() < 0.3
