"""What a viewer must be able to see: of each rule runs that keep it and runs that break it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from physagent_studio.contract import measure
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.view import (
    COVERS,
    FALL_FILLS,
    FALLING_STEP,
    FILLS,
    STEP,
    Drawn,
    acting_objects,
    nothing_happens,
    pacing_of,
    subject_of,
    view_code,
)
from physagent_studio.program import Camera, PhysicalProgram, apply
from physagent_studio.program.timing import retimed
from physagent_studio.records import Check
from physagent_studio.records.rollout import Release
from physagent_studio.simulation import simulate

# 5.3 m wide at the things' distance of 4 m.
CAMERA = Camera.from_horizon((320, 200), 60.0, 1.0)
BALL = {"name": "ball", "shape": {"kind": "sphere", "radius": 0.1}, "friction": 0.0, "rolling": 0.0}
BOX = {"name": "box", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}}
seeds = pytest.mark.parametrize("seed", [1, 2])

Thing = Mapping[str, Any]


def at(thing: Thing, x: float, z: float = 0.1, y: float = 4.0, **fields: Any) -> dict[str, Any]:
    return {**thing, "position": [x, y, z], "support": "floor", **fields}


def go(name: str, *velocity: float, start: int = 0) -> dict[str, Any]:
    return {
        "operator": "SetVelocity", "id": f"go_{name}", "name": name, "start_step": start,
        "velocity": list(velocity),
    }  # fmt: skip


def hold(name: str, start: int, end: int) -> dict[str, Any]:
    return {
        "operator": "FixObject", "id": f"hold_{name}_{start}", "name": name, "start_step": start,
        "duration": end - start,
    }  # fmt: skip


def says(kind: str, subject: str = "ball", **fields: Any) -> dict[str, Any]:
    return {"id": f"{subject}_{kind}", "kind": kind, "subject": subject, **fields}


def scene_of(
    things: list[dict[str, Any]],
    actions: list[dict[str, Any]] | None = None,
    *statements: dict[str, Any],
    frames: int = 81,
    paces: list[dict[str, Any]] | None = None,
    supports: list[dict[str, Any]] | None = None,
    camera: Camera | None = CAMERA,
) -> PhysicalProgram:
    floor = {"name": "floor", "shape": {"kind": "floor"}}
    return PhysicalProgram.model_validate(
        {
            "clip": {"frames": frames},
            "scene": {
                "camera": camera and camera.model_dump(),
                "objects": things,
                "supports": [floor, *(supports or [])],
            },
            "event": {"actions": actions or []},
            "contract": {"statements": statements, "paces": paces or []},
        }
    )


def views(program: PhysicalProgram, drawn: Mapping[str, Drawn] | None = None) -> dict[str, Check]:
    """The view checks of a run, by id."""
    checks = measure(program, simulate(program, {}), drawn)
    return {check.id: check for check in checks if check.kind == "view"}


def agrees(check: Check) -> None:
    """A check says the same in its margin, its answer and its words."""
    assert check.ok == (check.margin >= 0)
    assert (": yes" in check.text) == check.ok, check.text
    assert check.always_on
    assert check.demanded


def widest(program: PhysicalProgram) -> float:
    """The farthest step of the ball from frame to frame, parts of the width."""
    rollout = simulate(program, {})
    pixels, _ = CAMERA.project(rollout.positions[rollout.frame_steps(), 0])
    seen = np.all((pixels > 8) & (pixels < np.array(CAMERA.size) - 8), axis=1)
    steps = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    return float(steps[seen[1:] & seen[:-1]].max() / CAMERA.size[0])


def side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


# --- in the picture ------------------------------------------------------------------------------


@seeds
def test_what_acts_stays_in_the_picture(seed: int) -> None:
    rng = np.random.default_rng(seed)
    way, slow, fast = side(rng), rng.uniform(0.3, 0.8), rng.uniform(2.5, 3.5)
    kept, lost = (
        views(scene_of([at(BALL, -way)], [go("ball", way * speed, 0, 0)], says("moves")))[
            "view.inside.ball"
        ]
        for speed in (slow, fast)
    )
    assert kept.ok
    assert kept.measured == pytest.approx(1.0)
    assert not lost.ok
    agrees(kept)
    agrees(lost)


def test_the_farther_and_longer_out_the_worse() -> None:
    margins = [
        views(scene_of([at(BALL, -1.0)], [go("ball", speed, 0, 0)], says("moves")))[
            "view.inside.ball"
        ].margin
        for speed in (2.0, 2.5, 3.5, 5.0)
    ]
    assert margins == sorted(margins, reverse=True)
    assert margins[0] < 0


def test_it_is_said_from_which_frame_on_it_is_out() -> None:
    program = scene_of([at(BALL, -1.0)], [go("ball", 3.0, 0, 0)], says("moves"))
    rollout = simulate(program, {})
    check = next(c for c in measure(program, rollout) if c.id == "view.inside.ball")
    assert check.step is not None
    pixels, _ = CAMERA.project(rollout.positions[rollout.frame_steps(), 0])
    first = int(np.argmax(pixels[:, 0] > CAMERA.size[0]))
    assert abs(rollout.frame_of(check.step) - first) <= 1


def test_what_only_stands_by_may_be_cut_off() -> None:
    program = scene_of([at(BALL, -1.0), at(BOX, 2.7)], [go("ball", 0.4, 0, 0)], says("moves"))
    assert acting_objects(program) == {"ball"}
    assert "view.inside.box" not in views(program)


def shelf(wide: float = 0.5) -> dict[str, Any]:
    """A high shelf in a picture that ends above the floor below it."""
    shape = {"kind": "box", "position": [0, 4, 1.5], "size": [wide, 0.5, 0.1]}
    return {"name": "shelf", "shape": shape}


def test_what_falls_out_of_the_picture_has_been_seen_to_fall() -> None:
    ahead = Camera.from_horizon((320, 200), 150.0, 1.0)
    things = [at(BALL, 0.2, 1.65, support="shelf")]
    found = {
        kind: views(
            scene_of(things, [go("ball", 1.0, 0, 0)], says(kind), supports=[shelf()], camera=ahead)
        )["view.inside.ball"]
        for kind in ("falls", "moves")
    }
    assert found["falls"].ok, found["falls"].text
    assert not found["moves"].ok


def test_what_has_come_down_in_the_picture_does_not_roll_out_of_it() -> None:
    """Onto a lower shelf, which it rolls along until it is out of sight."""
    ahead = Camera.from_horizon((320, 200), 150.0, 1.0)
    shape = {"kind": "box", "position": [1.4, 4, 0.9], "size": [2.0, 0.5, 0.1]}
    lower = {"name": "lower", "shape": shape}
    things = [at(BALL, 0.2, 1.65, support="shelf")]
    for boards, ok in (([shelf()], True), ([shelf(), lower], False)):
        actions = [go("ball", 1.0, 0, 0)]
        program = scene_of(things, actions, says("falls"), supports=boards, camera=ahead)
        found = views(program)["view.inside.ball"]
        assert found.ok is ok, found.text


def test_what_comes_into_the_picture_as_it_falls_is_judged_too() -> None:
    """It begins above the picture, and is seen to fall later than it was first out of it."""
    low = Camera.from_horizon((320, 200), 150.0, 1.0)
    program = scene_of([at(BALL, 0.0, 4.0, support="air")], [], says("falls"), camera=low)
    assert "view.inside.ball" in views(program)


def test_what_flies_out_past_a_side_has_a_floor_to_fall_on() -> None:
    """The floor is in the picture below where it began to fall."""
    wide = Camera.from_horizon((320, 200), 60.0, 1.0)
    things = [at(BALL, 0.0, 1.6, support="air")]
    program = scene_of(things, [go("ball", 3.0, 0, 0)], says("falls"), camera=wide)
    assert not views(program)["view.inside.ball"].ok


# --- readable ------------------------------------------------------------------------------------


@seeds
def test_nothing_moves_faster_than_an_eye_follows(seed: int) -> None:
    rng = np.random.default_rng(seed)
    way, slow, fast = side(rng), rng.uniform(0.5, 3.0), rng.uniform(7.0, 9.0)
    for speed, ok in ((slow, True), (fast, False)):
        program = scene_of([at(BALL, -2.0 * way)], [go("ball", way * speed, 0, 0)], says("moves"))
        check = views(program)["view.pace.ball"]
        agrees(check)
        assert check.ok == ok, check.text
        assert check.threshold == STEP
        assert check.measured == pytest.approx(widest(program), rel=0.01)
        # From the speed, the focal length and the distance.
        width = speed * 0.04 * CAMERA.focal / 4.1 / CAMERA.size[0]
        assert check.measured == pytest.approx(width, rel=0.05)


def test_a_fall_may_be_twice_as_fast() -> None:
    things = [at(BALL, 0.0, 2.0, support="air")]
    check = views(scene_of(things, [], says("falls")))["view.pace.ball"]
    assert check.threshold == FALLING_STEP
    assert check.measured is not None


def test_slow_motion_makes_the_steps_smaller() -> None:
    program = scene_of([at(BALL, -2.0)], [go("ball", 8.0, 0, 0)], says("moves"))
    slow = apply(program, retimed(program, 0.25))
    before, after = (views(one)["view.pace.ball"] for one in (program, slow))
    assert not before.ok
    assert after.ok
    assert before.measured is not None
    assert after.measured == pytest.approx(before.measured / 4, rel=0.15)


@seeds
def test_the_motion_fills_a_good_part_of_the_clip(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.3, 0.7) * side(rng)
    long, short = int(rng.integers(180, 260)), int(rng.integers(20, 110))
    for until, ok in ((long, True), (short, False)):
        actions = [go("ball", speed, 0, 0), hold("ball", until, 320)]
        check = views(scene_of([at(BALL, 0.0)], actions, says("moves")))["view.fills"]
        agrees(check)
        assert check.ok == ok, check.text
        assert check.measured == pytest.approx(until / 320, abs=0.03)
        assert check.threshold == FILLS


@seeds
def test_what_stops_does_so_before_the_clip_ends(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.3, 0.6)
    early, late = int(rng.integers(200, 270)), int(rng.integers(300, 312))
    for until, ok in ((early, True), (late, False)):
        actions = [go("ball", speed, 0, 0), hold("ball", until, 320)]
        check = views(scene_of([at(BALL, -1.0)], actions, says("stops")))["view.fills"]
        agrees(check)
        assert check.ok == ok, check.text


def test_a_fall_in_the_slowest_motion_may_fill_less() -> None:
    program = scene_of([at(BALL, 0.0, 0.6, support="air")], [], says("falls"))
    slow = apply(program, retimed(program, 0.25))
    assert views(program)["view.fills"].threshold == FILLS
    assert views(slow)["view.fills"].threshold == FALL_FILLS


@seeds
def test_both_are_seen_before_and_after_they_meet(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed, way = rng.uniform(0.8, 1.2), side(rng)
    hit = says("contacts", other="box")
    for gap, ok in ((rng.uniform(0.3, 0.8), True), (rng.uniform(0.02, 0.03), False)):
        things = [at(BALL, 0.0), at(BOX, way * (0.2 + gap))]
        check = views(scene_of(things, [go("ball", way * speed, 0, 0)], hit))[
            "view.meeting.ball.box"
        ]
        agrees(check)
        assert check.ok == ok, check.text


@seeds
def test_a_blow_is_seen_on_one_of_the_two(seed: int) -> None:
    """Straight on the ball stops or the box is shifted; it passes a heavy box that it grazes."""
    rng = np.random.default_rng(seed)
    speed, way = rng.uniform(0.8, 1.2), side(rng)
    for density, aside, ok in ((100, 0.0, True), (20_000, 0.0, True), (20_000, 0.195, False)):
        things = [at(BALL, -0.5 * way, y=4.0 + aside), at(BOX, 0.0, density=density)]
        told = scene_of(things, [go("ball", way * speed, 0, 0)], says("contacts", other="box"))
        check = views(told)["view.act.ball.box"]
        agrees(check)
        assert check.ok == ok, check.text


def test_what_touches_from_the_start_does_not_meet() -> None:
    touching = (
        says("contacts", other="floor"),
        says("contacts", other="box", negated=True) | {"id": "apart"},
    )
    found = views(scene_of([at(BALL, 0.0), at(BOX, 1.0)], [], *touching))
    assert not [one for one in found if one.startswith("view.meeting")]


def test_a_meeting_that_is_told_twice_is_checked_once() -> None:
    hit = says("contacts", other="box")
    again = hit | {"id": "again", "from_step": 5}
    program = scene_of([at(BALL, 0.0), at(BOX, 0.7)], [go("ball", 1.0, 0, 0)], hit, again)
    checks = [c.id for c in measure(program, simulate(program, {}))]
    assert sorted(set(checks)) == sorted(checks)
    assert "view.meeting.ball.box" in checks


@seeds
def test_nothing_decisive_comes_with_the_last_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.8, 1.2)
    things = [at(BALL, 0.0), at(BOX, rng.uniform(0.5, 0.9))]
    parts = (things, [go("ball", speed, 0, 0)], says("contacts", other="box"))
    program = scene_of(*parts)
    hit = measure(program, simulate(program, {}))[0].step
    assert hit is not None
    for more, ok in ((12, True), (2, False)):
        check = views(scene_of(*parts, frames=hit // 4 + more))["view.in_time"]
        agrees(check)
        assert check.ok == ok, check.text
        assert check.step == hit


@seeds
def test_something_is_seen_to_happen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for speed, ok in ((rng.uniform(0.2, 0.8), True), (rng.uniform(0.001, 0.01), False)):
        actions = [go("ball", speed * side(rng), 0, 0)]
        check = views(scene_of([at(BALL, 0.0)], actions, says("moves")))["view.something"]
        agrees(check)
        assert check.ok == ok, check.text


def test_turning_on_the_spot_is_something() -> None:
    spin = {
        "operator": "SetAngularVelocity", "id": "spin", "name": "box", "duration": 300,
        "angular_velocity": [0, 0, 2.0],
    }  # fmt: skip
    assert views(scene_of([at(BOX, 0.0)], [spin], says("rotates", "box")))["view.something"].ok


def test_where_things_shall_stay_nothing_has_to_happen() -> None:
    program = scene_of([at(BOX, 0.0)], [], says("stays", "box"))
    assert nothing_happens(program)
    found = views(program)
    assert not {"view.something", "view.fills"} & set(found)
    assert all(check.ok for check in found.values())


# --- begins and ends -----------------------------------------------------------------------------


@seeds
def test_what_is_drawn_covers_what_was_photographed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    program = scene_of([at(BALL, 0.0), at(BOX, 1.0)])
    good, bad = rng.uniform(COVERS, 1.0), rng.uniform(0.1, COVERS - 0.01)
    found = views(program, {"ball": Drawn(good, 0.2), "box": Drawn(bad, 0.2)})
    for name, overlap in (("ball", good), ("box", bad)):
        check = found[f"view.begins.{name}"]
        agrees(check)
        assert check.ok == (overlap >= COVERS)
        assert check.measured == overlap


@seeds
def test_nothing_stirs_before_its_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    near = Camera.from_horizon((640, 400), 120.0, 1.0)
    rise = rng.uniform(0.9, 1.2)
    ramp = {"kind": "ramp", "toe": [-0.5, 2.0, 0], "yaw": 0, "run": 1, "rise": rise, "width": 0.5}
    slope = float(np.arctan(rise))
    middle = [-0.1 * np.sin(slope), rise / 2 + 0.1 * np.cos(slope)]
    for thing, ok in (
        (at(BALL, rng.uniform(-0.5, 0.5), 0.1, 1.5), True),
        (at(BALL, middle[0], middle[1], 2.0, support="ramp"), False),
    ):
        supports = [] if ok else [{"name": "ramp", "shape": ramp}]
        check = views(scene_of([thing], supports=supports, camera=near, frames=20))["view.calm"]
        agrees(check)
        assert check.ok == ok, check.text
    assert "ball moves by" in check.text


def test_what_is_pushed_or_told_to_fall_may_stir_at_once() -> None:
    near = Camera.from_horizon((640, 400), 120.0, 1.0)
    pushed = scene_of([at(BALL, 0.0, 0.1, 1.5)], [go("ball", 2.0, 0, 0)], camera=near)
    falling = scene_of([at(BALL, 0.0, 0.5, 1.5, support="air")], [], says("falls"), camera=near)
    struck = scene_of(
        [at(BALL, 0.0, 0.1, 1.5), at(BOX, 0.205, 0.1, 1.5)], [go("ball", 3.0, 0, 0)], camera=near
    )
    for program in (pushed, falling, struck):
        assert views(program)["view.calm"].ok


@seeds
def test_what_stops_is_at_rest_at_the_end(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.3, 0.6) * side(rng)
    rolling = [go("ball", speed, 0, 0)]
    stopped = [*rolling, hold("ball", int(rng.integers(150, 250)), 320)]
    for actions, ok in ((stopped, True), (rolling, False)):
        check = views(scene_of([at(BALL, 0.0)], actions, says("stops")))["view.ends.ball"]
        agrees(check)
        assert check.ok == ok, check.text


@seeds
def test_what_sways_still_moves_at_the_end(seed: int) -> None:
    rng = np.random.default_rng(seed)
    side_to_side = {
        "operator": "ApplyDisturbance", "id": "wind", "name": "ball", "model": "side",
        "amplitude": rng.uniform(20, 40), "frequency": 1.0, "duration": 320,
    }  # fmt: skip
    still = [side_to_side | {"duration": 100}, hold("ball", 100, 320)]
    for actions, ok in (([side_to_side], True), (still, False)):
        check = views(scene_of([at(BALL, 0.0, friction=0.5)], actions, says("sways")))[
            "view.ends.ball"
        ]
        agrees(check)
        assert check.ok == ok, check.text


# --- as much as told -----------------------------------------------------------------------------


@seeds
def test_it_goes_no_faster_than_the_verb_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    high = rng.uniform(0.5, 1.5)
    pace = {"subject": "ball", "verb": "roll", "low": 0.1, "high": high}
    for share, ok in ((rng.uniform(0.3, 0.9), True), (rng.uniform(1.2, 2.0), False)):
        actions = [go("ball", share * high, 0, 0)]
        program = scene_of([at(BALL, -1.0)], actions, says("moves"), paces=[pace])
        check = views(program)["view.amount.ball"]
        agrees(check)
        assert check.ok == ok, check.text
        assert check.measured == pytest.approx(share * high, rel=0.05)
        assert "“roll”" in check.text


@seeds
def test_what_only_tips_over_comes_down_where_it_stood(seed: int) -> None:
    rng = np.random.default_rng(seed)
    slow = [go("ball", rng.uniform(0.3, 0.6), 0, 0), hold("ball", 60, 320)]
    fast = [go("ball", rng.uniform(1.0, 1.5), 0, 0)]
    for actions, ok in ((slow, True), (fast, False)):
        program = scene_of([at(BALL, -1.0)], actions, says("topples"))
        check = views(program)["view.place.ball"]
        agrees(check)
        assert check.ok == ok, check.text
    # What rolls on as it is told to has gone its way.
    told = scene_of([at(BALL, -1.0)], fast, says("topples"), says("rotates", angle=90))
    assert "view.place.ball" not in views(told)


@seeds
def test_what_only_tips_over_is_not_tossed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    along = [go("ball", rng.uniform(0.3, 0.6), 0, 0)]
    up = [go("ball", 0, 0, rng.uniform(1.2, 2.0))]
    for actions, ok in ((along, True), (up, False)):
        floor = says("contacts", other="floor")
        check = views(scene_of([at(BALL, -1.0)], actions, says("topples"), floor))[
            "view.tossed.ball"
        ]
        agrees(check)
        assert check.ok == ok, check.text
    blow = says("contacts", other="box")
    hit = scene_of([at(BALL, -1.0), at(BOX, 0.5)], up, says("topples"), blow)
    assert "view.tossed.ball" not in views(hit)


@seeds
def test_what_tips_off_a_stack_comes_down_as_far_off_as_it_was_high(seed: int) -> None:
    high = np.random.default_rng(seed).uniform(0.7, 0.9)
    off = [go("ball", 0.9, 0, 0), hold("ball", 60, 320)]
    for z, ok in ((high, True), (0.1, False)):
        program = scene_of([at(BALL, -1.0, z, support="air")], off, says("topples"))
        check = views(program)["view.place.ball"]
        agrees(check)
        assert check.ok == ok, check.text


@seeds
def test_what_nothing_is_told_of_is_not_run_into(seed: int) -> None:
    rng = np.random.default_rng(seed)
    way = side(rng)
    for speed, ok in ((rng.uniform(0.5, 0.9), False), (rng.uniform(0.1, 0.18), True)):
        things = [at(BALL, 0.0), at(BOX, 0.35 * way)]
        go_there = [go("ball", way * speed, 0, 0)]
        check = views(scene_of(things, go_there, says("moves")))["view.alone.ball.box"]
        agrees(check)
        assert check.ok == ok, check.text
        # What the sentence has it hit is no bystander, nor what it passes by.
        hit = views(scene_of(things, go_there, says("contacts", other="box")))
        beside = views(scene_of([things[0], at(BOX, 0.35 * way, y=4.5)], go_there, says("moves")))
        assert not [one for one in (*hit, *beside) if one.startswith("view.alone")]


@seeds
def test_who_stands_still_runs_into_nobody(seed: int) -> None:
    """As the last of a row that is told to fall, and those before it are not spoken of."""
    rng = np.random.default_rng(seed)
    way = side(rng)
    between = {**BOX, "name": "between", "friction": 0.0}
    things = [at(BALL, 0.0, density=4000), at(between, 0.35 * way), at(BOX, 0.7 * way)]
    strike = [go("ball", way * rng.uniform(0.8, 1.2), 0, 0)]
    found = views(scene_of(things, strike, says("moves"), says("moves", "box")))
    assert not found["view.alone.ball.between"].ok
    assert found["view.alone.box.between"].ok


@seeds
def test_what_slides_does_not_tip_over(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pace = {"subject": "crate", "verb": "slide", "high": 3.0}
    force = {"magnitude": rng.uniform(0.6, 0.9), "direction": "right", "quantity": "target_speed"}
    push = {
        "operator": "ApplyForce", "id": "push", "name": "crate", "duration": 200, "force": force,
    }  # fmt: skip
    for high, ok in ((rng.uniform(0.1, 0.2), True), (rng.uniform(0.6, 0.8), False)):
        crate = at(
            {"name": "crate", "shape": {"kind": "box", "size": [0.2, 0.2, high]}}, -1.0, high / 2
        )
        program = scene_of(
            [crate | {"friction": 1.0}], [push], says("moves", "crate"), paces=[pace]
        )
        check = views(program)["view.footing.crate"]
        agrees(check)
        assert check.ok == ok, check.text
        # What is told to tip over may, and what rolls or is kicked.
        told = scene_of([crate], [push], says("topples", "crate"), paces=[pace])
        kicked = scene_of([crate], [push], says("moves", "crate"), paces=[pace | {"verb": "kick"}])
        assert "view.footing.crate" not in {**views(told), **views(kicked)}


def test_what_slides_may_tumble_once_it_has_met_something() -> None:
    pace = {"subject": "crate", "verb": "slide", "high": 3.0}
    crate = at({"name": "crate", "shape": {"kind": "box", "size": [0.1, 0.1, 0.3]}}, -1.0, 0.15)
    brick = at({"name": "brick", "shape": {"kind": "box", "size": [0.3, 0.3, 0.06]}}, -0.4, 0.03)
    things = [crate | {"friction": 0.02}, brick | {"friction": 1.0, "density": 8000.0}]
    program = scene_of(things, [go("crate", 1.5, 0, 0)], says("moves", "crate"), paces=[pace])
    assert simulate(program, {}).rotations[-1, 0, 0] < 0.95
    check = views(program)["view.footing.crate"]
    assert check.ok, check.text


@seeds
def test_what_falls_over_has_come_down_by_the_end(seed: int) -> None:
    tall = np.random.default_rng(seed).uniform(0.35, 0.45)
    shape = {"kind": "box", "size": [0.1, 0.1, tall]}
    post = at({"name": "post", "shape": shape, "friction": 1.0}, 0.0, tall / 2)
    force = {"magnitude": 1.0, "direction": "right", "quantity": "target_speed"}
    push = {
        "operator": "ApplyForce", "id": "push", "name": "post", "duration": 20, "force": force,
        "point": [0.0, 0.0, 0.18], "point_frame": "body",
    }  # fmt: skip
    told = says("topples", "post", tilt=60)
    tilt = np.degrees(np.arccos(1 - 2 * (simulate(scene_of([post], [push]), {}).rotations[:, 0, 1:3]
                                         ** 2).sum(1)))  # fmt: skip
    halfway = int(np.argmax(tilt > 65)) // 4 + 1
    for frames, ok in ((81, True), (halfway, False)):
        check = views(scene_of([post], [push], told, frames=frames))["view.in_time.post"]
        agrees(check)
        assert check.ok == ok, check.text
    # What the fall takes out of the picture is not seen to lie.
    gone = scene_of([post], [push, go("post", 20.0, 0, 0, start=30)], told)
    assert "view.in_time.post" not in views(gone)


@seeds
def test_what_falls_over_to_a_side_leans_to_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    post = at({"name": "post", "shape": {"kind": "box", "size": [0.1, 0.1, 0.4]}}, 0.0, 0.2)
    told = [says("topples", "post"), says("moves", "post", direction="right", distance=0.05)]
    for off, ok in ((rng.uniform(0, 35), True), (rng.uniform(60, 170), False)):
        force = {"magnitude": 1.0, "direction": "right", "quantity": "target_speed"}
        push = {
            "operator": "ApplyForce", "id": "push", "name": "post", "duration": 20,
            "force": force | {"azimuth": off * side(rng)}, "point": [0.0, 0.0, 0.18],
            "point_frame": "body",
        }  # fmt: skip
        program = scene_of([post | {"friction": 1.0}], [push], *told)
        check = views(program)["view.lean.post"]
        agrees(check)
        assert check.ok == ok, check.text
        # Where no side is told it may fall to any.
        assert "view.lean.post" not in views(scene_of([post], [push], told[0]))


def test_a_fall_is_as_fast_as_it_is() -> None:
    pace = {"subject": "ball", "verb": "roll", "high": 1.0}
    things = [at(BALL, 0.0, 1.5, support="air")]
    check = views(scene_of(things, [], says("falls"), paces=[pace]))["view.amount.ball"]
    # It lands at more than 5 m/s.
    assert check.ok, check.text


@seeds
def test_what_has_wheels_goes_along_its_axis_front_first(seed: int) -> None:
    rng = np.random.default_rng(seed)
    heading, speed = rng.uniform(-180, 180), rng.uniform(0.4, 0.8)
    cart = at({"name": "cart", "shape": {"kind": "box", "size": [0.3, 0.3, 0.1]}}, 0.0, 0.05)
    wheels = {"heading": heading, "rolling": 0.01, "grip": 0.1}
    ways = ((0.0, (), True), (180.0, ("cart",), True), (180.0, (), False), (0.0, ("cart",), False))
    for off, backwards, ok in (*ways, (rng.uniform(60, 120), (), False)):
        # Stronger than what its wheels hold across.
        force = {"magnitude": 2.0 + speed, "direction": "right", "quantity": "acceleration"}
        push = {
            "operator": "ApplyForce", "id": "push", "name": "cart", "duration": 60,
            "force": force | {"azimuth": (heading + off + 180) % 360 - 180},
        }  # fmt: skip
        program = scene_of([cart | {"wheels": wheels}], [push], says("moves", "cart"))
        contract = program.contract.model_copy(update={"backwards": backwards})
        check = views(program.model_copy(update={"contract": contract}))["view.wheels.cart"]
        agrees(check)
        assert check.ok == ok, check.text


def test_wheels_on_a_slope_are_judged_from_above() -> None:
    slope = np.arctan2(0.24, 0.6)
    ramp = {"kind": "ramp", "toe": [0, 4, 0], "yaw": np.pi, "run": 0.6, "rise": 0.24, "width": 0.4}
    cart = {
        "name": "cart", "shape": {"kind": "box", "size": [0.2, 0.14, 0.05]}, "support": "ramp",
        "position": [-0.3 + 0.026 * np.sin(slope), 4.0, 0.12 + 0.026 * np.cos(slope)],
        "rotation": [np.cos(slope / 2), 0.0, np.sin(slope / 2), 0.0],
        "wheels": {"heading": 0.0, "rolling": 0.01, "grip": 1.0},
    }  # fmt: skip
    supports = [{"name": "ramp", "shape": ramp}]
    program = scene_of([cart], [], says("moves", "cart"), supports=supports)
    rollout = simulate(program, {})
    assert rollout.positions[-1, 0, 0] > 0.2
    check = views(program)["view.wheels.cart"]
    agrees(check)
    assert check.ok, check.text


def test_what_falls_over_need_not_stay_on_its_wheels() -> None:
    cart = at({"name": "cart", "shape": {"kind": "box", "size": [0.3, 0.3, 0.1]}}, 0.0, 0.05)
    cart |= {"wheels": {"heading": 0.0}}
    actions = [go("cart", 0.0, 0.5, 0)]
    tips = scene_of([cart], actions, says("topples", "cart"))
    assert "view.wheels.cart" not in views(tips)


def test_what_comes_off_a_table_may_tumble_from_there() -> None:
    cart = at({"name": "cart", "shape": {"kind": "box", "size": [0.3, 0.3, 0.1]}}, 0.0, 0.85)
    cart |= {"wheels": {"heading": 0.0}, "support": "table"}
    slab = {"kind": "box", "position": [0, 4, 0.4], "size": [1, 1, 0.8]}
    table = [{"name": "table", "shape": slab}]
    off = [go("cart", 0.5, 0, 0)]
    for kind in ("leaves", "contacts"):
        drives = scene_of([cart], off, says(kind, "cart", other="table"), supports=table)
        check = views(drives)["view.wheels.cart"]
        assert check.ok is (kind == "leaves"), check.text


# --- the whole -----------------------------------------------------------------------------------


def test_without_a_camera_there_is_no_view() -> None:
    program = scene_of([at(BALL, 0.0)], [go("ball", 1, 0, 0)], says("moves"), camera=None)
    assert views(program) == {}
    assert pacing_of(Facts.of(program, simulate(program, {}))) is None


def test_the_subject_is_found_in_the_id() -> None:
    pin = {"name": "pin", "shape": {"kind": "sphere", "radius": 0.1}}
    things = [at(pin, -0.5), at(pin | {"name": "pin_2"}, 0.3)]
    hit = says("contacts", "pin", other="pin_2")
    program = scene_of(things, [go("pin", 0.8, 0, 0)], hit)
    rollout = simulate(program, {})
    found = {
        check.id: subject_of(check, rollout)
        for check in measure(program, rollout)
        if check.kind == "view"
    }
    assert found["view.inside.pin"] == "pin"
    assert found["view.pace.pin"] == "pin"
    assert found["view.meeting.pin.pin_2"] == "pin"
    assert found["view.fills"] == ""


@seeds
def test_the_pacing_is_told_in_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, end = int(rng.integers(10, 40)) * 4, int(rng.integers(45, 75)) * 4
    actions = [go("ball", 0.5, 0, 0, start=start), hold("ball", end, 320)]
    program = scene_of([at(BALL, -1.0)], actions, says("moves"))
    pacing = pacing_of(Facts.of(program, simulate(program, {})))
    assert pacing is not None
    assert pacing.first == pytest.approx(start // 4, abs=1)
    assert pacing.last == pytest.approx(end // 4, abs=1)
    assert pacing.moving == pytest.approx((end - start) // 4, abs=2)
    assert pacing.crossings == ()
    assert pacing.time_factor == 1.0


def test_the_pacing_says_when_something_leaves_the_picture() -> None:
    program = scene_of([at(BALL, -1.0)], [go("ball", 3.0, 0, 0)], says("moves"))
    rollout = simulate(program, {})
    pacing = pacing_of(Facts.of(program, rollout))
    out = next(c for c in measure(program, rollout) if c.id == "view.inside.ball")
    assert pacing is not None
    assert out.step is not None
    assert pacing.crossings == (("ball", rollout.frame_of(out.step)),)


@pytest.mark.parametrize(
    ("x", "told", "ok"),
    [
        (2.66, "partly", True),
        (2.5, "partly", False),
        (2.9, "partly", False),
        (2.66, "leaving", False),
        (2.72, "leaving", False),  # an arm of it is still seen
        (2.9, "leaving", True),
    ],
)
def test_what_leaves_is_gone_and_what_halts_halfway_out_is_not(
    x: float, told: str, ok: bool
) -> None:
    halt = round((x - 1.9) * 100)
    actions = [go("ball", 1.0, 0, 0), hold("ball", halt, 320)]
    program = scene_of([at(BALL, 1.9)], actions, says("moves"))
    contract = program.contract.model_copy(update={told: ("ball",)})
    found = views(program.model_copy(update={"contract": contract}))
    agrees(found["view.gone.ball"])
    assert found["view.gone.ball"].ok is ok, found["view.gone.ball"].text
    if ok and told == "partly":
        assert found["view.inside.ball"].ok


@pytest.mark.parametrize(
    ("thing", "step", "ok"),
    [
        (at(BALL, 1.9), 40, True),
        (at(BALL, 1.9), 120, False),  # beyond the right border
        (at(BALL, 0.5, z=1.0, y=1.2, support="air"), 60, None),  # its floor is below the picture
    ],
)
def test_what_comes_apart_does_so_within_the_picture(
    thing: dict[str, Any], step: int, ok: bool | None
) -> None:
    program = scene_of([thing], [go("ball", 1.0, 0, 0)], says("moves"))
    broken = (Release(step, "ball", "j0", 1.0),)
    checks = measure(program, replace(simulate(program, {}), releases=broken))
    found = [check for check in checks if check.id == "view.breaks.ball"]
    assert [check.ok for check in found] == ([] if ok is None else [ok])
    for check in found:
        agrees(check)
        assert view_code(check) == "framing"
