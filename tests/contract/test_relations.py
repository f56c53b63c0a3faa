"""How often, how far along, and on which side: statements on paths made by hand."""

import numpy as np
import pytest


def hops(time: np.ndarray, times: int, height: float) -> np.ndarray:
    """Height of a ball's centre that comes down from `height` and rebounds `times` times."""
    return 0.1 + height * np.abs(np.cos(np.pi * times * time / time[-1]))


def contact_steps(z: np.ndarray) -> list[int]:
    return [int(i) for i in np.nonzero(z < 0.1 + 0.06)[0]]


@pytest.mark.parametrize("rebounds", [1, 2, 3])
def test_bounces_are_counted(stage, time, rebounds):
    z = hops(time, rebounds, 0.5)
    stage.path("ball", z=z).touch("ball", "floor", contact_steps(z))
    for times in (1, 2, 3):
        check = stage.check("bounces", subject="ball", other="floor", times=times)
        assert check.ok is (rebounds >= times), check.text


def test_what_lies_where_it_fell_has_not_bounced(stage, time):
    z = np.maximum(0.1, 0.6 - 2 * time)
    stage.path("ball", z=z).touch("ball", "floor", contact_steps(z))
    check = stage.check("bounces", subject="ball", other="floor")
    assert not check.ok
    assert "0 of 1" in check.text


def test_what_is_picked_up_after_a_rest_has_not_bounced(stage, time):
    z = 0.1 + np.maximum(0.2 - time, 0) + np.maximum(time - 0.8, 0)
    stage.path("ball", z=z).touch("ball", "floor", contact_steps(z))
    assert not stage.check("bounces", subject="ball", other="floor").ok


def test_the_margin_of_a_bounce_grows_with_the_rebound(stage, time):
    margins = []
    for rebound in (0.002, 0.006, 0.012):
        z = np.where(time < 0.5, 0.1 + np.maximum(0.4 - time, 0), 0.1 + rebound)
        stage.rows.clear()
        stage.path("ball", z=z).touch("ball", "floor", range(40, 51))
        margins.append(stage.check("bounces", subject="ball", other="floor", height=0.01).margin)
    assert margins == sorted(margins)
    assert margins[0] < margins[1] < 0 < margins[2]


@pytest.mark.parametrize(("end", "ok"), [(0.1, False), (0.25, True), (0.45, False)])
def test_halfway_to_a_line(stage, time, end, ok):
    stage.path("ball", x=end * time / time[-1])
    check = stage.check("covers", subject="ball", other="line")
    assert check.ok is ok
    assert check.measured == pytest.approx(2 * end, abs=0.01)


def test_halfway_to_a_body_counts_from_surface_to_surface(stage, time):
    # From 0.1 to the cube's side at 0.9: 0.8 m of free way.
    stage.path("ball", x=0.4 * time / time[-1])
    assert stage.check("covers", subject="ball", other="cube").measured == pytest.approx(0.5, 0.02)
    all_of_it = {"low": 0.9, "high": 10.0}
    assert not stage.check("covers", subject="ball", other="cube", **all_of_it).ok
    stage.path("ball", x=0.79 * time / time[-1])
    assert stage.check("covers", subject="ball", other="cube", **all_of_it).ok


def test_sides_are_those_that_the_camera_sees(stage, time):
    goals = {
        "behind": (1.0, 0.5), "in_front": (1.0, -0.5), "left": (0.5, 0.0), "right": (1.5, 0.0),
        "beside": (1.25, 0.0),
    }  # fmt: skip
    for side, (x, y) in goals.items():
        share = time / time[-1]
        stage.path("ball", x=-2 + (x + 2) * share, y=-2 + (y + 2) * share)
        for at_end in (False, True):
            fields = {"subject": "ball", "other": "cube", "side": side, "at_end": at_end}
            assert stage.check("side_of", **fields).ok, side
        # Far off to the side is not behind, nor in front.
        stage.path("ball", x=-2 + (x - 3) * share, y=-2 + (y + 2) * share)
        if side not in ("left", "beside"):
            assert not stage.check("side_of", subject="ball", other="cube", side=side).ok, side


def test_a_side_that_is_left_again_is_not_held_at_the_end(stage, time):
    stage.path("ball", x=1.0, y=np.sin(np.pi * time / time[-1]) - 0.5)
    assert stage.check("side_of", subject="ball", other="cube", side="behind").ok
    assert not stage.check("side_of", subject="ball", other="cube", side="behind", at_end=True).ok


def test_above_and_under(stage, time):
    stage.path("ball", x=3.0, z=1.5)
    assert stage.check("side_of", subject="ball", other="table", side="above").ok
    assert not stage.check("side_of", subject="ball", other="table", side="under").ok
    assert stage.check("side_of", subject="ball", other="floor", side="above").ok is False


def test_turning_back_twice(stage, time):
    there_and_back = 0.5 * np.abs(np.mod(2 * time / time[-1] + 1, 2) - 1)
    stage.path("ball", x=there_and_back)
    assert stage.check("reverses", subject="ball").ok
    assert not stage.check("reverses", subject="ball", times=2).ok
    stage.path("ball", x=0.5 * np.abs(np.mod(4 * time / time[-1] + 1, 2) - 1))
    assert stage.check("reverses", subject="ball", times=3).ok


@pytest.mark.parametrize(
    ("steps", "turn", "ordered", "together"),
    [
        ((20, 40, 60), True, True, False),
        ((40, 20, 60), True, False, False),
        ((20, 22, 24), False, False, True),
    ],
)
def test_in_turn_and_together(stage, steps, turn, ordered, together):
    parts = []
    for name, step in zip(("ball", "cube", "can"), steps, strict=True):
        stage.touch(name, "table", [step])
        parts.append({"id": name, "kind": "contacts", "subject": name, "other": "table"})
    of = ["ball", "cube", "can"]
    checks = stage.checks(
        *parts,
        {"id": "turn", "kind": "in_turn", "of": of},
        {"id": "ordered", "kind": "in_turn", "of": of, "ordered": True},
        {"id": "together", "kind": "together", "of": of, "within": 0.1},
    )
    assert [check.ok for check in checks[3:6]] == [turn, ordered, together]
    assert all(check.demanded for check in checks[:3])


def test_in_turn_needs_all_of_them(stage):
    stage.touch("ball", "table", [10])
    parts = [{"id": n, "kind": "contacts", "subject": n, "other": "table"} for n in ("ball", "can")]
    for kind in ("in_turn", "together"):
        check = stage.checks(*parts, {"id": "x", "kind": kind, "of": ["ball", "can"]})[2]
        assert not check.ok
        assert "1 of 2 do not happen" in check.text
