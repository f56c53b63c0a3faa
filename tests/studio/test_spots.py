"""New things stand free: beside what is there, past what is in the way, on what carries all."""

from __future__ import annotations

import pytest

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.studio.panels.scene import spot_of
from physagent_studio.studio.view import Selection

FLOOR = "{name: floor, shape: {kind: floor, height: -0.5}}"
TABLE = "{name: table, shape: {kind: box, position: [3, 2, 0], size: [2, 1, 0.4]}}"
RAMP = "{name: ramp, shape: {kind: ramp, toe: [0.3, 2, -0.5], yaw: 0, run: 1, rise: 0.4, width: 1}}"
NOTHING = Selection("none", "")


def _program(supports: str, on: str, x: float = 0.0, z: float = -0.4) -> PhysicalProgram:
    ball = f"shape: {{kind: sphere, radius: 0.1}}, position: [{x}, 2, {z}], support: {on}"
    return load_program(f"scene:\n  objects: [{{name: ball, {ball}}}]\n  supports: [{supports}]\n")


def test_beside_what_is_there_on_the_ground() -> None:
    spot = spot_of(_program(FLOOR, "floor"), NOTHING)
    assert spot.foot == pytest.approx((0.3, 2.0, -0.5))
    assert (spot.on, spot.size) == ("floor", 0.2)


def test_past_a_ramp_that_is_in_the_way() -> None:
    spot = spot_of(_program(f"{FLOOR}, {RAMP}", "floor"), NOTHING)
    assert spot.foot == pytest.approx((1.5, 2.0, -0.5))


@pytest.mark.parametrize("selection", [NOTHING, Selection("support", "table")])
def test_on_the_table_that_carries_the_rest_or_is_selected(selection: Selection) -> None:
    on = "floor" if selection.name else "table"
    program = _program(f"{FLOOR}, {TABLE}", on, x=3.0, z=0.3)
    spot = spot_of(program, selection)
    assert spot.on == "table"
    x, y, z = spot.foot
    assert z == pytest.approx(0.2)
    assert 2 < x < 4
    assert 1.5 < y < 2.5
    assert abs(x - 3.0) > 0.3, "not on the ball"


def test_an_empty_scene_has_a_middle() -> None:
    spot = spot_of(PhysicalProgram(), NOTHING)
    assert spot.foot == (0.0, 1.5, 0.0)
    assert spot.on is None
