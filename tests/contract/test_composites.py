"""Composites, negation, windows, and runs that end early."""

import numpy as np
import pytest

from physagent_studio.contract import MEASURES, met

MOVES = {"id": "moves", "kind": "moves", "subject": "ball", "distance": 0.3}
FALLS = {"id": "falls", "kind": "falls", "subject": "ball"}
TOUCHES = {"id": "touches", "kind": "contacts", "subject": "ball", "other": "cube"}


def by_id(checks):
    return {check.id: check for check in checks}


def test_all_of_is_the_worst_and_any_of_the_best(stage, time):
    stage.path("ball", x=time)
    checks = by_id(
        stage.checks(
            MOVES,
            FALLS,
            {"id": "all", "kind": "all_of", "of": ["moves", "falls"]},
            {"id": "any", "kind": "any_of", "of": ["moves", "falls"]},
            {"id": "none", "kind": "any_of", "of": ["moves", "falls"], "negated": True},
        )
    )
    assert not checks["all"].ok
    assert checks["all"].margin == checks["falls"].margin
    assert checks["any"].ok
    assert checks["any"].margin == checks["moves"].margin
    assert not checks["none"].ok


def test_parts_of_a_composite_are_marked_as_not_demanded(stage, time):
    stage.path("ball", x=time)
    checks = by_id(
        stage.checks(MOVES, FALLS, {"id": "any", "kind": "any_of", "of": ["moves", "falls"]})
    )
    assert not checks["falls"].demanded
    assert not checks["moves"].demanded
    assert checks["any"].demanded


def test_what_a_before_orders_is_demanded_unless_it_serves_itself(stage):
    order = {"id": "order", "kind": "before", "first": "moves", "second": "falls"}
    assert all(one.demanded for one in stage.checks(MOVES, FALLS, order))
    above = {"id": "any", "kind": "any_of", "of": ["order"]}
    marked = {one.id: one.demanded for one in stage.checks(MOVES, FALLS, order, above)}
    assert [marked[name] for name in ("moves", "falls", "order", "any")] == [
        False,
        False,
        False,
        True,
    ]


@pytest.mark.parametrize(("touch_at", "ok"), [(60, True), (20, False), (30, False)])
def test_before_compares_when_each_became_true(stage, time, touch_at, ok):
    stage.path("ball", x=1.001 * time).touch("ball", "cube", [touch_at])  # 0.3 m at step 30
    check = stage.checks(
        MOVES, TOUCHES, {"id": "order", "kind": "before", "first": "moves", "second": "touches"}
    )[2]
    assert check.ok is ok
    if touch_at == 60:
        assert check.measured == pytest.approx(0.3)


def test_before_fails_where_one_does_not_happen_and_more_so_the_farther_it_is(new_stage, time):
    order = {"id": "order", "kind": "before", "first": "moves", "second": "touches"}
    margins = []
    for beside in (1.0, 0.5, 0.3):
        stage = new_stage().path("ball", x=time, y=-beside)
        margins.append(stage.checks(MOVES, TOUCHES, order)[2].margin)
    late = new_stage().path("ball", x=time).touch("ball", "cube", [10])
    margins.append(late.checks(MOVES, TOUCHES, order)[2].margin)
    assert margins == sorted(margins)
    assert margins[-1] < 0


def test_negation_flips_the_margin(stage, time):
    stage.path("ball", x=time)
    plain = stage.check("moves", subject="ball", distance=0.3)
    negated = stage.check("moves", subject="ball", distance=0.3, negated=True)
    assert plain.ok
    assert not negated.ok
    assert negated.margin == -plain.margin


