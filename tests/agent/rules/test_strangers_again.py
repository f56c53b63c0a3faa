"""What strangers' sentences showed: balloons keep their height, shoes tip over their long side."""

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.generator import stock_of
from physagent_studio.agent.rules.scene.hanging import kept_afloat
from physagent_studio.contract.measure import measure
from physagent_studio.language import read
from physagent_studio.program.scene.state import Box, Cylinder, SceneState, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

ROOM = Stage(
    "room",
    {
        "sneaker": (Box(size=(0.3, 0.1, 0.12)), (0.0, 2.0, 0.06), "floor"),
        "plate": (Cylinder(radius=0.14, height=0.02), (-0.5, 2.0, 0.01), "floor"),
        "candle": (Box(size=(0.07, 0.07, 0.07)), (-0.15, 2.2, 0.035), "floor"),
    },
)


def test_what_is_long_tips_over_its_long_side() -> None:
    prompt = "The sneaker tips over onto its side."
    program = RuleGenerator().first(ROOM.case(prompt), ROOM.reconstruct)
    rollout = simulate(program, {})
    demanded = [check for check in measure(program, rollout) if check.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded
    # Over its long side its length stays level.
    w, x, y, z = rollout.rotations[-1, rollout.index("sneaker")]
    length_up = 2 * (x * z - w * y)
    assert abs(length_up) < 0.3


def test_what_hops_and_lands_on_a_thing_is_up_there_in_the_end() -> None:
    prompt = "The candle hops to the left and lands on the plate."
    program = RuleGenerator().first(ROOM.case(prompt), ROOM.reconstruct)
    kinds = [s.kind for s in program.contract.statements if getattr(s, "other", "") == "plate"]
    assert kinds == ["reaches"]


def _sky(body: str) -> tuple[SceneState, Stage]:
    stage = Stage("sky", {body: (Sphere(radius=0.15), (0.0, 3.0, 1.5), "air")})
    state = RuleGenerator().first(stage.case(f"The {body} spins."), stage.reconstruct).scene
    items = [item.model_copy(update={"aloft": "hangs"}) for item in state.objects]
    return state.model_copy(update={"objects": tuple(items)}), stage


@pytest.mark.parametrize(
    ("body", "prompt", "carriage"),
    [
        ("balloon", "The wind tugs the balloon to the right.", "floats"),
        ("balloon", "The balloon drifts slowly to the left.", "floats"),
        ("balloon", "The balloon sinks to the floor.", "hangs"),
        ("balloon", "The balloon drifts to the left and falls.", "hangs"),
        ("ball", "The wind blows the ball to the right.", "hangs"),
    ],
)
def test_a_balloon_that_is_only_blown_along_keeps_its_height(
    body: str, prompt: str, carriage: str
) -> None:
    state, stage = _sky(body)
    kept = kept_afloat(state, read(prompt, stock_of(stage.case(prompt))))
    assert [item.aloft for item in kept.objects] == [carriage]
