"""What has wheels faces and goes along its own axis, as far as its outline shows one."""

from __future__ import annotations

import dataclasses
import math
from types import MappingProxyType

import cv2
import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.planner.parameters import action_knobs, material_knobs
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.state import Box, Cylinder, Wheels
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import CAMERA, STAGES, Stage

LONG, SHORT = (0.2, 0.1, 0.08), (0.12, 0.1, 0.08)


def program_of(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def yard(turn: float, size=LONG, name: str = "toy_car", **others) -> Stage:
    """A car on the floor whose long side lies `turn` degrees counter-clockwise from the right."""
    things = {name: (Box(size=size), (0.0, 2.5, size[2] / 2), "floor"), **others}
    return Stage("yard", things, turns={name: about_up(math.radians(turn))})


def wheels_of(program: PhysicalProgram, name: str = "toy_car") -> Wheels:
    item = program.scene.object(name)
    assert item is not None
    assert item.wheels is not None
    return item.wheels


def off(angle: float, other: float) -> float:
    return abs((angle - other + 180) % 360 - 180)


@pytest.mark.parametrize(
    ("turn", "prompt", "heading"),
    [
        (0, "The toy car drives to the right.", 0),
        (0, "The toy car drives to the left.", 180),
        (30, "The toy car rolls to the left.", 210),
        (140, "The toy car rolls to the left.", 140),
        (60, "The toy car moves to the right.", 60),
        (20, "The toy car drives backwards to the left.", 20),
    ],
)
def test_it_sets_out_along_its_axis_with_the_end_that_goes_first(turn, prompt, heading):
    program = program_of(yard(turn), prompt)
    wheels = wheels_of(program)
    assert off(wheels.heading, heading) < 2
    assert not wheels.known
    assert any("toy_car faces is not seen in the picture" in flag for flag in program.scene.flags)


@pytest.mark.parametrize(
    ("turn", "x", "prompt", "goes"),
    [
        # With more room before it than behind it, or from before it, is how pictures are taken.
        (80, 0.0, "The toy car drives forward.", 260),
        (50, -0.6, "The toy car drives forward.", 50),
        (50, 0.6, "The toy car drives forward.", 230),
        (130, 0.6, "The toy car drives forward.", 130),
        (0, 0.4, "The toy car drives forward.", 180),
        (0, -0.4, "The toy car drives forward.", 0),
        (0, -0.4, "The toy car drives backwards.", 180),
    ],
)
def test_forward_is_where_it_is_likely_to_face(turn, x, prompt, goes):
    stage = yard(turn)
    shape, (_, y, z), support = stage.objects["toy_car"]
    stage = dataclasses.replace(stage, objects={"toy_car": (shape, (x, y, z), support)})
    rollout = simulate(program_of(stage, prompt))
    path = rollout.positions[-1, 0] - rollout.positions[0, 0]
    assert np.linalg.norm(path) > 0.1
    assert off(math.degrees(math.atan2(path[1], path[0])), goes) < 12


def test_forward_is_where_a_person_says_that_it_faces():
    stage = yard(50, SHORT)

    def turned(state):
        scene = stage.reconstruct(state)
        things = tuple(
            o.model_copy(update={"wheels": Wheels(heading=130.0, known=True)})
            for o in scene.state.objects
        )
        state = scene.state.model_copy(update={"objects": things})
        return dataclasses.replace(scene, state=state)

    program = RuleGenerator().first(stage.case("The toy car drives forward."), turned)
    assert off(wheels_of(program).heading, 130) < 1
    assert not any("faces is not seen" in flag for flag in program.scene.flags)


def test_the_two_sides_that_a_mask_shows_are_its_axis_before_any_outline():
    stage, prompt = yard(0), "The toy car drives to the left."
    corners = np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.09, 0.09)])
    turned = corners @ matrix_of(about_up(math.radians(130))).T + [0.0, 2.5, 0.0]
    pixels, _ = CAMERA.project(np.concatenate([turned, turned + np.array([0, 0, 0.1])]))
    mask = np.zeros((480, 832), np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(pixels.astype(np.float32)).astype(np.int32), 1)

    def seen(state):
        masks = MappingProxyType({"toy_car": mask.astype(bool)})
        return dataclasses.replace(stage.reconstruct(state), masks=masks)

    program = RuleGenerator().first(stage.case(prompt), seen)
    assert off(wheels_of(program).heading, 130) < 6
    assert any("taken to face left and away" in flag for flag in program.scene.flags)


