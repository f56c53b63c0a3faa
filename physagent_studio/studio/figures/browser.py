"""The rows that need a real Chromium: when a page is usable, when a trajectory is on screen.

Chromium draws with the processor here (SwiftShader), as it does for whoever has no graphics card.
"""

import importlib.util
import math
import shutil
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio.assets import assets_dir
from physagent_studio.studio.figures.wire import Figure, p95
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


FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
]  # fmt: skip
DROPS, FRAMES, WATCHED = 20, 30, 3.0
NEWCOMER = "localStorage['studio.toured'] = 'true'; localStorage['studio.autoplay'] = 'false'"
"""The tour is over, and nothing plays by itself while something is measured."""

# What the scripts below share: the viewer's page, and a wait until what it draws is finished.
VIEWER = """
  const viewer = document.getElementById('viewer').contentWindow;
  const count = () => viewer.__viserTestpoints.rendererInfo.render.frame;
  const next = () => new Promise(done => requestAnimationFrame(done));
  const drawn = () => {
    const gl = viewer.__viserMutable.canvas.getContext('webgl2');
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  };"""

# Resolves with the milliseconds from sending an edit to the first frame that shows the new path:
# its line is there, a frame was drawn since, and its pixels are finished.
DROP = """async ([action, step, name]) => {
  const wire = await import('/wire.js');VIEWER
  const line = () => {
    const node = viewer.__viserMutable.nodeRefFromName[name];
    let found = '';
    node?.traverse(one => { const at = one.geometry?.attributes?.instanceStart ?? one.geometry?.attributes?.position; if (at) found += Array.from(at.array.slice(-60)).join(); });
    return found;
  };
  const before = line(), began = performance.now(), late = () => performance.now() - began > 10000;
  wire.edit([{op: 'set', path: `event.actions.${action}.start_step`, value: step}], 'timeline');
  while (line() === before && !late()) await next();
  for (const seen = count(); count() === seen && !late();) await next();
  drawn();
  return performance.now() - began;
}""".replace("VIEWER", VIEWER)  # noqa: E501 - a script of the page

# Resolves with the milliseconds that each of so many frames took, finished one before the next.
ONE_FRAME = """async (many) => {VIEWER
  const took = [];
  while (took.length < many) {
    viewer.__viserMutable.requestRender();
    const seen = count(), began = performance.now();
    while (count() === seen) await next();
    drawn();
    took.push(performance.now() - began);
  }
  return took;
}""".replace("VIEWER", VIEWER)

# Resolves with the frames a second that are drawn while the clip plays.
PLAYED = """async (seconds) => {VIEWER
  const wire = await import('/wire.js');
  const rest = (ms) => new Promise(done => setTimeout(done, ms));
  wire.send({do: 'play', on: true});
  await rest(1000);
  const seen = count(), began = performance.now();
  await rest(seconds * 1000);
  const rate = (count() - seen) / (performance.now() - began) * 1000;
  wire.send({do: 'play', on: false});
  return rate;
}""".replace("VIEWER", VIEWER)

# Resolves once nothing more has been fetched for half a second, at the latest after ten.
FETCHED = """async () => {
  const many = () => performance.getEntriesByType('resource').length;
  for (let seen = -1, turn = 0; turn < 20 && seen !== many(); turn += 1) {
    seen = many();
    await new Promise(done => setTimeout(done, 500));
  }
}"""

# Bytes that the page and the 3D view in it have fetched, as they came over the wire.
WEIGHT = """() => [window, document.getElementById('viewer').contentWindow].flatMap(one =>
  ['resource', 'navigation'].flatMap(kind => one.performance.getEntriesByType(kind)))
  .reduce((all, one) => all + (one.transferSize || one.encodedBodySize || 0), 0)"""

SCENE_IS_THERE = """names => {
  const inner = document.getElementById('viewer').contentWindow?.__viserMutable;
  if (!inner?.canvas || !['', '1'].includes(inner.canvas.style.opacity)) return false;
  return names.every(name => {
    let found = false;
    inner.nodeRefFromName[name]?.traverse(one => { found ||= Boolean(one.isMesh); });
    return found;
  });
}"""


def in_a_browser(studio: Studio, action: str) -> list[Figure]:
    """The rows; none where there is no Chromium, or no playwright to drive it."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    if path is None or importlib.util.find_spec("playwright") is None:
        return []
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.add_init_script(NEWCOMER)
        began = time.perf_counter()
        page.goto(studio.address)
        page.locator(f".tl [data-action='{action}']").wait_for()
        usable = time.perf_counter() - began
        trail = _scene_is_drawn(page, studio)
        there = time.perf_counter() - began
        # What the page still fetches, small pictures that are made for it, belongs to opening.
        page.evaluate(FETCHED)
        seconds = [page.evaluate(DROP, [action, 8 + 4 * n, trail]) / 1000 for n in range(DROPS)]
        frame = statistics.median(page.evaluate(ONE_FRAME, FRAMES))
        rate = page.evaluate(PLAYED, WATCHED)
        weight = page.evaluate(WEIGHT) / 2**20
        gone = paths(page, studio)
        browser.close()
    return [
        Figure("page usable in Chromium after opening", usable * 1000, "ms", 3000),
        Figure("scene drawn in Chromium after opening", there * 1000, "ms", 5000),
        Figure("bar dropped to new trajectory in Chromium, demo, p95", p95(seconds), "ms", 400),
        Figure("one frame in Chromium, demo", frame, "ms", 100),
        Figure("frames a second in Chromium while playing, demo", rate, "1/s", 15, above=True),
        Figure("page and 3D view fetched at opening", weight, "MB", 8),
        *gone,
    ]


def _scene_is_drawn(page: Any, studio: Studio) -> str:
    """Waits until the demo's scene is drawn: objects, picture behind, path; the path's node."""
    program = studio.workbench.snapshot().program
    trail = f"/trails/now/{program.event.actions[0].name}"
    objects = [f"/objects/{item.name}" for item in program.scene.objects]
    page.wait_for_function(SCENE_IS_THERE, arg=[*objects, "/backdrop", trail], timeout=60_000)
    page.evaluate(ONE_FRAME, 1)
    return trail
