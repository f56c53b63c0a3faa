"""Robustness and attribution give the answer where the programs are built so that it is known."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.jobs import Inline
from physagent_studio.program import SetField, apply
from physagent_studio.program.edits import AddItem, Edit, Hunk
from physagent_studio.sweep import Target
from physagent_studio.sweep.attribution import attribution
from physagent_studio.sweep.robustness import draw, robustness, uncertain
from tests.sweep.programs import slider, target


def test_what_holds_by_far_holds_in_all_and_what_just_holds_in_half() -> None:
    assert robustness(slider(0.08), Inline(), 12).sentence == "holds in 12 of 12"
    # The block slides as far as it has to, within a few millimetres: half of the draws do not.
    found = robustness(slider(0.166), Inline(), 24)
    assert 6 <= found.holds <= 18
    assert found.first is not None
    assert found.first.id == "slides"


def test_it_is_said_which_number_breaks_it_first() -> None:
    """v² / 2 μ g: of speed (5 %, twice) and friction of the floor (15 %, halved by the mean of both

    surfaces) and of the block (2 %), the two large ones decide, and mass does not matter at all.
    """
    found = robustness(slider(0.166), Inline(), 40)
    assert found.why is not None
    number, apart = found.why
    assert number.label in ("strength of block", "friction of floor")
    assert (apart > 0) == (number.label == "friction of floor")
    held = np.array([ran.holds for ran in found.runs])
    by_name = {one.label: found.draws[:, place] for place, one in enumerate(found.numbers)}
    apart = by_name["density of block"][held].mean() - by_name["density of block"][~held].mean()
    assert abs(apart) < abs(found.why[1])
    assert found.paths[0].shape[:2] == (40, 11)


def test_the_same_seed_draws_the_same_and_pose_is_certain_where_it_was_given() -> None:
    program = slider(0.1).program
    assert draw(program, 7) == draw(program, 7) != draw(program, 8)
    assert not any(".position." in number.knob.path for number in uncertain(program))
    guessed = apply(program, [SetField(path="scene.objects.block.source", value="estimated")])
    placed = [one for one in uncertain(guessed) if ".position." in one.knob.path]
    assert [one.spread for one in placed] == pytest.approx([0.002, 0.002])


# --- attribution ---------------------------------------------------------------------------------

TWO_BLOCKS = """
clip: {frames: 11}
scene:
  objects:
    - {name: a, shape: {kind: box, size: [0.2, 0.2, 0.1]}, position: [0, 2, 0.05], support: floor}
    - {name: b, shape: {kind: box, size: [0.2, 0.2, 0.1]}, position: [0, 3, 0.05], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The blocks slide to the right.
  actions:
    - {operator: SetVelocity, id: a, name: a, velocity: [0, 0, 0], start_step: 0}
    - {operator: SetVelocity, id: b, name: b, velocity: [0, 0, 0], start_step: 0}
contract:
  clauses: [{id: c1, text: slides}]
  statements:
    - {id: a, kind: moves, subject: a, direction: right, distance: 0.05, clause: c1DEMANDS}
"""


def blocks(demands: str) -> Target:
    """Two blocks; of which it is demanded that they move, `demands` says."""
    return target(TWO_BLOCKS.replace("DEMANDS", demands))


def hunk(name: str, *edits: Edit) -> Hunk:
    return Hunk(id=name, summary=name, edits=edits)


def push(name: str, speed: float = 0.9) -> Edit:
    return SetField(path=f"event.actions.{name}.velocity", value=[speed, 0.0, 0.0])


NEEDED_BOTH = """}
    - {id: b, kind: moves, subject: b, direction: right, distance: 0.05, clause: c1"""
EITHER = """}
    - {id: b, kind: moves, subject: b, direction: right, distance: 0.05, clause: c1}
    - {id: one, kind: any_of, of: [a, b], clause: c1"""


@pytest.mark.parametrize(
    ("demands", "needed", "shares"),
    [("", [True, False], [1, 0]), (NEEDED_BOTH, [True, True], [0.5, 0.5])],
)
def test_the_hunks_that_bring_the_event_about_share_it(demands, needed, shares) -> None:
    found = attribution(blocks(demands), [hunk("a", push("a")), hunk("b", push("b"))], Inline())
    assert (found.before, found.after, found.exact) == (False, True, True)
    assert list(found.needed) == needed
    assert found.shapley == pytest.approx(shares)


def test_two_hunks_of_which_either_would_do_share_it_though_neither_is_needed() -> None:
    twice = [hunk("slow", push("a", 0.9)), hunk("fast", push("a", 1.0))]
    found = attribution(blocks(""), twice, Inline())
    assert list(found.needed) == [False, False]
    assert found.shapley == pytest.approx([0.5, 0.5])


def test_a_hunk_that_builds_on_another_does_nothing_alone() -> None:
    item = {"operator": "SetVelocity", "id": "new", "name": "a", "velocity": [0, 0, 0]}
    speed = SetField(path="event.actions.new.velocity", value=[0.9, 0.0, 0.0])
    made = [hunk("made", AddItem(path="event.actions", item=item)), hunk("sped", speed)]
    found = attribution(blocks(""), made, Inline())
    assert found.shapley == pytest.approx([0.5, 0.5])


def test_many_hunks_are_sampled_by_seed_and_add_up_and_of_too_many_each_is_left_out() -> None:
    idle = [
        hunk(f"idle{k}", SetField(path="scene.objects.b.density", value=500.0 + k))
        for k in range(8)
    ]
    found = attribution(blocks(""), [hunk("a", push("a")), *idle[:6]], Inline())
    assert not found.exact
    assert found.shapley == pytest.approx([1, 0, 0, 0, 0, 0, 0])
    found = attribution(blocks(""), [hunk("a", push("a")), *idle], Inline())
    assert found.shapley is None
    assert list(found.needed) == [True] + [False] * 8
    with pytest.raises(InputError):
        attribution(blocks(""), [], Inline())
