"""Statements about what deforms, spreads, breaks and sways."""

import numpy as np
import pytest

from physagent_studio.program.scene.bodies import Breakable
from physagent_studio.records import Release

FRAMES = 26
RNG = np.random.default_rng(5)
CLOUD = RNG.uniform(-0.1, 0.1, (60, 3))


@pytest.mark.parametrize("kind", ["deforms", "spreads", "breaks"])
def test_what_is_rigid_does_none_of_this_and_says_why(stage, kind):
    check = stage.check(kind, subject="cube")
    assert not check.ok
    assert "was simulated" in check.text
    assert stage.check(kind, subject="cube", negated=True).ok


def test_moving_and_turning_is_no_deformation(stage):
    angles = np.linspace(0, 2, FRAMES)
    turns = np.array(
        [[[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in angles]
    )
    shift = np.linspace(0, 1, FRAMES)[:, None, None] * [1, 2, 3]
    stage.vertices["cube"] = np.einsum("fij,vj->fvi", turns, CLOUD) + shift
    assert stage.check("deforms", subject="cube").measured == pytest.approx(0, abs=1e-9)


def test_a_squash_deforms_and_grows_with_it(new_stage):
    margins = []
    for squash in (0.02, 0.04, 0.3):
        stage = new_stage()
        scale = np.linspace(1, 1 - squash, FRAMES)[:, None, None]
        stage.vertices["cube"] = CLOUD * np.concatenate([np.ones((FRAMES, 1, 2)), scale], axis=2)
        margins.append(stage.check("deforms", subject="cube", strain=0.1).margin)
    assert margins == sorted(margins)
    assert margins[1] < 0 < margins[2]


def test_sinking_under_its_own_weight_is_not_what_a_blow_does(new_stage):
    for squash, told in ((0.0, False), (0.3, True)):
        stage = new_stage()
        high = np.full(FRAMES, 0.8)
        high[0] = 1.0
        high[FRAMES // 2 + 1 :] -= squash
        flat = np.stack([np.ones(FRAMES), np.ones(FRAMES), high], axis=1)[:, None]
        stage.vertices["cube"] = CLOUD * flat
        assert stage.check("deforms", subject="cube", strain=0.1).ok
        step = stage.rollout().frame_steps()[FRAMES // 2]
        stage.touch("ball", "cube", [int(step)], impulse=1.0)
        assert stage.check("deforms", subject="cube", strain=0.1).ok is told


def test_spreading_is_a_growing_footprint(stage):
    growth = np.linspace(1, 2, FRAMES)[:, None, None]
    stage.vertices["cube"] = CLOUD * np.concatenate(
        [growth, growth, np.ones((FRAMES, 1, 1))], axis=2
    )
    check = stage.check("spreads", subject="cube", factor=3)
    assert check.ok
    assert check.measured == pytest.approx(4, rel=0.02)
    assert not stage.check("spreads", subject="cube", factor=5).ok


def test_breaks_counts_joints_that_let_go(stage):
    body = Breakable(release_impulse=2.0)
    stage.objects["cube"] = stage.objects["cube"].model_copy(update={"body": body})
    stage.touch("ball", "cube", [20], impulse=1.0)
    near = stage.check("breaks", subject="cube")
    assert not near.ok
    assert near.margin == pytest.approx(-0.5)
    stage.releases = [Release(21, "cube", "j0", 2.4), Release(22, "cube", "j1", 2.1)]
    broken = stage.check("breaks", subject="cube")
    assert broken.ok
    assert broken.measured == 2
    assert broken.step == 21
    assert not stage.check("breaks", subject="cube", from_step=30).ok


def test_sways_wants_amplitude_and_cycles(stage, time):
    stage.turn("can", (0, 1, 0), 5 * np.sin(2 * np.pi * 3 * time))
    check = stage.check("sways", subject="can", amplitude=3, cycles=2)
    assert check.ok
    assert check.measured == pytest.approx(3, abs=0.5)
    assert not stage.check("sways", subject="can", amplitude=3, cycles=5).ok
    weak = stage.check("sways", subject="can", amplitude=8)
    assert not weak.ok
    assert "±5°" in weak.text


def test_tipping_over_once_is_no_sway(stage, time):
    stage.turn("can", (0, 1, 0), 90 * time)
    assert not stage.check("sways", subject="can", cycles=1).ok


def test_a_cloth_sways_by_its_vertices(stage):
    phase = np.sin(np.linspace(0, 6 * np.pi, FRAMES))
    bend = phase[:, None] * (0.1 - CLOUD[:, 2]) * 0.4  # fixed at the top
    stage.vertices["cube"] = CLOUD + np.stack(
        [bend, np.zeros_like(bend), np.zeros_like(bend)], axis=-1
    )
    assert stage.check("sways", subject="cube", amplitude=3, cycles=2).ok
    assert not stage.check("sways", subject="cube", amplitude=60).ok
