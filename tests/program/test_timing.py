"""Slow motion and time lapse: another clip, the same seconds."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_studio.program import Clip, PhysicalProgram, apply, apply_with_inverse
from physagent_studio.program.actions import When, duration_of
from physagent_studio.program.timing import ENGINE_STEP, FASTEST, SLOWEST, clip_at, retimed, wait_of

factors = st.floats(SLOWEST, FASTEST).map(lambda value: round(value, 3))
PLAIN = Clip()


@st.composite
def programs(draw: st.DrawFn) -> PhysicalProgram:
    """A ball with a schedule of pushes, holds and one-offs, some after others, and a contract."""
    steps = PLAIN.steps
    actions: list[dict[str, Any]] = []
    for number in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, steps - 1))
        action: dict[str, Any] = {"id": f"a{number}", "name": "ball", "start_step": start}
        kind = draw(st.sampled_from(["ApplyForce", "FixObject", "SetVelocity", "after"]))
        if kind == "SetVelocity":
            action |= {"operator": kind, "velocity": [1, 0, 0]}
        elif kind == "after" and number:
            delay, length = draw(st.integers(0, 90)), draw(st.integers(1, 90))
            when = {"kind": "after", "action": f"a{number - 1}", "delay": delay}
            when["timeout"] = draw(st.none() | st.integers(0, 300))
            action |= {"operator": "ApplyForce", "force": [1, 0, 0], "when": when}
            action["duration"] = length
        else:
            length = draw(st.integers(1, steps - start))
            force = {"operator": "ApplyForce", "force": [1, 0, 0]}
            action |= {"operator": "FixObject"} if kind == "FixObject" else force
            action["duration"] = length
        actions.append(action)
    first = draw(st.integers(0, steps))
    statement = {
        "id": "s", "kind": "moves", "subject": "ball", "distance": 0.1,
        "from_step": first, "to_step": draw(st.integers(first, steps)),
    }  # fmt: skip
    return PhysicalProgram.model_validate(
        {
            "scene": {"objects": [{"name": "ball"}]},
            "event": {"actions": actions},
            "contract": {"statements": [statement]},
        }
    )


@given(factors)
def test_the_clip_keeps_its_frames_and_how_fast_they_are_shown(factor: float) -> None:
    clip = clip_at(PLAIN, factor)
    assert clip.time_factor == pytest.approx(factor, rel=1e-4)
    assert (clip.frames, clip.playback_fps) == (PLAIN.frames, PLAIN.playback_fps)
    assert clip.step_seconds / clip.substeps <= ENGINE_STEP * (1 + 1e-6)
    assert clip.seconds == pytest.approx(PLAIN.seconds * factor, rel=1e-4)


@settings(max_examples=100, deadline=None)
@given(programs(), factors)
def test_everything_keeps_its_seconds(program: PhysicalProgram, factor: float) -> None:
    slowed = apply(program, retimed(program, factor))
    before, after = program.clip.step_seconds, slowed.clip.step_seconds
    half, end = after / 2 + 1e-9, slowed.clip.seconds
    for old, new in zip(program.event.actions, slowed.event.actions, strict=True):
        length = duration_of(old) * before
        if old.when is not None:
            assert new.when is not None
            assert new.when.delay * after == pytest.approx(old.when.delay * before, abs=half)
            if old.when.timeout is not None:
                assert new.when.timeout is not None
                seconds = old.when.timeout * before
                assert new.when.timeout * after == pytest.approx(seconds, abs=half)
            least = max(length, after)
            assert duration_of(new) * after == pytest.approx(least, abs=half)
            continue
        start = min(old.start_step * before, end - after)
        assert new.start_step * after == pytest.approx(start, abs=half)
        assert new.start_step + duration_of(new) <= slowed.clip.steps
        if not hasattr(old, "duration"):
            continue
        if old.start_step + duration_of(old) == program.clip.steps:
            # What lasted to the end lasts to the end.
            assert new.start_step + duration_of(new) == slowed.clip.steps
        else:
            # A start and an end that are both rounded may be a step apart.
            left = end - new.start_step * after
            whole = max(min(length, left), after)
            assert duration_of(new) * after == pytest.approx(whole, abs=2 * half)


@settings(max_examples=50, deadline=None)
@given(programs(), factors)
def test_windows_of_the_contract_keep_their_seconds(
    program: PhysicalProgram, factor: float
) -> None:
    slowed = apply(program, retimed(program, factor))
    old, new = program.contract.statements[0], slowed.contract.statements[0]
    for field in ("from_step", "to_step"):
        seconds = min(getattr(old, field) * program.clip.step_seconds, slowed.clip.seconds)
        found = getattr(new, field) * slowed.clip.step_seconds
        assert found == pytest.approx(seconds, abs=slowed.clip.step_seconds / 2 + 1e-9)


def test_the_window_of_a_condition_keeps_its_seconds() -> None:
    when = {
        "kind": "when",
        "statement": {"id": "far", "kind": "moves", "subject": "ball", "distance": 0.1,
                      "from_step": 100, "to_step": 200},
    }  # fmt: skip
    push = {
        "operator": "ApplyForce", "id": "push", "name": "ball", "duration": 5,
        "force": [1, 0, 0], "when": when,
    }  # fmt: skip
    program = PhysicalProgram.model_validate(
        {"scene": {"objects": [{"name": "ball"}]}, "event": {"actions": [push]}}
    )
    # Frames of 30 ms in three steps of 10 ms, then of 15 ms in two of 7.5 ms.
    for factor in (0.75, 0.375, 2.0):
        slowed = apply(program, retimed(program, factor))
        (action,) = slowed.event.actions
        assert isinstance(action.when, When)
        statement, step = action.when.statement, slowed.clip.step_seconds
        assert statement.from_step is not None
        assert statement.to_step is not None
        for found, before in ((statement.from_step, 100), (statement.to_step, 200)):
            seconds = min(before * program.clip.step_seconds, slowed.clip.seconds)
            assert found * step == pytest.approx(seconds, abs=step / 2 + 1e-9)


@settings(max_examples=50, deadline=None)
@given(programs(), factors)
def test_the_edits_go_together_and_can_be_taken_back(
    program: PhysicalProgram, factor: float
) -> None:
    slowed, back = apply_with_inverse(program, retimed(program, factor))
    assert apply(slowed, back) == program


@settings(max_examples=50, deadline=None)
@given(programs())
def test_the_factor_that_it_has_changes_nothing(program: PhysicalProgram) -> None:
    assert retimed(program, program.clip.time_factor) == ()


def test_to_a_quarter_and_back_is_where_it_began() -> None:
    """A schedule that fits into the quarter comes back step by step."""
    program = PhysicalProgram.model_validate(
        {
            "scene": {"objects": [{"name": "ball"}]},
            "event": {
                "actions": [
                    {"operator": "ApplyForce", "id": "push", "name": "ball", "start_step": 4,
                     "duration": 12, "force": [1, 0, 0]},
                    {"operator": "FixObject", "id": "hold", "name": "ball", "start_step": 20,
                     "duration": 50},
                    {"operator": "SetVelocity", "id": "go", "name": "ball", "start_step": 70,
                     "velocity": [1, 0, 0]},
                ]
            },
        }
    )  # fmt: skip
    slow = apply(program, retimed(program, 0.25))
    assert slow.clip.time_factor == 0.25
    back = apply(slow, retimed(slow, 1.0))
    assert back == program


@pytest.mark.parametrize("factor", [0.25, 0.5, 1.0, 2.0, 4.0])
def test_quarters_keep_the_control_step(factor: float) -> None:
    """Whole steps per frame come first, so that nothing has to be rounded."""
    clip = clip_at(PLAIN, factor)
    assert clip.step_seconds == pytest.approx(PLAIN.step_seconds)
    assert clip.steps_per_frame == round(PLAIN.steps_per_frame * factor)


def test_what_is_held_first_is_let_go_sooner_and_all_that_follows_with_it() -> None:
    hold = {"id": "hold", "operator": "FixObject", "name": "ball", "duration": 40}
    force = {"operator": "ApplyForce", "force": [1, 0, 0], "duration": 10}
    push = {"id": "push", "name": "ball", "start_step": 60} | force
    program = PhysicalProgram.model_validate(
        {"scene": {"objects": [{"name": "ball"}]}, "event": {"actions": [hold, push]}}
    )
    assert wait_of(program) == pytest.approx(0.4)
    sooner = apply(program, retimed(program, 1.0, skip=0.3))
    first, second = sooner.event.actions
    assert sooner.clip == program.clip
    assert (duration_of(first), second.start_step, duration_of(second)) == (10, 30, 10)
