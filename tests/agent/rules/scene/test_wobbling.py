"""What is told to wobble is soft, and loses so little that it does."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.state import Box, Frustum, Sphere
from tests.agent.rules.scenes import Stage

STAGE = Stage(
    "party",
    {
        "jelly": (
            Frustum(bottom_radius=0.06, top_radius=0.05, height=0.12),
            (0, 2.5, 0.06),
            "floor",
        ),
        "pillow": (Box(size=(0.5, 0.3, 0.15)), (0.8, 2.5, 0.075), "floor"),
        "plum": (Sphere(radius=0.025), (-0.4, 2.5, 0.025), "floor"),
    },
)


@pytest.mark.parametrize(
    ("prompt", "name", "lossy"),
    [
        ("The plum rolls into the jelly, and the jelly wobbles.", "jelly", False),
        ("The jelly is squashed and wobbles.", "jelly", False),
        ("The pillow sways from side to side.", "pillow", False),
        ("The jelly is squashed.", "jelly", True),
    ],
)
def test_what_wobbles_loses_little(prompt: str, name: str, lossy: bool) -> None:
    program = RuleGenerator().first(STAGE.case(prompt), STAGE.reconstruct)
    item = program.scene.object(name)
    assert item is not None
    body = item.body
    assert isinstance(body, Soft)
    assert (body.damping >= 0.02) == lossy
