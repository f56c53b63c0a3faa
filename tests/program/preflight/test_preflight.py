"""What preflight finds, and that its suggestion settles it."""

from typing import Any, get_args

import pytest

from physagent_studio.program import Clip, Contract, PhysicalProgram, apply
from physagent_studio.program.actions import duration_of
from physagent_studio.program.preflight.clashes import Code
from physagent_studio.program.preflight.preflight import preflight
from physagent_studio.program.statements import Moves, StopsBefore

FLOOR = {"name": "floor", "shape": {"kind": "floor"}}
BALL = {
    "name": "ball",
    "shape": {"kind": "sphere", "radius": 0.1},
    "position": [0, 0, 0.1],
    "support": "floor",
    "material": "leather",
}
CRATE = {
    "name": "crate",
    "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]},
    "position": [1, 0, 0.2],
    "support": "floor",
    "material": "wood",
}


def program(*actions: dict[str, Any], **scene: Any) -> PhysicalProgram:
    base = {"objects": [BALL, CRATE], "supports": [FLOOR]}
    return PhysicalProgram.model_validate(
        {"clip": {"frames": 26}, "scene": {**base, **scene}, "event": {"actions": actions}}
    )


def act(operator: str, name: str = "crate", action_id: str = "a", **fields: Any) -> dict[str, Any]:
    return {"id": action_id, "name": name, "operator": operator, **fields}


def push(force: Any, action_id: str = "a", **fields: Any) -> dict[str, Any]:
    return act("ApplyForce", action_id=action_id, force=force, **{"duration": 10, **fields})


STRONG = [200, 0, 0]
ON_RAMP = {"name": "ramp", "shape": {"kind": "ramp", "toe": [3, 0, 0], "yaw": 0}}

CASES = {
    "fixed_target": program(act("FixObject", duration=50), push(STRONG, "b", start_step=10)),
    "past_end": program(
        push(STRONG),
        act("SetPosition", action_id="b", position=[1, 0, 0.2])
        | {"when": {"kind": "after", "action": "a", "delay": 95}},
    ),
    "below_friction": program(push([3, 0, 0])),
    "contradiction": program(
        act("SetVelocity", velocity=[1, 0, 0]),
        act("SetVelocity", action_id="b", velocity=[0, 1, 0]),
    ),
    "overlapping": program(
        act("FixObject", duration=50), act("FixObject", action_id="b", start_step=20, duration=9)
    ),
    "collision": program(objects=[BALL, {**CRATE, "position": [0.2, 0, 0.2]}]),
    "in_the_air": program(objects=[{**BALL, "support": None, "position": [0, 0, 1]}]),
    "not_on_support": program(objects=[{**BALL, "position": [0, 0, 1]}]),
    "tunnelling": program(act("SetVelocity", "ball", velocity=[60, 0, 0])).model_copy(
        update={"clip": Clip(frames=26, substeps=1)}
    ),
    "cannot_act": program(
        act("SetOrientation", rotation=[1, 0, 0, 0]),
        objects=[{**CRATE, "body": {"kind": "granular"}}],
    ),
    "never_starts": program(push(STRONG, when={"kind": "on_contact", "a": "crate", "b": "crate"})),
    "implausible_density": program(objects=[{**BALL, "density": 9000}]),
    "implausible_size": program(
        objects=[{**BALL, "shape": {"kind": "sphere", "radius": 60}, "position": [0, 0, 60]}]
    ),
    "implausible_speed": program(act("SetVelocity", "ball", velocity=[400, 0, 0])),
    "no_effect": program(push([0, 0, 0])),
    "unplaced": program(landmarks=[{"name": "line", "kind": "line"}]),
    "untestable": program().model_copy(
        update={"contract": Contract(statements=(Moves(id="m", subject="ball", from_step=200),))}
    ),
}


def codes(given: PhysicalProgram) -> set[str]:
    return {finding.code for finding in preflight(given)}


def test_a_good_program_has_no_findings():
    assert not preflight(program(push(STRONG)))


@pytest.mark.parametrize("code", sorted(CASES))
def test_it_is_found(code):
    found = [finding for finding in preflight(CASES[code]) if finding.code == code]
    assert found
    assert all(finding.message and finding.path for finding in found)


@pytest.mark.parametrize("code", sorted(CASES))
def test_the_suggestion_settles_it(code):
    finding = next(one for one in preflight(CASES[code]) if one.code == code)
    assert finding.edits
    assert code not in codes(apply(CASES[code], finding.edits))


def test_every_kind_of_finding_has_a_case():
    assert set(CASES) == set(get_args(Code))


