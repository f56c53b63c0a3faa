"""The checklist in words: figures as one says them, one line where two clauses ask the same."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.contract.view.basics import VIEW_CODES
from physagent_studio.program import (
    Clause,
    PhysicalProgram,
    SceneObject,
    SceneState,
    SetField,
    apply,
)
from physagent_studio.program.contract import AllOf, AnyOf, Before, Contract
from physagent_studio.program.scene.state import Sphere
from physagent_studio.program.statements import Contacts, Topples
from physagent_studio.program.text.document import load_program
from physagent_studio.program.timing import retimed
from physagent_studio.records import (
    Assessment,
    Check,
    Criterion,
    Decision,
    LoopState,
    Proposal,
    Round,
)
from physagent_studio.records.judgement import CRITERIA
from physagent_studio.session import Store
from physagent_studio.studio.panels.checklist import _lines as compared_lines
from physagent_studio.studio.panels.checklist import checklist_of, demands_of, merged, viewed
from physagent_studio.studio.panels.rounds import (
    HISTORY,
    asked_about,
    decided_words,
    is_gentler,
    state_of,
)
from physagent_studio.studio.panels.rounds import (
    _changes as changes_of,
)
from physagent_studio.studio.panels.words import (
    UNSEEN,
    criterion_row,
    edit_row,
    figure,
    speaker,
    unseen,
    without_paths,
)
from physagent_studio.workbench import Snapshot, Workbench, commands


def _check(**more: Any) -> Check:
    base: dict[str, Any] = {
        "id": "s1", "text": "ball touches cube: no", "ok": False, "measured": None,
        "threshold": 0.0, "unit": "m", "margin": -0.5, "kind": "contacts",
    }  # fmt: skip
    return Check(**(base | more))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"measured": -0.12}, "misses by 0.12 m"),
        ({"measured": -0.12, "ok": True}, "0.12 m away"),
        ({"measured": -1e-4}, "misses by 0.1 mm"),
        ({"measured": -0.00823, "ok": True}, "8.23 mm away"),
        ({"measured": 0.141, "ok": True, "kind": "stops_before"}, "0.141 m to spare"),
        ({"measured": 0.05, "ok": True, "kind": "leaves"}, "0.05 m away"),
        ({"measured": 0.0}, ""),
        ({"measured": None}, ""),
        ({"measured": 0.33, "ok": True, "unit": "s", "kind": "before"}, "0.33 s earlier"),
        ({"measured": -0.2, "unit": "s", "kind": "before"}, "0.2 s too late"),
        (
            {"measured": 0.063, "threshold": 0.05, "unit": "m/s",
             "text": "ball ends at a speed of 0.063 m/s ≤ 0.05 m/s: no"},
            "0.063 m/s (at most 0.05 m/s)",
        ),
        ({"measured": 580.0, "threshold": 90.0, "unit": "°", "ok": True}, "580°"),
        ({"measured": -0.4, "threshold": 0.03}, "−0.4 m"),
        ({"measured": 9.9e-10, "threshold": 0.05, "unit": "m/s", "ok": True}, "0 m/s"),
    ],
)  # fmt: skip
def test_figures_in_words(more: dict[str, Any], words: str) -> None:
    assert figure(_check(**more)) == words


def test_a_bound_that_the_statement_names_is_not_repeated() -> None:
    check = _check(measured=0.01, threshold=0.05, text="ball moves 0.01 m ≥ 0.05 m: no")
    assert figure(check, "ball moves (by at least 0.05 m)") == "0.01 m"


def test_what_two_clauses_ask_alike_stands_once() -> None:
    names = ("ball", "block", "cube")
    objects = tuple(SceneObject(name=name, shape=Sphere(radius=0.1)) for name in names)
    program = PhysicalProgram(
        scene=SceneState(objects=objects),
        contract=Contract(
            clauses=(Clause(id="c1", text="passes it"), Clause(id="c2", text="hits only that")),
            statements=(
                Contacts(id="s1", clause="c1", subject="ball", other="block", negated=True),
                Contacts(id="s2", clause="c2", subject="ball", other="block", negated=True),
                Contacts(id="s3", clause="c2", subject="ball", other="cube"),
            ),
        ),
    )
    same = {"text": "ball does not touch block: no", "measured": 0.0}
    checks = (
        _check(id="s1", clause="c1", **same),
        _check(id="s2", clause="c2", **same),
        _check(id="s3", clause="c2", text="ball touches cube: yes", ok=True),
        _check(id="part", text="ball touches cube: yes", ok=True, demanded=False),
        _check(id="energy", text="energy: yes", ok=True, always_on=True),
    )
    rows = checklist_of(checks, program)
    assert [row["id"] for row in rows] == ["s1", "s3", "part", "energy"]
    assert rows[0]["clause"] == "passes it"
    assert rows[0]["also"] == ["hits only that"]
    assert rows[1]["also"] == []
    assert [check.id for check in demands_of(checks)] == ["s1", "s3"]
    assert [first.id for first, _ in merged(checks)] == ["s1", "s3", "part", "energy"]


def test_what_an_event_is_judged_by_is_said_in_plain_words() -> None:
    rows = [criterion_row(Criterion(name=one, ok=False, reason="it slides")) for one in CRITERIA]
    assert all(row["name"] not in CRITERIA for row in rows)
    assert rows[-1] == {
        "name": "Do things turn, tip and bend as they should?", "ok": False, "reason": "it slides",
    }  # fmt: skip
    seen = criterion_row(Criterion(name=CRITERIA[0], ok=False, reason="short"), seen_only=True)
    assert seen["name"] == "Can a viewer see it well?"


@pytest.mark.parametrize(
    ("rule", "figures", "said"),
    [
        ("fills", (0.2, 0.45), "too short to see"),
        ("fills", (0.98, 0.9), "not over when the clip ends"),
        ("pace.ball", (0.09, 0.04), "too fast to follow"),
        ("something_new", (0.0, 1.0), "not well seen"),
    ],
)
def test_what_a_viewer_cannot_see_is_said(
    rule: str, figures: tuple[float, float], said: str
) -> None:
    measured, threshold = figures
    one = _check(id=f"view.{rule}", kind="view", measured=measured, threshold=threshold)
    held = _check(id="view.calm", kind="view", ok=True)
    assert unseen((held, one)) == said
    assert unseen((held,)) == ""


def test_every_rule_of_the_view_has_its_words() -> None:
    assert set(VIEW_CODES) <= set(UNSEEN)


def test_what_serves_another_demand_is_folded_under_it() -> None:
    names = ("ball", "block", "cube")
    objects = tuple(SceneObject(name=name, shape=Sphere(radius=0.1)) for name in names)
    statements = (
        Contacts(id="block", subject="ball", other="block"),
        Contacts(id="cube", subject="ball", other="cube"),
        AnyOf(id="any", of=("block", "cube")),
        Topples(id="falls", subject="cube"),
        Before(id="first", first="any", second="falls"),
        AllOf(id="all", of=("first",)),
    )
    program = PhysicalProgram(
        scene=SceneState(objects=objects), contract=Contract(statements=statements)
    )
    served = program.contract.serving
    checks = tuple(
        _check(id=one.id, text=f"{one.id}: yes", ok=True, demanded=one.id not in served)
        for one in statements
    )
    rows = {row["id"]: row for row in checklist_of(checks, program)}
    assert [name for name, row in rows.items() if not row["folded"]] == ["all"]
    # What is made of one other alone is not unfolded twice.
    assert rows["all"]["parts"] == ["any", "falls"]
    assert rows["any"]["parts"] == ["block", "cube"]
    assert rows["block"]["parts"] == []
    assert rows["all"]["text"] == "(ball touches block or cube), before cube topples"


@pytest.mark.parametrize(
    ("text", "said", "figures"),
    [
        ("red_ball is in the picture: at least 93 % of it: yes",
         "red_ball is in the picture", "at least 93 % of it"),
        ("red_ball is in the picture: no, from frame 8 on less than half of it",
         "red_ball is in the picture", "from frame 8 on less than half of it"),
        ("red_ball moves so that an eye can follow: 12.5 % of the width per frame ≤ 4 %: no",
         "red_ball moves so that an eye can follow", "12.5 % of the width per frame (at most 4 %)"),
        ("the motion fills 9 % of the clip ≥ 45 %: no",
         "the motion fills 9 % of the clip", "less than 45 %"),
        ("the motion fills 59 % of the clip: yes", "the motion fills 59 % of the clip", ""),
        ("car rolls along its own axis: 3° off ≤ 20°, tilted by 2°: yes",
         "car rolls along its own axis", "3° off (at most 20°), tilted by 2°"),
        ("cube and table overlap by 0.027 mm ≤ 2.4 mm: yes",
         "cube and table overlap by 0.027 mm", ""),
        ("energy that nothing put in: 0 J ≤ 0.006 J: yes",
         "energy that nothing put in", "0 J (at most 0.006 J)"),
        ("the run stays stable: no, step 12: ball flies off",
         "the run stays stable", "ball flies off"),
        ("car is at rest at the end: no", "car is at rest at the end", ""),
    ],
)  # fmt: skip
def test_what_a_viewer_sees_in_words(text: str, said: str, figures: str) -> None:
    assert viewed(_check(kind="view", text=text, ok="yes" in text)) == (said, figures)


def test_the_checklist_has_three_groups() -> None:
    ball = SceneObject(name="red_ball", shape=Sphere(radius=0.1))
    program = PhysicalProgram(scene=SceneState(objects=(ball,)))
    checks = (
        _check(id="s1"),
        _check(id="energy", kind="energy", ok=True, always_on=True),
        _check(
            id="view.calm", kind="view", always_on=True,
            text="nothing stirs before its time: no, red_ball moves by 3.2 px",
        ),
    )  # fmt: skip
    rows = checklist_of(checks, program)
    assert [row["group"] for row in rows] == ["demand", "physics", "view"]
    assert rows[2]["measured"] == "red ball moves by 3.2 px"
    # What went wrong repeats a check as it was measured; so it can be told from news.
    assert rows[2]["told"] == checks[2].text
    assert demands_of(checks) == [checks[0]]


@pytest.mark.parametrize(
    ("factor", "kind", "words"),
    [("easing", "skip", "kept as it was"), ("easing", "accept", "accepted"),
     ("pace", "skip", "skipped")],
)  # fmt: skip
def test_a_gentler_way_is_no_repair(factor: str, kind: Any, words: str) -> None:
    proposal = Proposal(id="p", hunks=(), rationale="", factor=factor, confidence=0.9)
    decision = Decision(kind=kind, author="person", at="")
    item = Round.model_construct(proposal=proposal, decision=decision)
    assert is_gentler(item.proposal) == (factor == "easing")
    assert decided_words(item) == words


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory, shared_scenes: None) -> tuple[Snapshot, Path]:
    """A case that was opened, looked at and not run yet, and its workspace."""
    root = tmp_path_factory.mktemp("demo")
    workbench = Workbench(Store(root), evidence=False)
    workbench.post(commands.OpenCase(assets_dir() / "demo", "only_the_cube"))
    assert workbench.wait(120)
    opened = workbench.snapshot()
    workbench.close()
    return opened, root


def test_a_scene_that_matches_is_no_failed_event(demo: tuple[Snapshot, Path]) -> None:
    """What everybody sees first."""
    opened, _ = demo
    assert opened.state.phase == "simulate"
    found = state_of(opened)
    assert [one["verdict"] for one in found["rounds"]] == ["open"]
    assert found["shown"]["stage"] == "reconstruction"
    assert found["shown"]["machine"] is True
    assert all(one["text"] and not one["measured"] for one in found["checks"])


def test_a_round_that_waits_for_my_verdict_has_none_yet(
    demo: tuple[Snapshot, Path], tmp_path: Path
) -> None:
    store = Store(shutil.copytree(demo[1], tmp_path / "mine"))
    workbench = Workbench(store, evidence=False)
    opening = commands.OpenSession(store.list()[0].id)
    for command in (opening, commands.TakeRole("verifier"), commands.ForkFrom("r1")):
        workbench.post(command)
    assert workbench.wait(60)
    waiting = state_of(workbench.snapshot())
    assert (waiting["turn"], waiting["rounds"][0]["verdict"]) == ("verifier", "open")
    workbench.post(commands.OverruleVerdict(False, "the ball is elsewhere"))
    assert workbench.wait(60)
    refused = state_of(workbench.snapshot())
    assert (refused["turn"], refused["rounds"][0]["verdict"]) == ("", "failed")
    assert "the ball is elsewhere" in refused["proposal"]["question"]
    workbench.close()


@pytest.mark.parametrize(
    ("quantity", "unit"), [("value", "N"), ("acceleration", "m/s²"), ("target_speed", "m/s")]
)
def test_a_strength_is_changed_in_the_unit_of_its_vector(quantity: str, unit: str) -> None:
    program = load_program(
        "scene: {objects: [{name: ball, shape: {kind: sphere, radius: 0.1}}]}\n"
        "event: {actions: [{operator: ApplyForce, id: kick, name: ball, start_step: 0, duration: 5,"
        f" force: {{magnitude: 0.3, direction: right, quantity: {quantity}}}}}]}}\n"
    )
    edit = SetField(path="event.actions.kick.force.magnitude", value=0.4)
    assert edit_row(edit, program)["unit"] == unit


@pytest.mark.parametrize(
    ("path", "value", "what", "before", "after"),
    [
        ("grounding.candidate", 2, "ball · mask", "number 1", "number 3"),
        ("shape", None, "ball · shape", "kind sphere, radius 0.1", "found anew"),
        ("position", None, "ball · position", "(0.000782, 0, 0)", "found anew"),
        (
            "grounding",
            {"points": [{"x": 1, "y": 2}, {"x": 3, "y": 4, "label": 0}], "box": [0, 0, 9, 9],
             "candidate": 1},
            "ball · marks in the photo", "mask 1", "1 click, 1 click outside, a box, mask 2",
        ),
    ],
)  # fmt: skip
def test_what_is_read_off_the_photo_again_is_said_in_words(
    path: str, value: Any, what: str, before: str, after: str
) -> None:
    program = load_program(
        "scene: {objects: [{name: ball, shape: {kind: sphere, radius: 0.1},"
        " position: [7.82e-4, 0, 0]}]}"
    )
    row = edit_row(SetField(path=f"scene.objects.ball.{path}", value=value), program)
    assert (row["what"], row["before"], row["after"]) == (what, before, after)
    assert row["fixed"]  # no field to type a number in
    rubbed = edit_row(SetField(path="scene.objects.ball.friction", value=0.9), program)
    assert (rubbed["before"], rubbed["after"]) == ("its material's", "0.9")
    assert "fixed" not in rubbed


def test_a_question_about_a_thing_in_the_photo_leads_to_it() -> None:
    marked = "grounding: {points: [{x: 1, y: 2}]}"
    program = load_program(
        f"scene: {{objects: [{{name: can, {marked}}}, {{name: can_two, {marked}}}, {{name: cup}}]}}"
    )
    judged = Assessment.model_construct(stage="reconstruction")
    head = Round.model_construct(program=program, assessment=judged)

    def about(question: str) -> dict[str, str] | None:
        asked = Proposal(
            id="p", hunks=(), rationale="", factor="none", confidence=0, question=question
        )
        return asked_about(asked, head)

    assert about("Can_two is too small. Can you click inside can_two?") == {
        "kind": "object", "name": "can_two",
    }  # fmt: skip
    assert about("Where is the cup?") is None  # nobody has marked it, and nothing was found for it
    assert about("") is None


def test_names_are_spoken_at_the_start_of_a_sentence_too() -> None:
    program = load_program("scene: {objects: [{name: blue_pencil}]}")
    assert (
        speaker(program)("Blue_pencil is near blue_pencil.") == "Blue pencil is near blue pencil."
    )


def test_shares_are_said_in_per_cent() -> None:
    speak = speaker(PhysicalProgram())
    assert speak("ball covers its mask with IoU 0.98") == "ball covers its mask to 98 %"
    assert speak("ball covers its mask with IoU 1") == "ball covers its mask to 100 %"


def test_moments_are_told_in_seconds_of_the_event() -> None:
    speak = speaker(PhysicalProgram())
    assert speak("no, from frame 8 on") == "no, from 0.32 s on"
    assert speak("what overlapped in frame 0") == "what overlapped at 0.00 s"


def test_a_message_names_a_field_as_a_person_does() -> None:
    assert without_paths("event.actions.push_ball.force.magnitude: too large") == (
        "push ball · strength: too large"
    )
    for plain in ("written to /home/me/scene.viser", "clip.mp4 is there", "the scene. Then"):
        assert without_paths(plain) == plain


def test_what_two_programs_do_not_share_is_told_without_paths() -> None:
    text = """
    scene: {objects: [{name: red_ball, shape: {kind: sphere, radius: 0.1}}]}
    event: {actions: [{operator: ApplyForce, id: push_red_ball, name: red_ball, start_step: 10,
      duration: 20, force: {magnitude: 2, direction: right}}]}
    """
    before = load_program(text)
    path = "event.actions.push_red_ball"
    edits = (SetField(path=f"{path}.force.magnitude", value=3.0),
             SetField(path=f"{path}.start_step", value=30))  # fmt: skip
    lines = [one["text"] for one in compared_lines(before, apply(before, edits))]
    assert lines == ["push red ball", "start: 0.1", "start: 0.3 s", "strength: 2", "strength: 3 N"]


def test_another_pace_is_one_change_of_a_round() -> None:
    before = load_program("scene: {objects: [{name: ball, shape: {kind: sphere, radius: 0.1}}]}")
    edits = retimed(before, 0.5)
    first = Round(id="r1", number=1, parent=None, program=before, author="person")
    second = Round(
        id="r2", number=2, parent="r1", program=apply(before, edits), author="person",
        origin=Decision(kind="accept", author="person", at="", edits=edits),
    )  # fmt: skip
    (told,) = changes_of(second, LoopState(rounds=(first, second)))
    assert (told["what"], told["before"], told["after"]) == ("pace", "1", "0.5")


def test_of_a_long_history_the_part_around_the_round_on_view_is_read(tmp_path: Path) -> None:
    program = load_program("scene: {objects: [{name: ball, shape: {kind: sphere, radius: 0.1}}]}")
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(program))
    assert workbench.wait(60)
    opened = workbench.snapshot().session_id
    workbench.post(commands.OpenProgram(program))
    assert workbench.wait(60)
    session = workbench.store.open(opened or "")
    rounds = tuple(
        Round(id=f"r{n}", number=n, parent=f"r{n // 2}" if n > 1 else None, program=program,
              author="person")
        for n in range(1, 2001)
    )  # fmt: skip
    session.save(LoopState(rounds=rounds, head="r1500", phase="done"), checkpoint="long")
    session.close()
    workbench.post(commands.OpenSession(opened or ""))
    assert workbench.wait(60)
    found = state_of(workbench.snapshot())
    assert len(found["rounds"]) == HISTORY
    assert sum(found[side]["count"] for side in ("before", "after")) == 2000 - HISTORY
    assert any(one["head"] for one in found["rounds"])
    read = [one for one in workbench.snapshot().state.rounds if type(one) is Round]
    assert len(read) < 2 * HISTORY
    # What lies beyond is reached step by step.
    workbench.post(commands.ShowRound(found["after"]["id"]))
    assert workbench.wait(60)
    assert any(one["shown"] for one in state_of(workbench.snapshot())["rounds"])
    workbench.close()
