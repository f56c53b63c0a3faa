"""Case folders: what is read, and one sentence for each thing that can be wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import case_from_image, load_case
from physagent_studio.program.scene.state import Click, Grounding, Slab

GOOD = """\
image: input.png
size: [64, 48]
objects:
  red ball:
    points:
    - [20, 20, 1]
    - [40.5, 2, 0]
  box:
    box: [30, 20, 50, 40]
supports:
  table:
    points: [[10, 40, 1]]
    material: stone
    shape: {kind: box, position: [0, 2, 0.2], size: [1, 1, 0.4]}
landmarks:
  goal line: {kind: line, points: [[1, 30], [60, 30]], on: table}
events:
  rolls: The red ball
    rolls over the line.
  stays: The box stays.
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    picture = np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "input.png"), picture)
    (tmp_path / "case.yaml").write_text(GOOD)
    return tmp_path


def test_a_whole_case(folder: Path):
    case = load_case(folder)
    assert case.image is not None
    assert case.image.shape == (48, 64, 3)
    assert len(case.image_hash) == 64
    assert [name for name, _ in case.objects] == ["red_ball", "box"]
    assert case.objects[0][1].points == (Click(x=20, y=20), Click(x=40.5, y=2, label=0))
    assert case.objects[1][1].box == (30, 20, 50, 40)
    (table,) = case.supports
    assert isinstance(table.shape, Slab)
    assert (table.material, table.source) == ("stone", "given")
    assert (case.landmarks[0].name, case.landmarks[0].on) == ("goal_line", "table")
    assert case.landmarks[0].pixels == ((1, 30), (60, 30))
    assert (case.event, case.prompt) == ("rolls", "The red ball rolls over the line.")


def test_event_by_name_and_file_by_path(folder: Path):
    case = load_case(folder / "case.yaml", "stays")
    assert (case.event, case.prompt) == ("stays", "The box stays.")


def edited(folder: Path, old: str, new: str) -> Path:
    text = (folder / "case.yaml").read_text()
    assert old in text
    (folder / "case.yaml").write_text(text.replace(old, new, 1))
    return folder


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("input.png", "none.png", r"case\.yaml, line 1: image 'none\.png' does not exist"),
        ("input.png", "../input.png", "lies outside the case folder"),
        ("input.png", "/etc/passwd", "lies outside the case folder"),
        ("input.png", "case.yaml", "case.yaml"),
        ("image: input.png", "picture: input.png", "'picture' is not known here"),
        ("[64, 48]", "[640, 48]", r"line 2: size is 640×48, but input\.png is 64×48"),
        ("[64, 48]", "[64]", r"size must be \[width, height\]"),
        ("[20, 20, 1]", "[64, 20, 1]", r"line 6: the click \(64, 20\) lies outside the picture"),
        ("[20, 20, 1]", "[20, -1, 1]", r"line 6: the click \(20, -1\) lies outside"),
        ("[20, 20, 1]", "[.nan, 20, 1]", "line 6: nan is not finite"),
        ("[20, 20, 1]", "[a, 20, 1]", "line 6: 'a' is no number"),
        ("[20, 20, 1]", "[20]", r"line 6: a point must be \[x, y, label\]"),
        ("[20, 20, 1]", "[20, 20, 2]", "line 6: a label is 1 .inside. or 0"),
        ("[20, 20, 1]", "[20, 20, 0]", "line 4: object 'red_ball' needs a click inside it"),
        ("box: [30, 20, 50, 40]", "box: [50, 20, 30, 40]", "line 9: a box is .*left before right"),
        ("box: [30, 20, 50, 40]", "box: [30, 20, 500, 40]", "line 9: the box must lie"),
        (
            "box: [30, 20, 50, 40]", "points: [[20, 20, 1]]",
            r"line 8: object 'box': \(20, 20\) is clicked for 'red_ball' too",
        ),
        ("  box:\n", "  red_ball:\n", "line 8: the name 'red_ball' is used twice"),
        ("  box:\n", "  red ball:\n", "line 8: 'red ball' stands here twice"),
        ("  table:\n", "  box:\n", "the name 'box' is used twice"),
        ("  box:\n", "  air:\n", "line 8: 'air' is a reserved name"),
        ("  box:\n", "  '!':\n", "line 8: '!' is no name"),
        ("on: table", "on: shelf", r"there is no support 'shelf' \(known: red_ball, box, table\)"),
        ("kind: line", "kind: circle", "kind must be one of point, line, area, opening"),
        ("material: stone", "material: unobtainium", "there is no material 'unobtainium'"),
        ("size: [1, 1, 0.4]}", "size: [1, 1, -4]}", "line 14: shape.size"),
        ("kind: box, pos", "kind: cone, pos", "line 14: shape"),
        ("points:\n    - [20", "point:\n    - [20", "did you mean 'points'"),
        ("stays: The box stays.", "stays:", "line 20: event 'stays' needs a sentence"),
    ],
)  # fmt: skip
def test_refusals_say_where(folder: Path, old: str, new: str, message: str):
    with pytest.raises(InputError, match=message) as caught:
        load_case(edited(folder, old, new))
    assert "\n" not in str(caught.value)


