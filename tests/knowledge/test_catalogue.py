"""The tables of kinds and paces are whole, and are found by the words that people use."""

from collections import Counter

import pytest

from physagent_studio.agent.rules.contract.intents import ACTIVE
from physagent_studio.knowledge import kind_of, kinds, pace_of, paces
from physagent_studio.language.tokens import vocabulary as v

STATES = {"withdrawn", "end", "wind"}
"""What sets things going without a speed of its own: a support taken away, an end, the air."""


def test_no_word_stands_for_two_kinds():
    words = Counter(word for kind in kinds() for word in (kind.name, *kind.synonyms))
    assert [word for word, count in words.items() if count > 1] == []
    assert len(kinds()) >= 60
    assert len({pace.sense for pace in paces()}) == len(paces())


def test_what_runs_on_wheels_faces_along_an_axis_or_says_that_it_does_not():
    wheeled = [kind for kind in kinds() if kind.wheels]
    assert len(wheeled) >= 25
    assert {kind.wheels for kind in wheeled} == {"long_axis", "short_axis", "any_way"}
    assert not any(kind.wheels for kind in kinds() if kind.name in ("ball", "can", "box", "sled"))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("toy_car", "toy_car"), ("red_toy_cars", "toy_car"), ("car_2", "car"), ("buses", "bus"),
        ("office_chair", "office_chair"), ("red_office_chair_1", "office_chair"),
        ("wooden_chair", "chair"), ("roller_skates", "roller_skate"), ("car_box", "box"),
        ("trash_can", "bin"), ("knives", "knife"), ("leaves", "leaf"), ("gadget", None),
        ("scooter", "scooter"), ("batteries", "battery"), ("dummies", None), ("", None),
    ],
)  # fmt: skip
def test_a_name_is_known_by_its_last_words(name: str, kind: str | None):
    found = kind_of(name)
    assert (None if found is None else found.name) == kind


def test_every_sense_of_motion_has_a_pace():
    told = {verb.sense for verb in v.VERBS.values() if verb.kind in ("move", "act", "goto")}
    told |= {*v.COMBINED.values(), *v.WITH_OBJECT.values(), *ACTIVE} - STATES
    states = {verb.sense for verb in v.VERBS.values() if verb.kind not in ("move", "act", "goto")}
    missing = {s for s in told - states - STATES - {"lose"} if pace_of(s) is None}
    assert missing == set()


def test_slow_is_slower_and_fast_is_faster():
    for pace in paces():
        for unit in ("metres", "lengths"):
            slow, plain, fast = (getattr(getattr(pace, m), unit) for m in ("slow", "plain", "fast"))
            assert slow.usual < plain.usual < fast.usual, pace.sense
            assert slow.low <= plain.low <= fast.low, pace.sense
            assert slow.high <= plain.high <= fast.high, pace.sense
