"""Horizon, size and parts of supports in a case, and annotations laid over it."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import annotated, load_case
from physagent_studio.program.scene.state import Scale

CASE = """\
image: input.png
objects:
  car: {points: [[20, 20, 1]]}
supports:
  ramp: {points: [[30, 30, 1]]}
landmarks:
  line: {kind: line, points: [[1, 30], [60, 30]]}
events:
  rolls: The car rolls.
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    cv2.imwrite(str(tmp_path / "input.png"), np.full((48, 64, 3), 90, np.uint8))
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


def with_more(folder: Path, more: str) -> Path:
    (folder / "case.yaml").write_text(CASE + more)
    return folder


def over(folder: Path, text: str) -> Path:
    (folder / "note.yaml").write_text(text)
    return folder / "note.yaml"


@pytest.mark.parametrize(
    ("horizon", "row", "roll"),
    [
        ("-120.5", -120.5, 0.0),
        # It falls to the right: the camera was turned to the left.
        ("[[4, 10], [60, 24]]", 17.0, -math.degrees(math.atan2(14, 56))),
        ("[[60, 24], [4, 10]]", 17.0, -math.degrees(math.atan2(14, 56))),
        # Clicks side by side, and nearly level ones, tell nothing of a tilt.
        ("[[30, 10], [34, 12]]", 11.0, 0.0),
        ("[[0, 20], [63, 20.2]]", 20.1, 0.0),
        # Two edges that meet in (64, 8), right of the picture's middle.
        ("[[0, 40], [32, 24], [0, 8], [20, 8]]", 8.0, 0.0),
    ],
)
def test_a_horizon_is_a_row_two_clicks_or_two_edges(
    folder: Path, horizon: str, row: float, roll: float
):
    case = load_case(with_more(folder, f"horizon: {horizon}\n"))
    assert case.horizon == pytest.approx(row, abs=0.01)
    assert case.roll == pytest.approx(roll, abs=1e-3)


def test_nothing_stated_is_open(folder: Path):
    case = load_case(folder)
    assert case.horizon is None
    assert case.scale == Scale()
    assert case.supports[0].grounding.marks == ()


def test_a_size_names_an_object(folder: Path):
    case = load_case(with_more(folder, "scale: {reference: car, metres: 0.11}\n"))
    assert case.scale == Scale(reference="car", metres=0.11, source="given")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("horizon: [[4, 10], [4, 20]]\n", "horizon must be a row, two clicks"),
        ("horizon: [[0, 10], [30, 10], [0, 20], [30, 20]]\n", "horizon must be a row"),
        ("horizon: [[4, 10], [99, 20]]\n", "the click (99, 20) lies outside the picture"),
        ("horizon: [[20, 0], [36, 40]]\n", "tilted by 68°; at most 45°"),
        ("horizon: .nan\n", "is not finite"),
        ("horizon: 9000\n", "too far from the picture"),
        ("horizon: [[4, 10, 1]]\n", "a click must be [x, y]"),
        ("scale: {reference: bus, metres: 1}\n", "known: car"),
        ("scale: {reference: car}\n", "None is no number"),
        ("scale: {reference: car, metres: 0}\n", "0 m is no size of a thing"),
        ("scale: {reference: car, meters: 1}\n", "did you mean 'metres'?"),
        ("scale: 0.2\n", "scale must be {reference: name, metres: size}"),
    ],
)
def test_one_sentence_with_the_line(folder: Path, more: str, said: str):
    with pytest.raises(InputError) as error:
        load_case(with_more(folder, more))
    assert said in str(error.value)
    assert "case.yaml, line 1" in str(error.value)
    assert "\n" not in str(error.value)


def test_marks_keep_their_part_and_order(folder: Path):
    note = over(
        folder,
        "supports:\n"
        "  ramp: {toe: [[50, 40], [48, 36]], top: [20, 20], end: [5, 20]}\n"
        "  table: {top: [[1, 2], [30, 2], [30, 20]], foot: [1, 40]}\n"
        "  back_wall: {foot: [[1, 5], [60, 5]]}\n",
    )
    case = annotated(load_case(folder), note)
    ramp, table, wall = case.supports
    assert ramp.grounding.marked("toe") == ((50, 40), (48, 36))
    assert ramp.grounding.marked("end") == ((5, 20),)
    assert ramp.grounding.points == load_case(folder).supports[0].grounding.points
    assert table.grounding.marked("top") == ((1, 2), (30, 2), (30, 20))
    assert wall.grounding.marked("foot") == ((1, 5), (60, 5))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("supports: {ramp: {toe: [5, 5]}}\n", "'ramp' has 0 clicks for top: a ramp takes toe"),
        ("supports: {table: {top: [[1, 1], [5, 5]]}}\n", "'table' has 2 clicks for top"),
        ("supports: {table: {toe: [1, 1]}}\n", "a level support takes top"),
        ("supports: {wall: {foot: [1, 1]}}\n", "a wall takes foot (two clicks"),
        ("supports: {floor: {top: [1, 1]}}\n", "the ground takes none"),
        ("supports: {ramp: {toe: [[5, 5], 7], top: [1, 1]}}\n", "a click must be [x, y]"),
        ("supports: {ramp: {toe: [], top: [1, 1]}}\n", "needs a click [x, y]"),
        ("objects: {cat: {box: [1, 1, 9, 9]}}\n", "the case has no object 'cat' (known: car)"),
        ("landmarks: {car: {kind: point, points: [[1, 1]]}}\n", "something else that is called"),
        ("landmarks: {end: {kind: point, points: [[1, 1]], on: sofa}}\n", "known: car, ramp"),
        ("events: {jumps: The car jumps.}\n", "'events' is not known here"),
        ("actions: []\n", "'actions' is not known here"),
        ("horizon: [[4, 10], [99, 20]]\n", "outside the picture"),
    ],
)
def test_an_annotation_holds_clicks_that_fit(folder: Path, text: str, said: str):
    note = over(folder, text)
    with pytest.raises(InputError) as error:
        annotated(load_case(folder), note)
    assert said in str(error.value)
    assert "note.yaml, line 1" in str(error.value)


def test_clicks_are_added_and_boxes_replaced(folder: Path):
    note = over(
        folder,
        "horizon: 5\n"
        "scale: {reference: car, metres: 0.1}\n"
        "objects: {car: {points: [[21, 21, 0]], box: [10, 10, 30, 30]}}\n"
        "landmarks:\n"
        "  line: {kind: line, points: [[2, 31], [61, 31]]}\n"
        "  goal: {kind: opening, points: [[2, 31], [61, 31], [61, 5], [2, 5]], on: ramp}\n",
    )
    before = load_case(folder)
    case = annotated(before, note)
    assert [c.label for c in dict(case.objects)["car"].points] == [1, 0]
    assert dict(case.objects)["car"].box == (10, 10, 30, 30)
    assert case.horizon == 5
    assert [m.name for m in case.landmarks] == ["line", "goal"]
    assert case.landmarks[0].pixels == ((2, 31), (61, 31))
    assert (case.prompt, case.events, case.image_hash) == (
        before.prompt,
        before.events,
        before.image_hash,
    )


def test_what_an_annotation_leaves_out_stays(folder: Path):
    with_more(folder, "horizon: 7\nscale: {reference: car, metres: 0.2}\n")
    case = annotated(load_case(folder), over(folder, "objects: {car: {box: [1, 1, 9, 9]}}\n"))
    assert case.horizon == 7
    assert case.scale.metres == 0.2
