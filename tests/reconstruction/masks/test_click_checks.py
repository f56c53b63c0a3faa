"""Clicks that make no sense are told in a sentence each; clicks that do are left alone."""

import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.synthetic import scene
from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState
from physagent_studio.reconstruction import reconstruct
from physagent_studio.reconstruction.masks import click_checks as grounds
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Candidate


def state_of(**clicks: tuple[float, float]) -> SceneState:
    objects = tuple(
        SceneObject(name=name, grounding=Grounding(points=(Click(x=x, y=y),)))
        for name, (x, y) in clicks.items()
    )
    return SceneState(objects=objects)


def findings(image: np.ndarray, state: SceneState) -> list[str]:
    said = [(item.name, item.grounding) for item in state.objects]
    offers = EmbeddedSegmenter().segment(image, said)
    masks = choose(offers, said, image.shape[:2])
    return [one.text for one in grounds.measure(state, image, masks)]


def middle(mask: np.ndarray) -> tuple[float, float]:
    rows, columns = np.nonzero(mask)
    return float(np.median(columns)), float(np.median(rows))


def test_a_click_on_bare_ground():
    drawn = scene(1)
    covered = np.any(list(drawn.masks.values()), axis=0)
    x, y = next((x, y) for x, y in ((60, 350), (600, 350), (600, 40)) if not covered[y, x])
    (text,) = findings(drawn.image, state_of(thing=(x, y)))
    assert text.startswith("nothing stands out where thing is clicked")


def test_two_names_for_one_thing():
    drawn = scene(0)
    mask = max(drawn.masks.values(), key=np.count_nonzero)
    rows, columns = np.nonzero(mask)
    y = float(np.median(rows))
    first, second = (float(np.percentile(columns, part)) for part in (30, 70))
    texts = findings(drawn.image, state_of(cup=(first, y), mug=(second, y)))
    assert texts == ["cup and mug are clicked on the same thing; take one name away"]


@pytest.mark.parametrize("seed", [0, 2])
def test_good_clicks_are_left_alone(seed):
    drawn = scene(seed)
    clicks = {name: middle(mask) for name, mask in drawn.masks.items() if mask.any()}
    assert grounds.measure(state_of(**clicks), drawn.image, drawn.masks) == []


def test_what_a_person_has_settled_is_not_asked():
    flat = np.full((120, 160, 3), 128, np.uint8)
    mine = Grounding(points=(Click(x=80, y=60),), settled=True)
    state = SceneState(objects=(SceneObject(name="fog", grounding=mine),))
    mask = np.zeros((120, 160), bool)
    mask[40:80, 60:100] = True
    assert grounds.measure(state, flat, {"fog": mask}) == []


def test_a_thing_that_loses_all_its_pixels_keeps_a_spot():
    """Two names, one thing: the second has no pixel left, and nothing breaks over it."""
    drawn = scene(0)
    mask = max(drawn.masks.values(), key=np.count_nonzero)
    x, y = middle(mask)
    full = (Candidate(mask, 1.0, ""),)
    said = [(o.name, o.grounding) for o in state_of(cup=(x, y), mug=(x + 6, y)).objects]
    chosen = choose({"cup": full, "mug": full}, said, mask.shape)
    assert all(np.count_nonzero(one) > 50 for one in chosen.values())
    assert not (chosen["cup"] & chosen["mug"]).any()


def test_a_thing_that_nobody_marked_is_named():
    drawn = scene(0)
    case = Case("x", drawn.image, "x", (), (), (), "The cup falls.")
    with pytest.raises(InputError, match="'cup' is not marked in the photo"):
        reconstruct(case, SceneState(objects=(SceneObject(name="cup"),)))


def test_two_boxes_are_two_things_even_where_they_look_alike():
    drawn = scene(0)
    mask = max(drawn.masks.values(), key=np.count_nonzero)
    rows, columns = np.nonzero(mask)
    left, right, top, bottom = columns.min(), columns.max(), rows.min(), rows.max()
    middle_row = (top + bottom) / 2

    def boxed(name, low, high):
        y = (low + high) / 2
        grounding = Grounding(
            box=(float(left), float(low), float(right), float(high)),
            points=(Click(x=float(np.median(columns)), y=float(y)),),
        )
        return SceneObject(name=name, grounding=grounding)

    upper, lower = boxed("upper", top, middle_row), boxed("lower", middle_row, bottom)
    state = SceneState(objects=(upper, lower))
    texts = [
        one.text for one in grounds.measure(state, drawn.image, {"upper": mask, "lower": mask})
    ]
    assert not any("same thing" in text for text in texts)
