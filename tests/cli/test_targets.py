"""What the words of `--object` mean: clicks, boxes and names alone."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from physagent_studio.assets import assets_dir
from physagent_studio.cli.app import app
from physagent_studio.cli.marks import parse_objects
from physagent_studio.errors import InputError
from physagent_studio.program import Click, Grounding


def test_clicks_boxes_and_names() -> None:
    words = ("red  ball@10,20", "red ball@30,40,0", "box@9,8,3.5,2", "mug")
    assert parse_objects(words) == {
        "red_ball": Grounding(points=(Click(x=10, y=20), Click(x=30, y=40, label=0))),
        "box": Grounding(box=(3.5, 2, 9, 8)),
        "mug": Grounding(),
    }


def test_a_box_and_a_click_of_one_thing() -> None:
    both = Grounding(points=(Click(x=5, y=5),), box=(1, 2, 8, 9))
    assert parse_objects(("mug@1,2,8,9", "mug@5,5")) == {"mug": both}
    assert parse_objects(("mug@5,5", "mug", "mug@1,2,8,9")) == {"mug": both}


@pytest.mark.parametrize(
    "word",
    [
        *("@1,2", " ", "mug@", "mug@1", "mug@1,2,3,4,5", "mug@1,2,2", "mug@1,2,0.5", "mug@a,b"),
        *("mug@1,2,nan,9", "mug@inf,2", "mug@1,2,inf", "mug@1,,2", "mug 240,330"),
    ],
)
def test_anything_else_says_what_is_allowed(word: str) -> None:
    with pytest.raises(InputError, match=r"name@x,y.*name@x0,y0,x1,y1"):
        parse_objects((word,))


def test_one_box_for_one_thing() -> None:
    with pytest.raises(InputError, match="second box"):
        parse_objects(("mug@1,2,8,9", "mug@2,2,8,9"))


@pytest.mark.parametrize(
    ("word", "size"),
    [("mug@1,2,1,9", "0 px wide and 7 px high"), ("mug@3,2,1,2", "2 px wide and 0 px high")],
)
def test_an_empty_box_is_called_so(word: str, size: str) -> None:
    with pytest.raises(InputError, match=f"{word}.* is an empty box, {size}"):
        parse_objects((word,))


@pytest.mark.usefixtures("shared_scenes")
def test_a_photograph_is_reconstructed_by_what_is_said_of_it(tmp_path: Path) -> None:
    photo, sheet = assets_dir() / "demo" / "input.png", tmp_path / "sheet.png"
    words = ["reconstruct", str(photo), "--sheet", str(sheet), "--object", "ball@180,354"]
    assert CliRunner().invoke(app, words).exit_code == 2
    assert CliRunner().invoke(app, [*words, "--prompt", "The ball rolls."]).exit_code == 0
    assert sheet.stat().st_size > 0