def masked(stage: Stage, size: tuple[int, int]):
    """Reconstructs as the stage does; the car's mask is a rectangle so many pixels wide, high."""
    mask = np.zeros((480, 832), bool)
    mask[330 - size[1] : 330, 416 - size[0] // 2 : 416 + size[0] // 2] = True

    def seen(state):
        masks = MappingProxyType({"toy_car": mask})
        return dataclasses.replace(stage.reconstruct(state), masks=masks)

    return seen


@pytest.mark.parametrize(("size", "heading"), [((160, 70), 180), ((70, 70), 270)])
def test_one_side_seen_is_its_side_or_its_end_by_how_wide_it_looks(size, heading):
    stage = yard(0, SHORT)
    prompt = "The toy car drives towards the camera." if heading == 270 else "The car drives left."
    program = RuleGenerator().first(stage.case(prompt), masked(stage, size))
    wheels = wheels_of(program)
    assert off(wheels.heading, heading) < 3
    assert not any("shows no axis" in flag for flag in program.scene.flags)


def test_across_its_axis_nothing_drives_and_it_is_moved_the_way_that_is_said():
    stage = yard(0, SHORT)
    program = RuleGenerator().first(
        stage.case("The toy car moves to the left."), masked(stage, (70, 70))
    )
    assert off(wheels_of(program).heading, 180) < 2


@pytest.mark.parametrize("turn", [0, 30, 140])
def test_the_run_keeps_its_axis_and_stays_upright(turn):
    program = program_of(yard(turn), "The toy car drives to the left.")
    rollout = simulate(program)
    path = rollout.positions[-1, 0] - rollout.positions[0, 0]
    assert np.linalg.norm(path) > 0.1
    assert off(math.degrees(math.atan2(path[1], path[0])), wheels_of(program).heading) < 2
    first, last = (matrix_of(rollout.rotations[row, 0].tolist()) for row in (0, -1))
    assert np.trace(first.T @ last) > 1 + 2 * math.cos(math.radians(2))


def test_where_the_outline_shows_no_axis_it_faces_the_way_it_goes():
    program = program_of(yard(50, SHORT), "The toy car drives to the left.")
    assert off(wheels_of(program).heading, 180) < 1
    assert any("shows no axis" in flag for flag in program.scene.flags)


@pytest.mark.parametrize(("turn", "meets"), [(8, True), (60, False)])
def test_a_thing_to_hit_is_ahead_only_within_what_the_axis_may_be_wrong_by(turn, meets):
    can = (Cylinder(radius=0.05, height=0.12), (0.8, 2.5, 0.06), "floor")
    program = program_of(yard(turn, can=can), "The toy car drives into the can.")
    assert off(wheels_of(program).heading, 0 if meets else turn) < 2
    rollout = simulate(program)
    touched = (rollout.contacts["a"] == 0) & (rollout.contacts["b"] == 1)
    assert bool(touched.any()) == meets


@pytest.mark.parametrize(
    "prompt",
    [
        "The toy car skids to the left.",
        "The toy car drifts to the left.",
        "The toy car spins.",
        "The toy car slides sideways.",
        "The toy car tips over.",
    ],
)
def test_what_is_said_to_leave_its_axis_has_no_wheels_that_hold(prompt):
    item = program_of(yard(0), prompt).scene.object("toy_car")
    assert item is not None
    assert item.wheels is None


def test_casters_go_any_way_and_a_box_has_no_wheels():
    chair = program_of(yard(0, name="office_chair"), "The office chair rolls away from the camera.")
    wheels = wheels_of(chair, "office_chair")
    assert wheels.grip == wheels.rolling
    assert off(wheels.heading, 90) < 1
    box = program_of(yard(0, name="box"), "The box slides to the left.").scene.object("box")
    assert box is not None
    assert box.wheels is None


def test_on_a_slope_its_resistance_is_what_is_set_and_not_its_friction():
    program = program_of(STAGES["slope"], "The toy car rolls down the ramp and stops on it.")
    item = program.scene.object("toy_car")
    assert item is not None
    assert item.friction is None
    assert wheels_of(program).rolling > 0.3
    assert off(wheels_of(program).heading, 0) < 1
    free = program_of(STAGES["slope"], "The toy car rolls down the ramp.")
    # It runs on below, and comes to rest there before it leaves the picture.
    assert 0.02 < wheels_of(free).rolling < 0.2


def test_a_search_turns_the_resistance_and_the_front_and_not_the_aim():
    program = program_of(yard(0), "The toy car drives to the left.")
    factors = {knob.path.rpartition(".")[2]: knob for knob in material_knobs(program)}
    assert factors["rolling"].path == "scene.objects.toy_car.wheels.rolling"
    assert factors["heading"].factor == "direction"
    assert factors["friction"].low == pytest.approx(factors["friction"].value)
    assert not any(knob.factor == "direction" for knob in action_knobs(program))


@pytest.mark.parametrize(("x", "way"), [(-0.8, "right"), (0.8, "left")])
def test_an_animal_seen_from_its_side_goes_forward_to_the_side_with_more_room(x, way):
    body = (Box(size=(1.0, 0.35, 0.6)), (x, 6.0, 0.3), "floor")
    program = program_of(Stage("meadow", {"horse": body}), "The horse walks forward.")
    (moved,) = (s for s in program.contract.statements if s.kind == "moves")
    assert moved.direction == way


def test_an_animal_seen_from_its_front_comes_nearer():
    body = (Box(size=(0.4, 0.9, 0.8)), (0.0, 6.0, 0.4), "floor")
    program = program_of(Stage("meadow", {"dog": body}), "The dog runs forward.")
    (moved,) = (s for s in program.contract.statements if s.kind == "moves")
    assert moved.direction == "toward_camera"


def test_on_level_ground_what_slides_up_goes_to_the_upper_rim_of_the_picture():
    stage = Stage("floor", {"spoon": (Box(size=(0.04, 0.18, 0.02)), (0.0, 1.5, 0.01), "floor")})
    program = program_of(stage, "The spoon slides up and stops.")
    (moved,) = (s for s in program.contract.statements if s.kind == "moves" and not s.negated)
    assert moved.direction == "away"


@pytest.mark.parametrize(
    ("prompt", "brakes"),
    [
        ("The toy car drives to the left and knocks over the bottle.", True),
        ("The toy car drives to the left, knocks over the bottle and drives on.", False),
        ("The toy car drives to the left and pushes the bottle away.", False),
    ],
)
def test_who_drives_against_something_brakes_there(prompt, brakes):
    bottle = (Cylinder(radius=0.03, height=0.25), (-0.5, 2.5, 0.125), "floor")
    stage = yard(0, bottle=bottle)
    labels = {action.id for action in program_of(stage, prompt).event.actions}
    assert ("brake_toy_car" in labels) == brakes
