"""Three paths by mouse alone, counted and timed as a newcomer goes them, in a real Chromium."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio.assets import assets_dir
from physagent_studio.studio.figures.figure import Figure
from physagent_studio.studio.studio import Studio

CLICKED = "[type=button]"
"""What takes a click, as a selector."""
SENTENCE = "The red ball rolls to the right."
BOX = (0.15, 0.62, 0.29, 0.86)
"""Corners of a box around the demo's ball, as parts of the photo's width and height."""
PATIENCE = 300.0
"""Seconds for what a machine that is not idle works out."""
GENTLER = 0.3
"""Where on the slider, from its left end, the hand lets go."""
MANY_SECONDS = 120.0
"""No path has a promise of time; beyond this, s, something is wrong."""


@dataclass
class Hand:
    """A mouse that counts what it does: clicks and drags alike."""

    page: Any
    studio: Studio
    acts: int = 0

    def click(self, name: str, within: Any = None) -> None:
        """One click on a button of that name."""
        self.acts += 1
        (within or self.page).locator(f"{CLICKED}:text-is('{name}')").first.click()

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """One drag, pixels of the page."""
        self.acts += 1
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*end, steps=5)
        self.page.mouse.up()

    def until(self, holds: Callable[[], Any], what: str) -> None:
        """Waits until something is so."""
        ends = time.monotonic() + PATIENCE
        while not holds():
            if time.monotonic() > ends:
                now = self.studio.workbench.snapshot()
                told = "; ".join((now.state.phase, *(one.text for one in now.notices)))
                raise TimeoutError(f"waited in vain for {what}: {told}")
            self.page.wait_for_timeout(50)

    def idle(self) -> None:
        """Waits until nothing is worked out any more."""
        self.page.wait_for_timeout(200)
        self.until(lambda: self.studio.workbench.snapshot().busy is None, "the end of the work")


def paths(page: Any, studio: Studio) -> list[Figure]:
    """The three paths, one after the other, in one page."""
    found: list[Figure] = []
    for name, path, bound in (
        ("photo to first clip, clicks and drags", _first_clip, 5),
        ("a mask mended, clicks", _mended, 2),
        ("too strong made gentle, drags", _gentler, 1),
    ):
        hand, began = Hand(page, studio), time.perf_counter()
        try:
            path(hand)
        except TimeoutError as error:  # what comes after it would begin in the wrong place
            return [*found, Figure(f"{name}: {error}", math.inf, "acts", bound)]
        seconds = time.perf_counter() - began
        found.append(Figure(name, hand.acts, "acts", bound))
        found.append(Figure(f"{name.partition(',')[0]}, time", seconds, "s", MANY_SECONDS))
    return found


def _first_clip(hand: Hand) -> None:
    """From a page that shows anything to the first run of an event in a photo of one's own."""
    page, before = hand.page, hand.studio.workbench.snapshot().session_id
    page.keyboard.press("Shift+O")
    photo: Path = assets_dir() / "demo" / "input.png"
    hand.acts += 2  # "New from a photo", and the file in the system's own dialog
    page.locator("input[type=file]").set_input_files(str(photo))
    page.get_by_label("Sentence").fill(SENTENCE)
    page.locator("input[aria-label='Name 1']").wait_for()
    hand.until(lambda: page.get_by_label("Name 1").input_value() == "red ball", "the name")
    box = page.locator("[data-photo]").bounding_box()
    x0, y0, x1, y1 = BOX
    hand.drag(
        (box["x"] + x0 * box["width"], box["y"] + y0 * box["height"]),
        (box["x"] + x1 * box["width"], box["y"] + y1 * box["height"]),
    )
    hand.click("Start", page.get_by_role("dialog"))
    hand.until(lambda: hand.studio.workbench.snapshot().session_id != before, "the session")
    hand.idle()
    hand.click("Start")
    hand.until(lambda: hand.studio.workbench.snapshot().rollout is not None, "the run")
    hand.idle()


def _mended(hand: Hand) -> None:
    """Another of the masks on offer is taken for a thing."""
    page, before = hand.page, hand.studio.workbench.snapshot().program
    ask = page.locator(f"{CLICKED}:text-is('Look at its masks')").first
    hand.acts += 1
    if ask.count():
        ask.click()
    else:  # nothing is doubted: the thing is chosen where it stands in the photo's list
        page.get_by_role("tab", name="Photo").click()
        page.evaluate("dispatchEvent(new CustomEvent('photo-tool', {detail: 'mask'}))")
    page.locator(".photo-choice .photo-masks button:not(:disabled)").nth(1).wait_for()
    hand.acts += 1
    page.locator(".photo-choice .photo-masks button").nth(1).click()
    hand.until(lambda: hand.studio.workbench.snapshot().program != before, "the mask")
    hand.idle()


def _gentler(hand: Hand) -> None:
    """All efforts of the event are lowered by one drag."""
    before = hand.studio.workbench.snapshot().program
    slider = hand.page.get_by_label("Gentler or harder: all efforts together")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    hand.drag((box["x"] + box["width"] / 2, y), (box["x"] + GENTLER * box["width"], y))
    hand.until(lambda: hand.studio.workbench.snapshot().program != before, "the edit")
    hand.idle()
