"""What drives, runs or rolls off, and how far what goes by itself goes."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.language import inventory, read
from physagent_studio.program import Grounding, PhysicalProgram
from physagent_studio.program.scene.state import Box, Slab, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

STREET = Stage(
    "street",
    {
        "car": (Box(size=(4.2, 1.7, 1.4)), (0.5, 12.0, 0.7), "floor"),
        "dog": (Box(size=(0.8, 0.25, 0.6)), (-1.5, 6.0, 0.3), "floor"),
        "ball": (Sphere(radius=0.11), (0.8, 4.5, 0.11), "floor"),
        "cone": (Box(size=(0.3, 0.3, 0.5)), (-0.6, 4.5, 0.25), "floor"),
        "trolley": (Box(size=(0.9, 0.5, 1.0)), (1.9, 7.0, 0.5), "floor"),
    },
)
DESK = Stage(
    "desk",
    {"toy_car": (Box(size=(0.12, 0.06, 0.05)), (0.0, 2.5, 0.785), "desk")},
    {"desk": Slab(position=(0.0, 2.5, 0.38), size=(1.6, 0.9, 0.76))},
)


def first(prompt: str, stage: Stage = STREET) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


@pytest.mark.parametrize(
    ("prompt", "leaves"),
    [
        ("The car drives off to the left.", "car"),
        ("The car speeds off.", "car"),
        ("The dog runs off to the left.", "dog"),
        ("The dog trots off.", "dog"),
        ("The dog walks off to the left.", "dog"),
        ("The trolley rolls off.", "trolley"),
        ("The ball rolls off to the right.", "ball"),
        ("The car drives away to the left.", "car"),
        ("The dog runs away.", "dog"),
        ("The ball rolls away to the right.", "ball"),
    ],
)
def test_what_goes_off_leaves_the_picture(prompt: str, leaves: str) -> None:
    program = first(prompt)
    assert program.contract.leaving == (leaves,)
    rollout = simulate(program)
    gone = [c for c in measure(program, rollout) if "has left the picture" in c.text]
    assert [check.ok for check in gone] == [True]
    pace = next(c for c in measure(program, rollout) if "goes at most as fast" in c.text)
    assert pace.ok, pace.text


@pytest.mark.parametrize(
    "prompt",
    [
        # Off a thing, to or from a thing, or with more to come; too far to walk, and not free.
        "The ball hits the cone and rolls off.",
        "The dog runs away from the ball.",
        "The ball rolls away to the right and stops.",
        "The car drives off and hits the trolley.",
        "The car drives off and stops beside the trolley.",
        "The dog runs off to the left and jumps.",
        "The dog walks off to the right.",
        "The ball rolls off to the left.",
    ],
)
def test_what_only_sets_out_stays_in_the_picture(prompt: str) -> None:
    assert first(prompt).contract.leaving == ()


def test_off_a_table_is_off_that() -> None:
    assert first("The toy car drives off.", DESK).contract.leaving == ()


@pytest.mark.parametrize(
    ("prompt", "length"),
    [
        ("The car drives to the left.", 4.2),
        ("The dog walks to the left.", 0.8),
        ("The trolley rolls to the left and stops.", 0.9),
        ("The dog gallops to the right.", 0.8),
        ("The dog runs a little to the right.", 0.0),
    ],
)
def test_what_goes_by_itself_goes_its_own_length_where_there_is_room(
    prompt: str, length: float
) -> None:
    program = first(prompt)
    moves = next(s for s in program.contract.statements if s.kind == "moves")
    assert moves.distance >= 0.6 * length
    assert moves.distance <= max(length, 0.1)
    checks = measure(program, simulate(program))
    assert all(check.ok for check in checks if check.clause is not None)


@pytest.mark.parametrize(
    ("verb", "gait"),
    [("drives", "drive"), ("rides", "drive"), ("gallops", "run"), ("strolls", "walk")],
)
def test_what_goes_by_itself_has_a_gait(verb: str, gait: str) -> None:
    (frame,) = read(f"The car {verb} to the left.", inventory([("car", Grounding())])).frames
    assert (frame.sense, frame.gait) == ("move", gait)


@pytest.mark.parametrize(
    "prompt",
    [
        "The car rolls to the left and comes to a halt halfway out of the frame.",
        "The car rolls slowly backwards, brakes and stops halfway out of the picture.",
    ],
)
def test_what_halts_halfway_out_of_the_picture_is_cut_by_its_border(prompt: str) -> None:
    program = first(prompt)
    assert (program.contract.leaving, program.contract.partly) == ((), ("car",))
    assert not program.contract.untested
    checks = {c.id: c for c in measure(program, simulate(program))}
    assert checks["view.gone.car"].ok, checks["view.gone.car"].text
    assert checks["view.inside.car"].ok
    assert checks["car_stops"].ok


@pytest.mark.parametrize(("wide", "ahead"), [(0.7, 0.0), (4.0, -1.0)])
def test_off_a_table_that_leaves_the_picture_it_goes_over_an_edge_that_is_seen(
    wide: float, ahead: float
) -> None:
    table = Slab(position=(0.0, 2.5, 0.38), size=(wide, 0.5, 0.76))
    block = (Box(size=(0.1, 0.1, 0.1)), (0.2, 2.5, 0.81), "table")
    program = first(
        "The box is pushed off the table to the left.", Stage("t", {"box": block}, {"table": table})
    )
    rollout = simulate(program)
    way = rollout.positions[:, 0] - rollout.positions[0, 0]
    fell = int((way[:, 2] < -0.1).argmax())
    assert fell > 0
    assert way[fell, 0] < -0.05
    assert (way[fell, 1] < -0.1) == (ahead < 0)