def test_no_statement_holds_together_with_its_opposite(stage, time):
    rng = np.random.default_rng(3)
    extras = {
        "contacts": {"other": "cube"},
        "rests_on": {"other": "floor"},
        "reaches": {"other": "floor"},
        "leaves": {"other": "floor"},
        "lands_in": {"landmark": "circle"},
        "passes_over": {"landmark": "line"},
        "stops_before": {"before": "cube"},
        "bounces": {"other": "cube"},
        "covers": {"other": "cube"},
        "side_of": {"other": "cube", "side": "behind"},
    }
    for _ in range(10):
        walk = np.cumsum(rng.normal(0, 0.02, (len(time), 3)), axis=0)
        stage.path("ball", *walk.T).turn("can", rng.normal(size=3), 200 * rng.random() * time)
        stage.touch("ball", "cube", rng.choice(100, 2))
        for kind in MEASURES:
            for subject in ("ball", "can"):
                fields = {"subject": subject, **extras.get(kind, {})}
                plain = stage.check(kind, **fields)
                negated = stage.check(kind, **fields, negated=True)
                assert plain.ok == (plain.margin >= 0)
                assert negated.ok == (negated.margin >= 0)
                assert not (plain.ok and negated.ok), kind
                assert plain.ok or negated.ok, kind  # all of this can be measured


def test_a_run_that_blew_up_proves_only_what_happened_before(stage, time):
    stage.path("ball", x=time).touch("ball", "cube", [20]).blow_up(50)
    assert stage.check("contacts", subject="ball", other="cube").ok
    assert stage.check("moves", subject="ball", distance=0.3).ok
    for kind, fields in (
        ("stays", {"subject": "can"}),
        ("upright", {"subject": "can"}),
        ("moves", {"subject": "ball", "distance": 0.8}),
        ("contacts", {"subject": "can", "other": "cube", "negated": True}),
    ):
        check = stage.check(kind, **fields)
        assert not check.ok, kind
        assert "the run ended at step 49" in check.text
    assert stage.check("stays", subject="can", to_step=30).ok


def test_numbers_that_are_not_finite_end_the_run(stage, time):
    path = np.where(time > 0.6, np.nan, time)
    stage.path("ball", x=path)
    checks = by_id(stage.checks({**MOVES, "distance": 0.5}, {**FALLS, "negated": True}))
    assert checks["moves"].ok
    assert not checks["falls"].ok
    assert not checks["physics.blow_up"].ok
    assert all(np.isfinite(check.margin) for check in checks.values())


def test_a_window_past_the_run_says_so(stage):
    check = stage.check("moves", subject="ball", from_step=400)
    assert not check.ok
    assert "outside the clip" in check.text


def test_met_speaks_of_the_run_so_far(stage, time):
    stage.path("ball", x=np.minimum(time, 0.5))
    program = stage.program({"id": "stop", "kind": "stops", "subject": "ball"})
    statement = program.contract.statements[0]
    assert met(statement, program, stage.rollout())
    stage.path("ball", x=time)
    assert not met(statement, program, stage.rollout())


@pytest.mark.parametrize(
    ("low", "high", "ok"), [(1, 1, True), (0, 1, True), (1, 3, True), (2, 3, False), (0, 0, False)]
)
def test_counting_which_of_several_hold(stage, time, low, high, ok):
    stage.path("ball", x=time)
    parts = [MOVES, FALLS, TOUCHES]
    names = [one["id"] for one in parts]
    count = {"id": "n", "kind": "count_of", "of": names, "low": low, "high": high}
    check = by_id(stage.checks(*parts, count))["n"]
    assert check.ok is ok
    assert "1 of 3" in check.text


def test_only_one_pin_is_a_count_that_a_search_can_follow(new_stage, time):
    """Two tip; the less the second tips, the better."""
    tips = [{"id": name, "kind": "topples", "subject": name} for name in ("can", "cube")]
    count = {"id": "only", "kind": "count_of", "of": ["can", "cube"], "low": 1, "high": 1}
    margins = []
    for second in (90, 60, 46, 20):
        stage = new_stage().turn("can", (1, 0, 0), 90 * time)
        stage.turn("cube", (1, 0, 0), second * time)
        margins.append(by_id(stage.checks(*tips, count))["only"].margin)
    assert margins == sorted(margins)
    assert margins[-2] < 0 < margins[-1]


def test_before_within_some_seconds(stage, time):
    stage.path("ball", x=1.001 * time).touch("ball", "cube", [60])
    order = {"id": "order", "kind": "before", "first": "moves", "second": "touches"}
    assert stage.checks(MOVES, TOUCHES, {**order, "within": 0.5})[2].ok
    assert not stage.checks(MOVES, TOUCHES, {**order, "within": 0.2})[2].ok