def test_unknown_event_lists_the_known(folder: Path):
    with pytest.raises(InputError, match=r"no event 'roll' .known: rolls, stays; did you mean 'ro"):
        load_case(folder, "roll")


def test_no_case_there(tmp_path: Path):
    with pytest.raises(InputError, match=r"has no case\.yaml"):
        load_case(tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        load_case(tmp_path / "nowhere")


def test_not_text_and_too_large(folder: Path):
    (folder / "case.yaml").write_bytes(b"\xff\xfe\x00image")
    with pytest.raises(InputError, match="no UTF-8"):
        load_case(folder)
    (folder / "case.yaml").write_text("a: " + "x" * 1_000_001)
    with pytest.raises(InputError, match="larger than"):
        load_case(folder)
    (folder / "case.yaml").write_text("- just\n- a list\n")
    with pytest.raises(InputError, match="a case is a mapping"):
        load_case(folder)


def test_picture_that_is_no_picture(folder: Path):
    (folder / "input.png").write_text("not a picture")
    with pytest.raises(InputError, match=r"input\.png"):
        load_case(folder)


def test_symbolic_link_out_of_the_folder(folder: Path, tmp_path_factory: pytest.TempPathFactory):
    outside = tmp_path_factory.mktemp("outside") / "secret.png"
    (folder / "input.png").rename(outside)
    (folder / "input.png").symlink_to(outside)
    with pytest.raises(InputError, match="lies outside the case folder"):
        load_case(folder)


def _clicked(x: float, y: float, label: Literal[0, 1] = 1) -> Grounding:
    return Grounding(points=(Click(x=x, y=y, label=label),))


def test_image_with_clicks(folder: Path):
    clicks = {"my ball": _clicked(20, 20)}
    case = case_from_image(folder / "input.png", " It rolls. ", clicks)
    assert (case.name, case.prompt) == ("input", "It rolls.")
    assert case.objects[0][0] == "my_ball"
    with pytest.raises(InputError, match="outside the picture"):
        case_from_image(folder / "input.png", "p", {"a": _clicked(99, 1)})
    with pytest.raises(InputError, match="prompt is empty"):
        case_from_image(folder / "input.png", " ", clicks)
    with pytest.raises(InputError, match="no object"):
        case_from_image(folder / "input.png", "p", {})
    with pytest.raises(InputError, match="neither a click inside"):
        case_from_image(folder / "input.png", "p", {"a": _clicked(9, 1, 0)})
    with pytest.raises(InputError, match=r"'b': \(9, 1\) is clicked for 'a' too"):
        case_from_image(folder / "input.png", "p", {"a": _clicked(9, 1), "b": _clicked(9, 1)})


def test_real_cases(cases_dir: Path):
    folders = sorted(path.parent for path in cases_dir.glob("*/case.yaml"))
    assert len(folders) >= 14
    for folder in folders:
        case = load_case(folder)
        assert case.objects
        assert case.prompt
        for name, prompt in case.events:
            assert load_case(folder, name).prompt == prompt


def test_image_with_a_box(folder: Path):
    boxed = Grounding(box=(4, 3, 30, 28))
    case = case_from_image(folder / "input.png", "It rolls.", {"ball": boxed})
    assert case.objects == (("ball", boxed),)
    with pytest.raises(InputError, match=r"object 'ball': the box must lie in the picture"):
        case_from_image(folder / "input.png", "p", {"ball": Grounding(box=(4, 3, 3000, 28))})


def test_a_box_drawn_a_little_beyond_the_picture_ends_there(folder: Path):
    drawn = Grounding(box=(-2, -1.5, 30, 28))
    case = case_from_image(folder / "input.png", "It rolls.", {"ball": drawn})
    assert case.objects == (("ball", Grounding(box=(0, 0, 30, 28))),)
