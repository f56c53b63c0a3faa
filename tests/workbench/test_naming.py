"""Photos without clicks: what is clear is used and marked, what is not is asked."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError, Unclear
from physagent_studio.exchange import load_case
from physagent_studio.program import Click, Grounding
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands
from physagent_studio.workbench.naming import case_in_words, names_in, with_proposals

PROMPT = "The red ball rolls to the right and hits the blue block."
BALL, BLOCK = (90, 170), (240, 175)


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng = np.random.default_rng(4)
    image = np.full((260, 360, 3), (200, 195, 185), np.float64)
    image[120:] = (150, 120, 90)
    image = np.ascontiguousarray(image)
    cv2.circle(image, BALL, 24, (205, 40, 35), -1, cv2.LINE_AA)
    x, y = BLOCK
    cv2.rectangle(image, (x - 24, y - 30), (x + 24, y + 24), (40, 70, 190), -1)
    image = np.clip(cv2.GaussianBlur(image + rng.normal(0, 3, image.shape), (0, 0), 0.7), 0, 255)
    path = tmp_path_factory.mktemp("photo") / "table.png"
    cv2.imwrite(str(path), image[:, :, ::-1].astype(np.uint8))
    return path


def test_names_of_the_sentence_are_found(photo: Path) -> None:
    case = case_in_words(photo, PROMPT, {})
    found = dict(case.objects)
    assert list(found) == ["red_ball", "blue_block"]
    for name, place in (("red_ball", BALL), ("blue_block", BLOCK)):
        assert found[name].proposed
        (click,) = found[name].points
        assert np.hypot(click.x - place[0], click.y - place[1]) < 16


def test_clicks_are_kept(photo: Path) -> None:
    mine = Click(x=95, y=165)
    case = case_in_words(
        photo, PROMPT, {"red_ball": Grounding(points=(mine,)), "blue_block": Grounding()}
    )
    found = dict(case.objects)
    assert found["red_ball"].points == (mine,)
    assert not found["red_ball"].proposed
    assert found["blue_block"].proposed


def test_what_is_not_clear_is_asked_with_places(photo: Path) -> None:
    with pytest.raises(Unclear, match=r"not clear from words alone: thing \(.*@\d+,\d+"):
        case_in_words(photo, "The thing falls.", {"thing": Grounding()})
    with pytest.raises(InputError, match="names nothing"):
        case_in_words(photo, "It falls.", {})


def test_a_case_without_points(photo: Path) -> None:
    text = f"image: {photo.name}\nobjects:\n  red_ball: {{}}\nevents:\n  roll: {PROMPT}\n"
    (photo.parent / "case.yaml").write_text(text, encoding="utf-8")
    case = load_case(photo.parent)
    assert not case.objects[0][1].shows_something
    assert with_proposals(case).objects[0][1].proposed


def test_a_proposal_is_marked_in_the_scene(photo: Path, tmp_path: Path) -> None:
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenImage(photo, PROMPT, ()))
    assert workbench.wait(120)
    scene = workbench.snapshot().program.scene
    workbench.close()
    assert {item.name for item in scene.objects} == {"red_ball", "blue_block"}
    assert sum("found at" in flag and "nobody clicked" in flag for flag in scene.flags) == 2


@pytest.mark.parametrize(
    ("prompt", "names"),
    [
        ("The red toy car rolls down the ramp.", ("red_toy_car", "ramp")),
        ("The ball rolls down the wooden plank and stops.", ("ball", "plank")),
        ("The ball bounces down the stairs.", ("ball", "stairs")),
        ("The cup falls off the table.", ("cup",)),
        ("The ball rolls onto the board.", ("ball",)),
    ],
)
def test_what_something_goes_down_is_offered_after_the_things(prompt, names):
    assert names_in(prompt) == names


def test_a_slope_that_was_offered_and_not_marked_is_not_looked_for(tmp_path):
    path = tmp_path / "photo.png"
    cv2.imwrite(str(path), np.full((120, 160, 3), 200, np.uint8))
    marks = {"ball": Grounding(box=(20, 20, 60, 60)), "ramp": Grounding()}
    case = case_in_words(path, "The ball rolls down the ramp.", marks, ask=False)
    assert [name for name, _ in case.objects] == ["ball"]
    assert case.supports == ()
