"""A new session by one drag a thing: the sentence names them, a box shows each."""

from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Desk
from tests.browser.test_layout import AMISS, themed

pytestmark = pytest.mark.browser

SENTENCE = "The red ball rolls to the right and hits the wooden block."
BOXES = {"red_ball": (128, 300, 236, 408), "wooden_block": (462, 182, 550, 322)}
"""Corners in pixels of the demo's photo, drawn a little wide as a hand does."""


@pytest.mark.slow
def test_one_drag_a_thing(waiting: Desk, repository: Path) -> None:
    page = waiting.page
    waiting.button("Open…").click()
    waiting.button("New from a photo…").click()
    photo = repository / "assets" / "demo" / "input.png"
    page.locator("input[type=file]").set_input_files(str(photo))
    page.get_by_label("Sentence").fill(SENTENCE)
    expect(page.get_by_label("Name 1")).to_have_value("red ball")
    expect(page.get_by_label("Name 2")).to_have_value("wooden block")
    picture = waiting.box(page.locator("[data-photo]"))
    scale = picture["width"] / 832
    for x0, y0, x1, y1 in BOXES.values():
        page.mouse.move(picture["x"] + x0 * scale, picture["y"] + y0 * scale)
        page.mouse.down()
        page.mouse.move(picture["x"] + x1 * scale, picture["y"] + y1 * scale, steps=4)
        page.mouse.up()
        # What was cut out is shown at once, also while the next thing's turn comes, and the photo
        # stays where the hand is.
        name = next(one for one, box in BOXES.items() if box[0] == x0).replace("_", " ")
        masks = page.get_by_role("group", name=f"Masks of {name}")
        expect(masks.get_by_role("button")).to_have_count(4)
        expect(page.get_by_text("Is the whole of")).to_have_count(1)
        assert waiting.box(page.locator("[data-photo]")) == picture
    expect(page.get_by_text("a box", exact=True)).to_have_count(2)
    for dark in (False, True):
        themed(page, (1280, 720), dark=dark)
        # Neither the masks nor the list of things has to be looked for.
        for seen in (".sketch-masks", "[aria-label='Name 1']", "[aria-label='Name 2']"):
            expect(page.locator(seen)).to_be_in_viewport(ratio=1)
        assert page.evaluate(AMISS) == []
    old = waiting.snapshot.session_id
    page.evaluate("window.clicks = 0; document.addEventListener('click', () => clicks++)")
    page.get_by_role("dialog").get_by_role("button", name="Make the scene", exact=True).dblclick()
    waiting.until(lambda: waiting.snapshot.session_id != old, "a new session")
    waiting.idle()
    # The second click did not get to what lay beneath the dialog.
    assert page.evaluate("clicks") == 1
    found = {one.name: one.grounding.box for one in waiting.snapshot.program.scene.objects}
    assert set(found) == set(BOXES)
    for name, box in BOXES.items():
        assert found[name] is not None
        assert max(abs(a - b) for a, b in zip(found[name] or (), box, strict=True)) < 3
