"""How far things can go: to the rim of the picture, to an edge, to what stands in the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.agent.rules.contract.compile import contract_of
from physagent_studio.agent.rules.scene.framing import FRAMING, free_way, good_way
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import read
from physagent_studio.language.reference.names import inventory
from physagent_studio.program import SceneState
from physagent_studio.program.scene.state import (
    Box,
    Floor,
    Grounding,
    SceneObject,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.program.statements import Moves
from tests.agent.rules.scenes import CAMERA

RIGHT, LEFT = np.array([1.0, 0, 0]), np.array([-1.0, 0, 0])
AWAY = np.array([0.0, 1.0, 0])


def ball(name: str, x: float, y: float = 4.0, z: float = 0.1, on: str = "floor") -> SceneObject:
    return SceneObject(name=name, shape=Sphere(radius=0.1), position=(x, y, z), support=on)


def layout_of(*things: SceneObject, camera: bool = True) -> Layout:
    table = Support(name="table", shape=Slab(position=(0.0, 4.0, 0.3), size=(1.0, 1.0, 0.6)))
    supports = (Support(name="floor", shape=Floor()), table)
    return Layout(SceneState(camera=CAMERA if camera else None, objects=things, supports=supports))


def rim(y: float) -> float:
    """Where the right rim of the picture lies on a line across at that distance, near the floor."""
    pixels, _ = CAMERA.project(np.array([[0.0, y, 0.1], [1.0, y, 0.1]]))
    return float((CAMERA.size[0] - pixels[0, 0]) / (pixels[1, 0] - pixels[0, 0]))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_it_can_go_as_far_as_the_rim(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1, 1), rng.uniform(5, 7)
    layout = layout_of(ball("ball", x, y))
    for way, room in ((RIGHT, rim(y) - x), (LEFT, rim(y) + x)):
        # Of what stops within the rim as much is seen as there has to be.
        assert room - 0.25 < free_way(layout, "ball", way) <= room


def test_more_is_seen_at_the_end_than_has_to_be() -> None:
    layout = layout_of(ball("ball", 0.0, 6.0))
    free = free_way(layout, "ball", RIGHT)
    ahead = rim(6.0) - free
    # What a ball of radius 0.1 has beyond the rim, over its width.
    assert (0.1 - ahead) / 0.2 <= FRAMING.max_beyond_ratio + 0.02


def test_what_the_rim_cuts_off_already_may_stay_so() -> None:
    x = rim(6.0) + 0.02
    layout = layout_of(ball("ball", x, 6.0))
    assert free_way(layout, "ball", RIGHT) < 0.05
    assert free_way(layout, "ball", LEFT) > 1.0


def test_an_edge_ends_the_way() -> None:
    layout = layout_of(ball("ball", 0.1, 4.0, 0.7, on="table"))
    assert free_way(layout, "ball", RIGHT) == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize("distance", [0.5, 0.9])
def test_another_thing_ends_the_way(distance: float) -> None:
    layout = layout_of(ball("ball", 0.0, 6.0), ball("other", distance, 6.0))
    assert free_way(layout, "ball", RIGHT) == pytest.approx(distance - 0.2, abs=1e-6)
    assert free_way(layout, "ball", LEFT) > 1.0


def test_it_passes_what_stands_beside_its_way() -> None:
    beside = layout_of(ball("ball", 0.0, 6.0), ball("other", 0.5, 6.3))
    alone = layout_of(ball("ball", 0.0, 6.0))
    assert free_way(beside, "ball", RIGHT) == free_way(alone, "ball", RIGHT)


def test_without_a_camera_there_is_no_rim() -> None:
    layout = layout_of(ball("ball", 0.0, 6.0), camera=False)
    assert free_way(layout, "ball", RIGHT) == math.inf


@pytest.mark.parametrize("seed", [1, 2])
def test_a_good_way_is_a_part_of_the_free_one_and_no_journey(seed: int) -> None:
    x = float(np.random.default_rng(seed).uniform(0.5, 2.0))
    layout = layout_of(ball("ball", x, 6.0))
    free, size = free_way(layout, "ball", RIGHT), layout.size("ball")
    assert good_way(layout, "ball", RIGHT) == pytest.approx(
        min(FRAMING.good_share * free, FRAMING.max_lengths * size)
    )
    assert good_way(layout, "ball", AWAY) <= FRAMING.max_lengths * size


def test_a_good_way_is_seen_even_where_there_is_little_room() -> None:
    layout = layout_of(ball("ball", 0.0, 6.0), ball("other", 0.21, 6.0))
    assert good_way(layout, "ball", RIGHT) == pytest.approx(FRAMING.min_sizes * layout.size("ball"))


@pytest.mark.parametrize("room", [0.03, 0.05])
def test_where_little_is_free_nearly_all_of_it_is_taken(room: float) -> None:
    layout = layout_of(ball("ball", 0.0, 6.0), ball("other", 0.2 + room, 6.0))
    assert good_way(layout, "ball", RIGHT) == pytest.approx(FRAMING.tight_share * room)


@pytest.mark.parametrize("size", [0.6, 1.2])
def test_no_more_is_demanded_than_the_picture_leaves_room_for(size: float) -> None:
    wide = SceneObject(
        name="plank", shape=Box(size=(size, 0.1, 0.1)), position=(0.0, 3.0, 0.05), support="floor"
    )
    x = rim(3.0) - size / 2 - 0.05
    near = wide.model_copy(update={"position": (x, 3.0, 0.05)})
    said = "The plank slides to the right and stops."
    reading = read(said, inventory([("plank", Grounding())]))

    def demanded(item: SceneObject) -> float:
        made = contract_of(reading, layout_of(item))
        return next(s.distance for s in made.statements if isinstance(s, Moves) and not s.negated)

    assert demanded(near) <= good_way(layout_of(near), "plank", RIGHT)
    assert demanded(near) < demanded(wide) <= 0.2


@pytest.mark.parametrize(
    ("wide", "at", "way"),
    [(1.0, 0.3, (1.0, 0.0)), (1.0, 0.0, (0.0, -1.0)), (9.0, 0.3, (0.0, -1.0))],
)
def test_over_the_far_edge_or_where_the_picture_ends_nothing_falls(wide, at, way) -> None:
    """Near the rear of a ledge it goes to a side only where that ends nearby, in the picture."""
    shelf = Slab(position=(0.0, 4.0, 0.6), size=(wide, 0.4, 0.05))
    supports = (Support(name="floor", shape=Floor()), Support(name="shelf", shape=shelf))
    vase = ball("vase", at, 4.1, 0.725, "shelf")
    layout = Layout(SceneState(camera=CAMERA, objects=(vase,), supports=supports))
    edge = layout.nearest_edge("vase")
    assert edge is not None
    assert edge[0][:2] == pytest.approx(way)
