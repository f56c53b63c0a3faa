"""The workbench with the real rooms: commands in, snapshots out, nothing lost on bad input."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.program import AddItem, PhysicalProgram, SetField
from physagent_studio.program.text.document import load_program
from physagent_studio.program.timing import PACE
from physagent_studio.records import Hunk, LoopState, Preview, Proposal
from physagent_studio.session import Store
from physagent_studio.workbench import Snapshot, Workbench, commands

PROGRAM = """
scene:
  objects:
    - name: ball
      shape: {kind: sphere, radius: 0.1}
      position: [0, 2, 0.1]
      support: floor
    - name: box
      shape: {kind: box, size: [0.2, 0.2, 0.2]}
      position: [1, 2, 0.1]
      support: floor
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball rolls to the right and hits the box.
  actions:
    - {operator: SetVelocity, id: go, name: ball, velocity: [0.5, 0, 0], start_step: 0}
contract:
  clauses: [{id: c1, text: hits the box}]
  statements:
    - {id: hit, kind: contacts, subject: ball, other: box, clause: c1}
"""


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    workbench = Workbench(Store(tmp_path), evidence=False)
    yield workbench
    workbench.close()


def after(workbench: Workbench, *posted: commands.Command) -> Snapshot:
    for command in posted:
        workbench.post(command)
    assert workbench.wait(60)
    return workbench.snapshot()


def opened(workbench: Workbench) -> Snapshot:
    program = load_program(PROGRAM)
    return after(workbench, commands.OpenProgram(program, "two things"))


def faster(value: float) -> commands.ApplyEdits:
    return commands.ApplyEdits((SetField(path="event.actions.go.velocity.0", value=value),))


def test_a_warning_ends_with_the_session_that_it_is_about(bench: Workbench, tmp_path: Path) -> None:
    mine = opened(bench).session_id
    assert mine is not None
    other = Workbench(Store(tmp_path), evidence=False)
    shown = after(other, commands.OpenSession(mine))
    assert [notice.level for notice in shown.notices] == ["warning"]
    assert not opened(other).notices
    other.close()


def test_a_bare_program_opens_and_is_simulated(bench: Workbench) -> None:
    snapshot = opened(bench)
    assert not snapshot.notices, snapshot.notices
    assert snapshot.rollout is not None
    assert snapshot.has_draft
    assert [check.id for check in snapshot.checks if not check.always_on] == ["hit"]


def test_a_hand_edit_changes_the_trajectory_at_once_and_undo_brings_it_back(
    bench: Workbench,
) -> None:
    first = opened(bench)
    second = after(bench, faster(1.5))
    assert first.rollout is not None
    assert second.rollout is not None
    assert not np.array_equal(first.rollout.positions, second.rollout.positions)
    back = after(bench, commands.Undo())
    assert back.program.hash == first.program.hash
    assert back.rollout is not None
    assert np.array_equal(back.rollout.positions, first.rollout.positions)
    assert after(bench, commands.Redo()).program.hash == second.program.hash


def test_ten_edits_undo_and_redo_to_the_same_hashes(bench: Workbench) -> None:
    hashes = [opened(bench).program.hash]
    hashes += [after(bench, faster(0.11 * n)).program.hash for n in range(1, 11)]
    assert len(set(hashes)) == 11
    down = [after(bench, commands.Undo()).program.hash for _ in range(10)]
    assert down == hashes[-2::-1]
    up = [after(bench, commands.Redo()).program.hash for _ in range(10)]
    assert up == hashes[1:]


def test_bad_edits_and_bad_text_change_nothing_and_say_where(bench: Workbench) -> None:
    before = opened(bench)
    wrong = commands.ApplyEdits((SetField(path="event.actions.go.velocity.0", value=1e9),))
    snapshot = after(bench, wrong)
    assert snapshot.program.hash == before.program.hash
    assert "velocity" in snapshot.notices[-1].text
    text = PROGRAM.replace("name: ball, velocity", "name: bal, velocity")
    snapshot = after(bench, commands.ApplyText(text))
    assert snapshot.program.hash == before.program.hash
    problem = snapshot.yaml_problems[0]
    assert problem.path == "event.actions.go.name"
    assert problem.line == text[: text.index("name: bal,")].count("\n") + 1


def test_step_makes_the_draft_a_round_and_judges_it(bench: Workbench) -> None:
    opened(bench)
    # Slow enough that the event fills half of the clip.
    snapshot = after(bench, faster(0.8), commands.Step())
    assert not snapshot.has_draft
    assert [item.author for item in snapshot.state.rounds] == ["person"]
    assert snapshot.state.outcome == "realised"


def test_a_session_comes_back_as_it_was(bench: Workbench, tmp_path: Path) -> None:
    opened(bench)
    before = after(bench, faster(2.0), commands.Step(), faster(0.3))
    bench.close()
    again = Workbench(Store(tmp_path), evidence=False)
    assert before.session_id is not None
    snapshot = after(again, commands.OpenSession(before.session_id))
    again.close()
    assert snapshot.program.hash == before.program.hash
    assert snapshot.state == before.state
    assert snapshot.rollout is not None
    assert before.rollout is not None
    assert np.array_equal(snapshot.rollout.positions, before.rollout.positions)


def test_other_rounds_are_read_only_until_forked(bench: Workbench) -> None:
    opened(bench)
    after(bench, faster(2.0), commands.Step(), faster(0.3), commands.Step())
    shown = after(bench, commands.ShowRound("r1"))
    assert shown.read_only
    refused = after(bench, faster(1.0))
    assert "read-only" in refused.notices[-1].text
    forked = after(bench, commands.ForkFrom("r1"), faster(1.0), commands.Step())
    assert [item.parent for item in forked.state.rounds] == [None, "r1", "r1"]


def test_twenty_clicks_on_accept_have_one_effect(bench: Workbench) -> None:
    opened(bench)
    after(bench, faster(0.05), commands.Step())
    waiting = bench.snapshot()
    assert waiting.state.phase == "decide", waiting.notices
    current = waiting.state.current
    assert current is not None
    assert current.proposal is not None
    accept = commands.Decide("accept", current.proposal.id)
    snapshot = after(bench, *[accept] * 20)
    assert len(snapshot.state.rounds) == 2


def test_a_verdict_can_be_overruled(bench: Workbench) -> None:
    opened(bench)
    after(bench, faster(0.05), commands.Step())
    snapshot = after(bench, commands.OverruleVerdict(True, "close enough"))
    assert snapshot.state.outcome == "realised"
    current = snapshot.state.current
    assert current is not None
    assert current.override is not None
    assert current.assessment is not None
    assert not current.assessment.passed


def test_a_verdict_that_is_mine_to_give_is_waited_for(bench: Workbench) -> None:
    opened(bench)
    state = after(bench, commands.TakeRole("verifier"), commands.Run()).state
    assert (state.phase, state.policy) == ("judge", "ask")
    state = after(bench, commands.OverruleVerdict(True)).state
    assert state.current is not None
    assert state.current.assessment is not None
    assert (state.phase, state.current.assessment.stage) == ("judge", "simulation")
    # Nobody answering is no yes: asked again, it still waits.
    assert after(bench, commands.Run()).state.rounds == state.rounds
    assert after(bench, commands.OverruleVerdict(True)).state.outcome == "realised"


@pytest.mark.usefixtures("shared_scenes")
def test_a_first_program_that_is_mine_to_write_is_laid_out(tmp_path: Path) -> None:
    workbench = Workbench(Store(tmp_path), evidence=False)
    snapshot = after(workbench, commands.OpenCase(assets_dir() / "demo"))
    written = snapshot.program
    assert written.event.actions
    laid_out = after(workbench, commands.TakeRole("generator"))
    assert laid_out.has_draft
    assert laid_out.program.event.actions == ()
    assert laid_out.program.scene == written.scene
    assert laid_out.program.contract == written.contract
    mine = commands.ApplyEdits(
        (AddItem(path="event.actions", item=written.event.actions[0].model_dump(mode="json")),)
    )
    ran = after(workbench, mine, commands.Step()).state
    assert [item.author for item in ran.rounds][:2] == ["generator", "person"]
    assert ran.rounds[1].program.event.actions[:1] == written.event.actions[:1]
    workbench.close()


def test_what_was_stopped_goes_on_and_what_happened_does_not(bench: Workbench) -> None:
    opened(bench)
    held = after(bench, faster(0.05), commands.Step()).state
    assert held.current is not None
    assert held.current.proposal is not None
    stop = commands.Decide("stop", held.current.proposal.id)
    assert after(bench, stop).state.outcome == "stopped"
    again = after(bench, commands.Step()).state
    assert (again.phase, again.outcome) == ("decide", "running")
    assert again.current is not None
    assert again.current.proposal is not None
    happened = after(bench, commands.OverruleVerdict(True, "close enough"))
    assert happened.state.outcome == "realised"
    # Nothing is left to do, so nothing is done and there is no step to undo.
    assert after(bench, commands.Step()).state == happened.state
    assert after(bench, commands.Undo()).state.outcome == "running"


def test_pins_must_name_something(bench: Workbench) -> None:
    opened(bench)
    snapshot = after(bench, commands.Pin("event.actions.go.velocity"))
    assert snapshot.state.pinned == ("event.actions.go.velocity",)
    assert "has no field" in after(bench, commands.Pin("event.nothing")).notices[-1].text
    assert after(bench, commands.Unpin("event.actions.go.velocity")).state.pinned == ()


def test_a_pace_that_a_person_sets_is_one_edit_and_pinned(bench: Workbench) -> None:
    before = opened(bench)
    later = SetField(path="event.actions.go.start_step", value=40)
    moved = after(bench, commands.ApplyEdits((later,)))
    slow = after(bench, commands.Retime(0.4))
    clip = slow.program.clip
    assert clip.time_factor == pytest.approx(0.4)
    assert (clip.frames, clip.playback_fps) == (moved.program.clip.frames, 25.0)
    # What begins 0.4 s into the event still does.
    action = slow.program.action("go")
    assert action is not None
    assert action.start_step * clip.step_seconds == pytest.approx(0.4)
    assert slow.rollout is not None
    assert slow.rollout.step_seconds == clip.step_seconds
    assert slow.state.pinned == PACE
    back = after(bench, commands.Undo())
    assert (back.program, back.state.pinned) == (moved.program, ())
    # The pace that it has already can be pinned as well; nothing else changes.
    kept = after(bench, commands.Retime(before.program.clip.time_factor))
    assert (kept.program, kept.state.pinned) == (moved.program, PACE)
    assert "not allowed" in after(bench, commands.Retime(0.1)).notices[-1].text


def test_records_of_decisions_are_plain_data() -> None:
    hunk = Hunk(id="h", summary="s", edits=(SetField(path="clip.frames", value=41),))
    proposal = Proposal(id="p", hunks=(hunk,), rationale="r", factor="f", confidence=0.5)
    state = LoopState(draft=PhysicalProgram())
    assert Proposal.model_validate_json(proposal.model_dump_json()) == proposal
    assert Preview.model_validate_json(Preview(program=None).model_dump_json()).program is None
    assert LoopState.model_validate_json(state.model_dump_json()) == state
