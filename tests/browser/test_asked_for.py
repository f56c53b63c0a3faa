"""What a person may ask for beside the loop: views, doubts, likes, another look at the scene."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from physagent_studio.records import Doubt
from physagent_studio.studio.commands import photo as photo_commands
from physagent_studio.studio.panels import rounds
from tests.browser.conftest import PATIENCE, Desk

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]

AUTOPLAY = "localStorage.setItem('studio.autoplay', 'true')"


def test_the_view_is_demanded_and_what_cannot_be_is_not(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    folded = page.get_by_role("button", name=re.compile(": show$"))
    folded.first.click()
    scene = waiting.snapshot.program.scene
    ball = next(one.name for one in scene.objects if one.shape and one.shape.kind == "sphere")
    page.get_by_role("button", name="+ Demand something").click()
    page.get_by_label("Who", exact=True).select_option(ball)
    page.get_by_label("Does what", exact=True).select_option(label="falls over")
    waiting.button("Add to the checklist").click()
    expect(page.get_by_text(re.compile("A round thing cannot fall over"))).to_be_visible()
    assert not waiting.snapshot.has_draft
    page.get_by_label("Does what", exact=True).select_option(label="leaves the picture")
    waiting.button("Add to the checklist").click()
    waiting.until(lambda: ball in waiting.snapshot.program.contract.leaving, "the demand")


def test_numbers_of_ones_own_are_not_said_to_be_tried(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    bar = page.get_by_role("group", name="Decision")
    expect(bar).to_contain_text("tried out")
    waiting.button("Edit").click()
    number = page.locator(".change .nums input").first
    number.fill(str(float(number.input_value()) * 1.1))
    expect(bar).to_contain_text("changed by you: not tried out yet")
    page.keyboard.press("Escape")
    # What was typed does not go along into another round.
    waiting.button("Reject").click()
    page.get_by_label("Reason").fill("weaker")
    waiting.button("Reject and try again").click()
    waiting.until(lambda: waiting.snapshot.state.rounds[-1].rejected, "the rejection")
    waiting.idle()
    expect(bar).not_to_contain_text("changed by you")


def test_an_override_of_many_numbers_keeps_its_button_in_sight(waiting: Desk) -> None:
    page = waiting.page
    page.set_viewport_size({"width": 1280, "height": 720})
    waiting.proposal()
    waiting.button("My numbers").click()
    for _ in range(5):
        waiting.button("Another number").click()
    box = waiting.box(waiting.button("Use mine instead"))
    assert box["y"] + box["height"] <= 720


def test_a_new_round_plays_by_itself_once_and_says_what_changed(waiting: Desk) -> None:
    page = waiting.page
    page.evaluate(AUTOPLAY)
    waiting.proposal()
    waiting.button("Accept").click()
    # Where it is seen late, it may have come to its end.
    view = lambda: waiting.studio.view  # noqa: E731
    waiting.until(lambda: view().playing or view().step > 0, "that it plays")
    expect(page.locator(".changes")).to_contain_text("Changed:")
    waiting.until(lambda: not view().playing, "its end")


@pytest.mark.usefixtures("unfilled_here")
def test_a_doubtful_camera_is_chosen_from_three_pictures(
    waiting: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubt = Doubt(kind="camera", name="", probability=0.4, helps="")
    first, second, *_ = (one.name for one in waiting.snapshot.program.scene.objects)
    mask = Doubt(kind="mask", name=first, probability=0.4, helps="")
    monkeypatch.setattr(rounds, "doubts_of", lambda _scene: [doubt, mask])
    monkeypatch.setattr(rounds, "_loose", lambda _: [{"name": second, "percent": 61}])
    waiting.proposal()
    page = waiting.page
    page.evaluate("import('/wire.js').then(w => w.send({do: 'show', what: 'ghosts', on: false}))")
    # Each doubt is told once, with what helps.
    expect(page.get_by_text("Is the whole of")).to_have_count(1)
    told = page.get_by_role("group", name=re.compile("Doubtful mask of"))
    expect(told.get_by_role("button")).to_have_text(["Look at its masks", "It is right"])
    loose = page.get_by_role("group", name=re.compile("Loose fit of"))
    expect(loose).to_contain_text("covers 61 % of what was cut out")
    expect(loose.get_by_role("button", name="Try its next shape")).to_be_enabled()
    strip = page.get_by_role("group", name="Doubtful camera")
    expect(strip.locator(".cameras button")).to_have_text(["from above", "eye level", "low"])
    before = waiting.snapshot.program.scene.camera
    strip.get_by_role("button", name="from above").click()
    # The scene is made anew for it.
    changed = lambda: waiting.snapshot.program.scene.camera != before  # noqa: E731
    waiting.until(changed, "another camera", 5 * PATIENCE)


def test_like_things_that_a_fill_covers_are_marked(
    waiting: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    thing = waiting.snapshot.program.scene.objects[0].name
    box, marked = (600, 240, 680, 312), []
    monkeypatch.setattr(photo_commands, "covered", lambda *_: {thing: (box,)})
    # What is cut out there takes its time; that it is asked for is seen here.
    monkeypatch.setattr(
        photo_commands.photo_edits, "alike_edits", lambda *given: marked.append(given[-2:]) or ()
    )
    waiting.proposal()
    waiting.reload()
    strip = waiting.page.get_by_role("group", name=re.compile("^Like "))
    expect(strip).to_contain_text("the picture behind it goes over 1 thing that looks like it")
    strip.get_by_role("button", name="Mark similar things").click()
    waiting.until(lambda: marked, "the mark")
    assert marked == [(thing, (box,))]


def test_the_strip_follows_and_things_are_hidden_and_drawn_alone(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    last = page.locator(".evidence button").last
    page.keyboard.press("End")
    expect(last).to_have_attribute("aria-current", "true")
    waiting.tab("Scene")
    names = {one.name for one in waiting.snapshot.program.scene.objects}
    page.locator("[title^='Draw only this one']").first.click()
    waiting.until(lambda: len(waiting.studio.view.hidden) == len(names) - 1, "one thing alone")
    page.locator("[title^='Draw only this one']").first.click()
    waiting.until(lambda: not waiting.studio.view.hidden, "all of them")
    page.locator("[title='Do not draw it']").first.click()
    waiting.until(lambda: len(waiting.studio.view.hidden) == 1, "one hidden")


def test_one_menu_and_the_video_as_a_download(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    page.get_by_role("button", name="More: look, presenting, tour, keys").click()
    menu = page.get_by_role("menu", name="More")
    for name in ("Dark", "Present", "Tour", "Keys", "Picture of the scene…"):
        expect(menu.get_by_role("menuitem", name=re.compile(f"^{name}"))).to_be_visible()
    page.keyboard.press("Escape")
    expect(menu).to_have_count(0)
    page.keyboard.press("Control+k")
    page.keyboard.type("save the clip as a video")
    # Its frames are rendered first.
    with page.expect_download(timeout=5000 * PATIENCE) as fetched:
        page.keyboard.press("Enter")
    assert fetched.value.suggested_filename.endswith(".mp4")


def test_presenting_shows_no_ghosts_and_no_page_speaks_of_the_command_line(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    for tab in ("Scene", "Photo", "Program", "Inspector"):
        waiting.tab(tab)
        assert not re.search(r"--[a-z]|name@", page.locator("body").inner_text())
    assert "ghosts" in waiting.studio.view.shown
    waiting.told()
    page.evaluate("document.activeElement?.blur?.()")
    page.get_by_role("button", name="More: look, presenting, tour, keys").click()
    page.get_by_role("menuitem", name=re.compile("^Present")).click()
    waiting.until(lambda: "ghosts" not in waiting.studio.view.shown, "no ghosts")
    page.keyboard.press("Escape")
    waiting.until(lambda: "ghosts" in waiting.studio.view.shown, "ghosts again")


def test_what_is_running_has_one_bar_and_one_cancel(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    # A run may be over before it is looked for: the page itself notes the most it showed at once.
    page.evaluate(
        """() => {
          const most = window.most = { cancel: 0, bars: 0 };
          new MutationObserver(() => {
            const seen = [...document.querySelectorAll("button")].filter((b) => b.offsetParent);
            const named = seen.filter((b) => b.textContent.trim() === "Cancel");
            most.cancel = Math.max(most.cancel, named.length);
            const bars = document.querySelectorAll("[role=status] ~ .row .bar").length;
            most.bars = Math.max(most.bars, bars);
          }).observe(document.body, { childList: true, subtree: true, attributes: true });
        }"""
    )
    waiting.button("Accept").click()
    page.wait_for_function("() => window.most.cancel > 0")
    assert page.evaluate("() => window.most.cancel") == 1
    assert page.evaluate("() => window.most.bars") <= 1
