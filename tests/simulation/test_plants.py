"""What grows: how fast it sways, and how far the winds that have names bend it."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program.actions import ApplyDisturbance
from physagent_studio.program.scene.plants import FOLIAGE, plant_body, sway_frequency
from physagent_studio.program.scene.state import Box, Cylinder, Ellipsoid
from physagent_studio.simulation import Simulator

TREE = (Ellipsoid(radii=(2.6, 2.6, 2.65)), 5.3, 5.2)
POPLAR = (Ellipsoid(radii=(2.0, 2.0, 10.0)), 20.0, 4.0)
FLOWER = (Cylinder(radius=0.03, height=0.4), 0.4, 0.06)
GRASS = (Box(size=(0.3, 0.3, 0.3)), 0.3, 0.3)


def swaying(plant, amplitude, *, knock=False, seconds=1.2):
    shape, height, width = plant
    body = plant_body(shape.kind, height, width)
    item = thing("plant", shape, (0, 0, height / 2)).model_copy(
        update={"body": body, "material": FOLIAGE, "density": None}
    )
    push = ApplyDisturbance(
        id="air",
        name="plant",
        model="bump" if knock else "wind",
        amplitude=amplitude,
        direction="right",
        duration=4 if knock else round(100 * seconds),
    )
    acts = [push] if amplitude else []
    return Simulator().simulate(program([item], [ground()], acts, seconds=seconds))


def bent(rollout):
    """Degrees by which the top leans over, per frame."""
    points = dict(rollout.vertices)["plant"]
    top = int(np.argmax(points[0, :, 2]))
    away = points[:, top] - points[0, top]
    return np.degrees(np.arctan2(away[:, 0], points[0, top, 2] + away[:, 2]))


@pytest.mark.parametrize("plant", [TREE, POPLAR, FLOWER, GRASS])
def test_a_plant_sways_as_often_as_its_height_tells(plant):
    height, expected = plant[1], sway_frequency(plant[1])
    # A knock that moves it by a few degrees; it swings freely from there on.
    force = 3.0 * plant[1] * plant[2] ** 2
    rollout = swaying(plant, force, knock=True, seconds=max(1.8 / expected, 1.2))
    x = rollout.positions[4:, 0, 0] - rollout.positions[0, 0, 0]
    turns = np.flatnonzero((x[:-1] > 0) != (x[1:] > 0))
    half = np.diff(turns)[0] * rollout.step_seconds
    assert 1 / (2 * half) == pytest.approx(expected, rel=0.15), height


def test_the_winds_that_have_names_bend_a_tree_as_one_expects():
    breeze, strong, storm, typhoon = (
        float(bent(swaying(TREE, speed)).max()) for speed in (5, 15, 25, 40)
    )
    assert 0.5 < breeze < 3
    assert 4 < strong < 12
    assert 10 < storm < 25
    assert 20 < typhoon < 45


def test_nothing_moves_a_plant_where_no_wind_blows():
    rollout = swaying(TREE, 0.0)
    points = dict(rollout.vertices)["plant"]
    assert np.abs(points - points[0]).max() < 1e-3


@pytest.mark.parametrize("plant", [TREE, FLOWER, GRASS])
def test_a_typhoon_lays_a_plant_over_and_does_not_tear_it_apart(plant):
    rollout = swaying(plant, 60.0)
    assert rollout.blown_up is None
    points = dict(rollout.vertices)["plant"]
    assert np.abs(points).max() < 3 * plant[1]
    assert 20 < bent(rollout).max() < 110


def test_leaves_that_lie_down_catch_less_of_a_fast_wind():
    steady = [float(bent(swaying(POPLAR, speed, seconds=0.6))[-1]) for speed in (10, 40)]
    # Rigid crowns would be bent 16 times as far.
    assert math.log(steady[1] / steady[0], 4) == pytest.approx(1.4, abs=0.25)
