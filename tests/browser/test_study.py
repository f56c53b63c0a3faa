"""Raters of known bias answer a study in the browser, by keyboard and by pointer."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from physagent_studio.benchmark.study.server import StudyServer
from physagent_studio.benchmark.study.trials import counted, pairs, read_answers, study_of

pytestmark = pytest.mark.browser
CLIPS = 24
BRIGHT = """async (side) => {
  const node = document.querySelector(`#${side} img`);
  if (!node) return -1;
  await node.decode();
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  pen.drawImage(node, 0, 0, 4, 4);
  return pen.getImageData(1, 1, 1, 1).data[0];
}"""
"""How bright the clip on a side is; −1 for a blank side."""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[StudyServer]:
    for method, level in (("bright", 220), ("dark", 30)):
        (tmp_path / method).mkdir()
        for k in range(CLIPS):
            picture = np.full((30, 40, 3), level, np.uint8)
            cv2.imwrite(str(tmp_path / method / f"clip_{k}.png"), picture)
            (tmp_path / method / f"clip_{k}.txt").write_text(f"The ball rolls <b>{k}</b> times.")
    with StudyServer(study_of(tmp_path)) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def begin(browser: Browser, server: StudyServer, rater: str) -> Page:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(server.address)
    page.get_by_label("Your name").fill(rater)
    page.get_by_role("button", name="Begin").click()
    return page


def rate(page: Page, liking: float, seed: int, first: int, last: int) -> None:
    """Answers trials, the brighter clip with that chance, on what is seen of them alone."""
    rng = np.random.default_rng(seed)
    for number in range(first, last):
        expect(page.locator("#ask")).to_have_attribute("data-trial", str(number))
        left, right = page.evaluate(BRIGHT, "left"), page.evaluate(BRIGHT, "right")
        likes = min(left, right) < 0 or rng.random() < liking
        side = "left" if (left > right) == likes else "right"
        if number % 2:
            page.locator(f"#{side}").click()
        else:
            page.keyboard.press("ArrowLeft" if side == "left" else "ArrowRight")


@pytest.mark.slow
def test_known_biases_come_out(browser: Browser, server: StudyServer) -> None:
    count = len(server.study.trials("x"))
    for seed, rater in enumerate(("ann", "bob", "cy")):
        page = begin(browser, server, rater)
        rate(page, 0.8, seed, 0, count // 2)
        page.close()
        # Whoever comes back goes on where they were.
        page = begin(browser, server, rater)
        rate(page, 0.8, seed + 10, count // 2, count)
        expect(page.get_by_text("That was all")).to_be_visible()
        page.close()
    answers = read_answers(server.study.folder)
    assert len(answers) == 3 * count
    good, left_out = counted(answers)
    assert left_out == []
    (pair,) = pairs(good)
    assert (pair.one, pair.count) == ("bright", 3 * CLIPS)
    assert pair.low < 0.8 < pair.high
    sides = sum(answer.choice == "left" for answer in good) / len(good)
    assert 0.3 < sides < 0.7


def test_a_sentence_is_text_and_nothing_tells_the_method(
    browser: Browser, server: StudyServer
) -> None:
    page = begin(browser, server, "ann")
    expect(page.locator("#sentence")).to_contain_text("<b>")
    assert "bright" not in page.content()
    page.keyboard.press(" ")
    page.keyboard.press("x")
    assert not read_answers(server.study.folder)
    page.close()
