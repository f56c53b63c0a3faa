"""The rows that need a real Chromium: when a page is usable, when a trajectory is on screen.

Chromium draws with the processor here (SwiftShader), as it does for whoever has no graphics card.
"""

from __future__ import annotations

import importlib.util
import shutil
import statistics
import time
from typing import Any

from physagent_studio.studio.figures.figure import Figure, p95
from physagent_studio.studio.figures.paths import paths
from physagent_studio.studio.studio import Studio

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
