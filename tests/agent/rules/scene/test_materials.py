"""What things are made of by their names."""

import pytest

from physagent_studio.agent.rules.scene.materials import material_of


@pytest.mark.parametrize(
    ("name", "material"),
    [
        ("orange", "fruit"), ("left_orange", "fruit"), ("orange_2", "fruit"),
        ("orange_slice", "fruit"), ("orange_ring", "plastic"), ("orange_tyre", "rubber"),
        ("lime_mug", "ceramic"), ("cherry_tree", "wood"), ("plum", "fruit"),
        ("orange_wooden_block", "wood"), ("peach_box_2", "cardboard"),
    ],
)  # fmt: skip
def test_a_fruit_before_another_noun_is_a_colour(name: str, material: str) -> None:
    assert material_of(name, "") == material
