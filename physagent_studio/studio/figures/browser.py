"""The rows that need a real Chromium: when a page is usable, when a trajectory is on screen."""

from __future__ import annotations

import importlib.util
import shutil
import time
from typing import Any

from physagent_studio.studio.figures.figure import Figure, p95
from physagent_studio.studio.studio import Studio

FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
]  # fmt: skip
DROPS = 20

# Resolves with the milliseconds from sending an edit to the line of the new path being drawn.
DROP = """async ([action, step, name]) => {
  const wire = await import('/wire.js');
  const viewer = document.getElementById('viewer').contentWindow;
  const line = () => {
    const node = viewer.__viserMutable.nodeRefFromName[name];
    let found = '';
    node?.traverse(one => { const at = one.geometry?.attributes?.instanceStart ?? one.geometry?.attributes?.position; if (at) found += Array.from(at.array.slice(-60)).join(); });
    return found;
  };
  const before = line(), began = performance.now();
  wire.edit([{op: 'set', path: `event.actions.${action}.start_step`, value: step}], 'timeline');
  return await new Promise(done => {
    const look = () => (line() !== before || performance.now() - began > 5000) ? requestAnimationFrame(() => done(performance.now() - began)) : requestAnimationFrame(look);
    look();
  });
}"""  # noqa: E501 - a script of the page


def in_a_browser(studio: Studio, action: str) -> list[Figure]:
    """The rows; none where there is no Chromium, or no playwright to drive it."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    if path is None or importlib.util.find_spec("playwright") is None:
        return []
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        began = time.perf_counter()
        page.goto(studio.address)
        page.locator(f".tl [data-action='{action}']").wait_for()
        usable = time.perf_counter() - began
        name = _scene_is_drawn(page, studio)
        seconds = [page.evaluate(DROP, [action, 8 + 4 * n, name]) / 1000 for n in range(DROPS)]
        browser.close()
    return [
        Figure("page usable in Chromium after opening", usable * 1000, "ms", 3000),
        Figure("bar dropped to new trajectory in Chromium, demo, p95", p95(seconds), "ms", 400),
    ]


def _scene_is_drawn(page: Any, studio: Studio) -> str:
    """Waits until the path of the thing that moves is in the scene; its node's name."""
    moving = studio.workbench.snapshot().program.event.actions[0].name
    name = f"/trails/now/{moving}"
    page.wait_for_function(
        "name => document.getElementById('viewer').contentWindow"
        "?.__viserMutable?.nodeRefFromName?.[name]",
        arg=name,
        timeout=60_000,
    )
    return name
