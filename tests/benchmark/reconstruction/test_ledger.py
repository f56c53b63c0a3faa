import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.ledger import MEASURES, entry_of, plain_cut, results
from physagent_studio.benchmark.scenes import scene
from physagent_studio.errors import InputError
from physagent_studio.reconstruction.switches import at_work, without


def test_what_is_left_out_is_not_at_work_for_as_long_as_that() -> None:
    with without(["expected gain"]) as asked:
        assert not at_work("expected gain")
        assert at_work("variants")
        with without(["variants"]):
            assert not at_work("expected gain")
            assert not at_work("variants")
    assert at_work("expected gain")
    assert {"expected gain", "variants"} <= asked


def test_what_is_no_heuristic_cannot_be_left_out() -> None:
    with pytest.raises(InputError, match="no heuristic 'luck'"), without(["luck"]):
        pass


@pytest.mark.parametrize(
    ("seed", "way", "name"), [(1002, "click", "settled outline"), (1001, "box", "settled outline")]
)
def test_a_heuristic_that_is_left_out_changes_masks(seed: int, way: str, name: str) -> None:
    drawn = scene(seed)
    with_all, asked = results(seed, drawn, way)
    again, _ = results(seed, drawn, way)
    less, _ = results(seed, drawn, way, (name,))
    assert with_all == again
    assert name in asked
    assert with_all != less


def test_a_heuristic_stays_that_helps_often_and_clearly() -> None:
    keys = [(0, "click", str(k)) for k in range(8)]
    before = dict.fromkeys(keys, 0.5)
    alike = entry_of("expected gain", before, before)
    assert (alike.changed, alike.stays) == (0, False)
    rarely = entry_of("expected gain", before, dict.fromkeys(keys[:4], 0.4))
    assert (rarely.helped, rarely.stays) == (4, False)
    faintly = entry_of("expected gain", before, dict.fromkeys(keys, 0.495))
    assert (faintly.helped, faintly.stays) == (8, False)
    assert entry_of("expected gain", before, dict.fromkeys(keys[:6], 0.48)).stays
    worse = entry_of("expected gain", before, dict.fromkeys(keys, 0.6))
    assert (worse.hurt, worse.stays) == (8, False)


@pytest.mark.parametrize(("seed", "measure", "name"), [(1001, "background", "cast shadows")])
def test_a_rule_that_is_left_out_changes_the_background(seed, measure, name) -> None:
    own, drawn = MEASURES[measure], scene(seed)
    with_all, asked = own.results(seed, drawn, own.ways[0], ())
    less, _ = own.results(seed, drawn, own.ways[0], (name,))
    assert name in asked
    assert with_all != less
    assert own.results(seed, drawn, own.ways[0], ())[0] == with_all


@pytest.mark.slow
def test_bodies_are_held_against_the_things_that_were_drawn() -> None:
    own, drawn = MEASURES["bodies"], scene(1007)
    found, asked = own.results(1007, drawn, own.ways[0], ())
    assert "snug boxes" in asked
    assert len(found) == 2 * len(drawn.subjects)
    assert np.median(list(found.values())) > 0.7


def test_a_plain_cut_stays_in_its_box() -> None:
    drawn = scene(0)
    box = drawn.subjects[0].box.box
    assert box is not None
    found = plain_cut(drawn.image, box)
    rows, columns = found.nonzero()
    assert len(rows)
    assert columns.min() >= int(box[0])
    assert rows.max() <= int(box[3]) + 1