@pytest.mark.parametrize(
    "action",
    [
        act("SetVelocity", "ball", velocity={"magnitude": 300, "direction": "right"}),
        push([4e6, 0, 0]),
        act("ApplyAngledForce", "ball", magnitude=9e4, angle=0, duration=20),
    ],
)
def test_what_is_too_fast_is_made_slower_by_its_own_actions(action):
    given = program(action)
    finding = next(one for one in preflight(given) if one.code == "implausible_speed")
    assert "implausible_speed" not in codes(apply(given, finding.edits))


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        ({"kind": "sphere", "radius": 110}, 110),
        ({"kind": "sphere", "radius": 0.0001}, 0.0001),
        ({"kind": "capsule", "radius": 60, "height": 300}, 150),
        ({"kind": "torus", "radius": 60, "tube": 10}, 10),
        ({"kind": "revolved", "profile": [[-60, 0], [-50, 30], [60, 40]], "wall": 5}, 60),
        ({"kind": "box", "size": [0.3, 0.2, 0.001]}, 0.0005),
        ({"kind": "ellipsoid", "radii": [0.1, 0.1, 0.0005]}, 0.0005),
        ({"kind": "cylinder", "radius": 0.1, "height": 0.001}, 0.0005),
        ({"kind": "torus", "radius": 0.1, "tube": 0.0005}, 0.0005),
        ({"kind": "frustum", "bottom_radius": 0.1, "top_radius": 0.08, "height": 0.001}, 0.0005),
    ],
)
def test_a_size_that_cannot_be_meant_is_put_right_where_it_stands(shape, height):
    given = program(objects=[{**BALL, "shape": shape, "position": [0, 0, height]}])
    finding = next(one for one in preflight(given) if one.code == "implausible_size")
    assert not codes(apply(given, finding.edits)) & {"implausible_size", "collision"}
    assert "not_on_support" not in codes(apply(given, finding.edits))


def test_what_hangs_over_nothing_may_be_meant_to():
    given = program(objects=[{**BALL, "support": None, "position": [0, 0, 1]}], supports=[])
    finding = next(one for one in preflight(given) if one.code == "in_the_air")
    assert "in_the_air" not in codes(apply(given, finding.edits))


def test_two_holds_become_one_over_both_windows():
    given = program(
        act("FixObject", start_step=20, duration=30),
        act("FixObject", action_id="b", start_step=5, duration=20),
    )
    finding = next(one for one in preflight(given) if one.code == "overlapping")
    (kept,) = apply(given, finding.edits).event.actions
    assert (kept.id, kept.start_step, duration_of(kept)) == ("b", 5, 45)


def test_an_unplaced_landmark_that_a_statement_names_is_left_to_a_person():
    line = [{"name": "line", "kind": "line"}]
    given = program(landmarks=line)
    asked = given.model_copy(
        update={
            "contract": Contract(statements=(StopsBefore(id="s", subject="ball", before="line"),))
        }
    )
    finding = next(one for one in preflight(asked) if one.code == "unplaced")
    assert not finding.edits


def test_open_geometry_is_passed_over():
    bare = [{"name": "ball"}, {"name": "crate"}]
    assert not preflight(program(push([3, 0, 0]), objects=bare))


def test_a_push_on_what_rolls_needs_no_friction():
    assert "below_friction" not in codes(program(push([0.1, 0, 0], name="ball") | {"name": "ball"}))


def test_a_stack_is_no_collision_and_stands():
    top = {**CRATE, "name": "top", "position": [1, 0, 0.6], "support": "crate"}
    assert not preflight(program(objects=[CRATE, top]))


def test_a_circle_of_waiting_actions_never_starts():
    waiting = program(
        push(STRONG, when={"kind": "after", "action": "b"}),
        push(STRONG, "b", when={"kind": "after", "action": "a"}),
    )
    assert "never_starts" in codes(waiting)


def test_waiting_for_a_muted_action_never_starts():
    waiting = program(
        push(STRONG, muted=True), push(STRONG, "b", when={"kind": "after", "action": "a"})
    )
    assert "never_starts" in codes(waiting)


def test_what_hangs_in_the_air_is_fine_when_that_is_meant_or_held():
    hanging = {**BALL, "position": [0, 0, 1]}
    assert not preflight(program(objects=[{**hanging, "support": "air"}]))
    held = act("FixObject", "ball", duration=50)
    assert not preflight(program(held, objects=[{**hanging, "support": None}]))


def test_pushes_that_cancel_are_a_contradiction():
    assert "contradiction" in codes(program(push(STRONG), push([-200, 0, 0], "b")))
    assert "contradiction" not in codes(program(push(STRONG), push([0, 200, 0], "b")))


def test_a_muted_action_is_passed_over():
    assert not preflight(program(push([3, 0, 0], muted=True)))
