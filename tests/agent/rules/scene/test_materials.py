"""What things are made of by their names."""

import pytest

from physagent_studio.agent.rules.scene.materials import ground_material, material_of, unknown


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


def test_what_nothing_says_is_assumed_and_said() -> None:
    assert unknown("gizmo", "The gizmo rolls.") == (
        "what gizmo is made of is not known; taken as plastic"
    )
    assert unknown("gizmo", "The wooden gizmo rolls.") is None
    assert unknown("red_ball", "") is None


@pytest.mark.parametrize(
    ("prompt", "material"),
    [
        ("A curling stone slides toward the house.", "ice"),
        ("It drives across the road.", "concrete"),
        ("A ball rolls over the concrete floor.", "concrete"),
        ("The sand house collapses.", "wood"),
    ],
)  # fmt: skip
def test_the_ground_is_of_what_the_sentence_says(prompt: str, material: str) -> None:
    assert ground_material(prompt, "floor") == material
