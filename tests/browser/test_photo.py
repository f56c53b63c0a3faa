"""Tools of the photo: a mark becomes one edit, the scene follows, Ctrl+Z takes it back."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pytest
from playwright.sync_api import expect

from physagent_studio.assets import assets_dir
from physagent_studio.program.scene.state import Grounding, SceneState
from physagent_studio.reconstruction.masks import segmenter as segmentation
from physagent_studio.studio import photo_desk
from physagent_studio.workbench import tasks
from tests.browser.conftest import PATIENCE, Desk

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("unfilled")]


class Photo:
    """The photo tab with an object selected; positions are pixels of the photo."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        desk.tab("Photo")
        self.name = desk.snapshot.program.scene.objects[0].name
        things = desk.page.locator(".photo-things")
        things.get_by_role("button", name=self.name.replace("_", " ")).first.click()
        desk.until(lambda: desk.studio.view.selection.name == self.name, "the selection")
        self.before = desk.snapshot.program
        self.svg = desk.page.locator(".photo-stage > svg")
        expect(self.svg).to_be_visible()

    @property
    def scene(self) -> SceneState:
        return self.desk.snapshot.program.scene

    @property
    def grounding(self) -> Grounding:
        item = self.scene.object(self.name)
        assert item is not None
        return item.grounding

    def mask(self) -> np.ndarray:
        scene = self.desk.snapshot.scene
        assert scene is not None
        return scene.masks[self.name]

    def middle(self) -> tuple[float, float]:
        rows, columns = np.nonzero(self.mask())
        return float(np.median(columns)), float(np.median(rows))

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where a pixel of the photo is on the page."""
        spot = self.svg.evaluate(
            """(svg, [x, y]) => {
              const on = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
              return [on.x, on.y];
            }""",
            [x, y],
        )
        return spot[0], spot[1]

    def tool(self, name: str) -> None:
        button = self.desk.button(name)
        button.click()
        expect(button).to_have_attribute("aria-pressed", "true")

    def drag(self, *points: tuple[float, float]) -> None:
        self.caught_up()
        mouse = self.desk.page.mouse
        mouse.move(*self.at(*points[0]))
        mouse.down()
        for point in points[1:]:
            mouse.move(*self.at(*point), steps=4)
        mouse.up()

    def thumbnails(self) -> int:
        """The masks on offer, once the last question is answered."""
        self.desk.drawn()  # before that, the answer to the question before is on the page
        masks = self.desk.page.locator(".photo-masks button")
        expect(masks.first).to_be_visible()
        expect(self.desk.page.get_by_text("to use one.")).to_be_visible()
        return masks.count()

    def steer(self, x: float, y: float) -> None:
        """Brings the cross to within a step of a place, by the arrow keys."""
        told = self.desk.page.locator(".photo-stage .unseen")
        for axis, keys in enumerate((("ArrowLeft", "ArrowRight"), ("ArrowUp", "ArrowDown"))):
            for prefix in ("Shift+", ""):
                before = 0.0
                while True:
                    numbers = re.findall(r"(\d+) (?:across|down)", told.text_content() or "")
                    off = (x, y)[axis] - float(numbers[axis])
                    if before * off < 0 or off == 0:
                        break
                    before = off
                    self.desk.page.keyboard.press(prefix + keys[off > 0])

    def changed(self, holds: Callable[[SceneState], object], what: str) -> None:
        """Until an edit has arrived and the scene has followed."""
        self.desk.until(lambda: self.desk.snapshot.has_draft and holds(self.scene), what)
        self.desk.idle()
        assert self.scene.is_closed

    def undone(self) -> None:
        """One Ctrl+Z brings everything back, on the page as well."""
        self.desk.page.keyboard.press("Control+z")
        self.desk.until(lambda: self.desk.snapshot.program == self.before, "undone")
        self.caught_up()

    def caught_up(self) -> None:
        """Waits until the page shows what there is, and the photo is where it will stay.

        What tells of edits and of work comes and goes, and the photo moves up or down with it.
        """
        self.desk.idle()
        self.desk.box(self.svg)

    def click(self, x: float, y: float, button: Literal["left", "right"] = "left") -> None:
        """A click on a pixel of the photo, once the photo is where it will stay."""
        self.desk.box(self.svg)
        self.desk.page.mouse.click(*self.at(x, y), button=button)


@pytest.fixture
def photo(fresh: Desk) -> Photo:
    return Photo(fresh)


@pytest.mark.slow
@pytest.mark.parametrize("lasts", [True, False])
def test_a_mask_chosen_early_is_taken_after_the_closer_look(
    photo: Photo, monkeypatch: pytest.MonkeyPatch, lasts: bool
) -> None:
    page, go_on = photo.desk.page, threading.Event()
    sought = segmentation.full_size

    def slowly(*given: Any, settled: bool = True) -> Any:
        assert not settled or go_on.wait(PATIENCE)
        return sought(*given, settled=settled)

    monkeypatch.setattr(segmentation, "full_size", slowly)
    monkeypatch.setattr(photo_desk, "EARLY", -1.0)
    if not lasts:
        monkeypatch.setattr(photo_desk, "SAME", 1.1)
    photo.tool("Mask")
    x, y = photo.middle()
    photo.click(x + 3, y)
    early = page.locator(".photo-masks button")
    expect(page.get_by_text("looking more closely")).to_be_visible()
    expect(early).to_have_count(4)
    page.keyboard.press("2")
    expect(page.get_by_text("Mask 2 it is")).to_be_visible()
    assert photo.desk.snapshot.program == photo.before
    go_on.set()
    if lasts:
        photo.changed(lambda scene: photo.grounding.settled, "the chosen mask")
        return
    expect(page.get_by_text("Mask 2 did not last a closer look")).to_be_visible()
    expect(early.first).to_have_attribute("aria-pressed", "true")  # the best leads again
    assert photo.desk.snapshot.program == photo.before
    # The masks on view belong to the last mark until those of the next are there.
    monkeypatch.setattr(photo_desk, "SAME", 0.0)
    go_on.clear()
    monkeypatch.setattr(photo_desk, "EARLY", 1e6)
    photo.click(x - 4, y + 3)
    expect(page.get_by_text("Looking…")).to_be_visible()
    expect(early.nth(1)).to_be_disabled()
    page.keyboard.press("2")
    page.keyboard.press("Enter")
    expect(page.get_by_text("The best one is taken once it is found")).to_be_visible()
    go_on.set()
    photo.changed(lambda scene: photo.grounding.settled, "the best mask")
    assert photo.grounding.candidate == 0


def test_click_or_box_choose_one_of_four_and_undo(photo: Photo) -> None:
    page = photo.desk.page
    photo.tool("Mask")
    x, y = photo.middle()
    dots = page.locator(".ph-dot.in")
    count = dots.count()
    photo.click(x + 3, y)
    expect(dots).to_have_count(count + 1)
    assert photo.thumbnails() == 4
    # Before a mask is taken, Ctrl+Z takes back the mark and nothing else.
    page.keyboard.press("Control+z")
    expect(dots).to_have_count(count)
    assert photo.desk.snapshot.program == photo.before
    assert not photo.desk.snapshot.can_redo
    # Without a mouse: a cross is moved by the arrow keys, which are the playhead's elsewhere.
    cross = page.locator(".ph-cross")
    expect(cross).to_have_count(0)
    page.keyboard.press("k")
    expect(cross).to_be_visible()
    photo.steer(x + 3, y)
    name = photo.name.replace("_", " ")
    expect(page.locator(".photo-stage .unseen")).to_contain_text(f"down, {name}")
    page.keyboard.press("Enter")
    expect(dots).to_have_count(count + 1)
    page.keyboard.press("Escape")
    expect(dots).to_have_count(count)
    page.keyboard.press("Space")
    expect(dots).to_have_count(count + 1)
    assert photo.thumbnails() == 4
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    expect(cross).to_have_count(0)
    assert photo.desk.studio.view.step == 0
    assert not photo.desk.studio.view.playing
    expect(photo.desk.button("Mask")).to_have_attribute("aria-pressed", "true")
    photo.click(x + 3, y)
    photo.thumbnails()
    photo.click(5, 5, button="right")
    rows, columns = np.nonzero(photo.mask())
    low = (float(columns.min()) - 5, float(rows.min()) - 5)
    photo.drag(low, (float(columns.max()) + 5, float(rows.max()) + 5))
    photo.thumbnails()
    expect(page.get_by_role("button", name="Mask 2 of")).to_be_visible()
    # A key that is held or pressed twice means the mask alone, no view of the scene.
    page.evaluate(
        """() => [1, 2].forEach(() => document.querySelector(".photo-stage").dispatchEvent(
          new KeyboardEvent("keydown", { key: "2", code: "Digit2", bubbles: true })))"""
    )
    photo.changed(lambda scene: photo.grounding.settled, "the chosen mask")
    expect(page.locator("#notices > *")).to_have_count(0)
    made = photo.grounding
    assert made.candidate == 1
    assert made.box == pytest.approx((*low, columns.max() + 5, rows.max() + 5), abs=2)
    assert [click.label for click in made.points[-2:]].count(0) >= 1
    assert photo.desk.snapshot.scene is not None
    photo.undone()


@pytest.mark.slow
def test_brush_and_scissors(photo: Photo) -> None:
    page = photo.desk.page
    photo.tool("Brush")
    x, y = photo.middle()
    photo.desk.button("Erase").click()
    photo.drag((x - 2, y), (x + 2, y))
    photo.thumbnails()
    page.keyboard.press("Enter")
    photo.changed(lambda scene: photo.grounding.strokes, "the stroke")
    assert photo.grounding.strokes[0].effect == "erase"
    assert not photo.mask()[int(y), int(x)]

    photo.tool("Scissors")
    photo.desk.button("Exactly this").click()
    page.keyboard.down("Shift")
    for corner in ((x - 20, y - 20), (x + 20, y - 20), (x + 20, y + 20), (x - 20, y + 20)):
        photo.click(*corner)
    page.keyboard.press("Enter")
    page.keyboard.up("Shift")
    photo.thumbnails()
    page.keyboard.press("1")
    photo.changed(lambda scene: len(photo.grounding.strokes) == 2, "the cut")
    assert photo.grounding.strokes[1].tool == "scissors"
    area = int(np.count_nonzero(photo.mask()))
    assert area == pytest.approx(1600, rel=0.15)

    page.keyboard.press("Control+z")
    photo.desk.until(lambda: len(photo.grounding.strokes) == 1, "the cut undone")
    photo.undone()

    # Without Shift the line follows edges: more points than were clicked.
    rows, columns = np.nonzero(photo.mask())
    left, right = float(columns.min()), float(columns.max())
    top, low = float(rows.min()), float(rows.max())
    middle = ((left + right) / 2, (top + low) / 2)
    around = [(left, middle[1]), (middle[0], top), (right, middle[1]), (middle[0], low)]
    for number, spot in enumerate(around, start=1):
        photo.click(*spot)
        expect(page.locator(".ph-live .ph-dot")).to_have_count(number)
    page.keyboard.press("Enter")
    photo.thumbnails()
    page.keyboard.press("1")
    photo.changed(lambda scene: photo.grounding.strokes, "the cut")
    points = np.array(photo.grounding.strokes[0].points)
    assert len(points) > 8
    photo.undone()


@pytest.mark.slow
def test_the_horizon_is_dragged_and_a_ramp_placed_with_three_clicks(photo: Photo) -> None:
    page = photo.desk.page
    photo.tool("Horizon")
    expect(photo.desk.page.get_by_text("Horizon: row")).to_be_visible()
    camera = photo.scene.camera
    assert camera is not None
    width = camera.size[0]
    row = camera.horizon
    photo.drag((width / 2, row), (width / 2, -30))
    photo.changed(lambda scene: scene.horizon_source == "person", "the horizon")
    assert photo.scene.horizon == pytest.approx(-30, abs=3)
    was, now = photo.before.scene.objects, photo.scene.objects
    assert all(a.position != b.position for a, b in zip(was, now, strict=True))
    # Above the photo it is drawn at the edge with all its grips, and tilted there too.
    grips = page.locator(".ph-horizon-grip")
    expect(grips).to_have_count(3)
    photo.caught_up()
    for number in range(3):
        assert photo.desk.box(grips.nth(number))["y"] >= photo.at(0, 0)[1] - 1
    right = photo.desk.box(grips.nth(2))
    x, y = right["x"] + right["width"] / 2, right["y"] + right["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 12, steps=3)
    expect(page.locator(".ph-name", has_text="tilted by")).to_be_visible()
    page.keyboard.press("Escape")
    page.mouse.up()
    photo.tool("Horizon")
    expect(page.locator(".ph-name", has_text="tilted by")).to_have_count(0)
    # From the edge it goes to where it is dragged.
    photo.click(width / 2, 4)
    photo.drag((width / 2, 4), (width / 2, row + 30))
    photo.changed(lambda scene: (scene.horizon or 0) > row, "the horizon, back")
    assert photo.scene.camera is not None
    assert photo.scene.camera.horizon == pytest.approx(row + 26, abs=3)
    page.keyboard.press("Control+z")
    photo.desk.until(lambda: (photo.scene.horizon or 0) < 0, "one step back")
    photo.undone()
    expect(page.locator(".ph-horizon-grip")).to_have_count(3)
    expect(page.get_by_text("Now estimated")).to_be_visible()
    fall = 0.4 * width * np.tan(np.radians(4))
    photo.drag((0.1 * width, row), (0.1 * width, row + fall))
    photo.changed(lambda scene: scene.roll, "a tilted horizon")
    tilted = photo.scene
    assert tilted.camera is not None
    assert tilted.roll == pytest.approx(4, abs=0.4)
    assert np.degrees(tilted.camera.roll) == pytest.approx(tilted.roll, abs=0.01)
    assert tilted.camera.horizon == pytest.approx(row, abs=1)
    line = page.locator(".ph-name", has_text=f"tilted by {tilted.roll:.1f}°")
    expect(line).to_be_visible()
    photo.undone()

    photo.tool("Ramp")
    photo.caught_up()
    width, height = camera.size
    still = photo.at(0, 0)
    photo.click(0.3 * width, 0.93 * height)
    expect(page.get_by_text("Now the ground below its upper end.")).to_be_visible()
    assert photo.at(0, 0) == pytest.approx(still, abs=0.5)  # nothing moves under the pointer
    photo.click(0.6 * width, 0.93 * height)
    photo.click(0.6 * width, 0.75 * height)
    photo.changed(lambda scene: scene.support("ramp"), "a ramp")
    ramp = photo.scene.support("ramp")
    assert ramp is not None
    assert ramp.shape is not None
    assert ramp.shape.kind == "ramp"
    # Its edges are drawn where the photo's camera sees them, once it is chosen.
    edges = page.locator(".ph-support .ph-edge")
    expect(edges).to_be_hidden()
    page.locator(".photo-things").get_by_role("button", name="ramp").click()
    expect(edges).to_be_visible()
    photo.undone()


@pytest.mark.slow
def test_a_size_another_shape_and_zoom(photo: Photo) -> None:
    page = photo.desk.page
    field = page.get_by_label(f"Size of {photo.name} in metres")
    field.fill("two")
    field.press("Enter")
    expect(page.get_by_role("alert")).to_contain_text("25 cm")
    field.fill("200 cm")
    field.press("Enter")
    photo.changed(lambda scene: scene.scale.metres == 2, "the size")
    assert photo.scene.scale.source == "person"
    page.locator(".photo-stage").focus()
    photo.undone()

    shape = photo.scene.objects[0].shape
    assert shape is not None
    page.keyboard.press("s")
    photo.changed(lambda scene: scene.objects[0].form, "another shape")
    now = photo.scene.objects[0].shape
    assert now is not None
    assert now.kind != shape.kind
    photo.undone()

    # The wheel zooms; large fills the middle of the page.
    before = photo.svg.get_attribute("viewBox")
    page.mouse.move(*photo.at(100, 100))
    page.mouse.wheel(0, -300)
    expect(photo.svg).not_to_have_attribute("viewBox", before or "")
    x, y = photo.at(100, 100)
    assert (x, y) == pytest.approx(photo.at(100, 100), abs=1)
    narrow = photo.desk.box(photo.svg)
    photo.desk.button("Large photo").click()
    wide = photo.desk.box(photo.svg)
    assert wide["width"] > 1.5 * narrow["width"]


@pytest.mark.slow
def test_a_session_from_a_photo_and_a_sentence_alone(
    fresh: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No click at all: what the sentence names is found in the photo, and marked as such."""
    page, before, go_on = fresh.page, fresh.snapshot.session_id, threading.Event()
    made = tasks.reconstructed

    def slowly(*given: Any, **more: Any) -> Any:
        assert go_on.wait(PATIENCE)
        return made(*given, **more)

    monkeypatch.setattr(tasks, "reconstructed", slowly)
    page.keyboard.press("Shift+O")
    page.locator("input[type=file]").set_input_files(assets_dir() / "demo" / "input.png")
    sentence = "The red ball rolls to the right and hits the wooden block and the green cube."
    expect(page.get_by_text("Say what shall happen, in a sentence.")).to_be_visible()
    # What cannot be begun comes back as it was, with the reason.
    dialog = page.get_by_role("dialog")
    page.get_by_label("Sentence").fill("It explodes.")
    dialog.get_by_role("button", name="Make the scene", exact=True).click()
    expect(dialog.get_by_text("The sentence names nothing")).to_be_visible()
    expect(dialog.get_by_alt_text("Your photo")).to_be_visible()
    expect(page.locator("#notices > *")).to_have_count(0)
    assert fresh.snapshot.session_id == before
    page.get_by_label("Sentence").fill(sentence)
    dialog.get_by_role("button", name="Make the scene", exact=True).click()
    # The photo is there to look at while its scene is made, and the things are there to be marked.
    expect(page.locator("img.awaited")).to_be_visible()
    fresh.until(lambda: fresh.snapshot.session_id not in (None, before), "the new session")
    fresh.tab("Photo")
    things = page.locator(".photo-things button")
    expect(things).to_have_count(4)
    expect(page.locator(".ph-line")).to_have_count(0)
    fresh.button("Mask").click()
    spot = fresh.box(page.locator(".photo-stage > svg"))
    case = fresh.snapshot.case
    assert case is not None
    name, said = case.objects[2]
    # A mark may come before it is said which thing it belongs to.
    share = spot["width"] / case.image.shape[1] if case.image is not None else 0
    page.mouse.click(spot["x"] + said.points[0].x * share, spot["y"] + said.points[0].y * share)
    expect(page.get_by_text("Which thing is that?")).to_be_visible()
    things.nth(2).click()
    expect(page.locator(".photo-masks button")).to_have_count(4)
    expect(page.get_by_text("to use one.")).to_be_visible()
    page.keyboard.press("2")
    expect(page.get_by_text("as soon as the first scene is there")).to_be_visible()
    assert fresh.snapshot.state.rounds == ()
    go_on.set()
    fresh.until(lambda: fresh.snapshot.has_draft, "the mask, once there is a scene")
    expect(page.locator("img.awaited")).to_be_hidden()
    fresh.idle()
    scene = fresh.snapshot.program.scene
    assert [item.name for item in scene.objects] == ["red_ball", "wooden_block", name]
    assert [item.grounding.settled for item in scene.objects] == [False, False, True]
    assert [item.grounding.proposed for item in scene.objects] == [True, True, False]
    asked = page.get_by_role("group", name="Found by words")
    expect(asked).to_contain_text("red ball and wooden block were found by their names")
    # A click says where it is: what was found by words is forgotten.
    asked.get_by_role("button", name="No, let me click").click()
    expect(page.get_by_text("found by words").first).to_be_visible()
    photo = Photo(fresh)
    x, y = photo.middle()
    photo.click(x + 4, y + 4)
    photo.thumbnails()
    page.keyboard.press("Enter")
    photo.changed(lambda state: not state.objects[0].grounding.proposed, "the clicked ball")
    inside = [one for one in fresh.snapshot.program.scene.objects[0].grounding.points if one.label]
    assert len(inside) == 1
    expect(asked).to_contain_text("wooden block was found by its name")
    asked.get_by_role("button", name="Yes").click()
    expect(asked).to_have_count(0)
