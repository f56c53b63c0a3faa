"""Takes the pictures of the documentation from a running studio.

Every picture is of a real session on a photograph that ships with the project: it is opened,
stepped and edited the way a person would, in a real Chromium. `python tools/take_screenshots.py
NAME …` takes only some of them. Needs the test extra and Pillow, which makes the files small.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402
from playwright.sync_api import Browser, Page, sync_playwright  # noqa: E402

from physagent_studio.assets import assets_dir  # noqa: E402
from physagent_studio.session import Store  # noqa: E402
from physagent_studio.studio import Studio, serve  # noqa: E402
from physagent_studio.studio.replay import replay_of  # noqa: E402
from physagent_studio.workbench import Workbench, commands  # noqa: E402
from tests.run_all import find_browser  # noqa: E402

FOLDER = ROOT / "docs" / "images"
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]  # fmt: skip
PATIENCE = 240_000
"""Milliseconds for the scene to fade in, drawn in software."""
MADE_WITHIN = 1800
"""Seconds for a session to be made on a machine that is not idle."""
LARGEST = 300 * 1024
"""Bytes of a picture."""

FADED_IN = """() => {
  const view = document.getElementById("viewer").contentWindow;
  const canvas = [...view.document.querySelectorAll("canvas")].at(-1);
  const drawn = view.__viserMutable?.nodeRefFromName;
  return canvas && Number(canvas.style.opacity || 1) === 1 && drawn && drawn["/backdrop"];
}"""


FRAMES_THERE = """() => [...document.querySelectorAll(".evidence img")].slice(0, 3)
  .every((image) => image.complete && image.naturalWidth > 0)"""


@dataclass(frozen=True)
class Shot:
    """A picture: its name, its case's folder and event, the window, and what is done first."""

    name: str
    case: str
    event: str
    act: Callable[[Page], None]
    size: tuple[int, int] = (1280, 800)
    dark: bool = False
    to_the_end: bool = False
    tour: bool = False


def nothing(page: Page) -> None:
    """The studio as it stands after a step."""


def compared(page: Page) -> None:
    """The last round beside the first, in the middle of the event."""
    page.get_by_role("button", name="Compare with round 1").click()
    page.get_by_role("group", name="What changed from round 1").scroll_into_view_if_needed()
    for _ in range(2):
        page.keyboard.press("Shift+ArrowRight")


def falling(page: Page) -> None:
    """Late in the event, with the sampled frames."""
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")


def presenting(page: Page) -> None:
    """Presenter mode, some way into the event."""
    page.keyboard.press("Shift+P")
    for _ in range(2):
        page.keyboard.press("Shift+ArrowRight")


def touring(page: Page) -> None:
    """The third step of the tour."""
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")


def sessions(page: Page) -> None:
    """The list, with a copy of the session and the question before it goes."""
    page.get_by_role("button", name="Open…").click()
    page.get_by_role("button", name="Duplicate").first.click()
    delete = page.get_by_role("button", name="(2)”").last
    delete.click()
    page.get_by_role("button", name="Keep").scroll_into_view_if_needed()


def at_impact(page: Page) -> None:
    """In the middle of the event, with forces and contacts."""
    page.get_by_role("button", name="Forces", exact=True).click()
    page.get_by_role("button", name="Contacts", exact=True).click()
    for _ in range(7):
        page.keyboard.press("ArrowRight")


def editing(page: Page) -> None:
    """The proposal's numbers open for editing."""
    page.get_by_role("button", name="Edit", exact=True).click()
    page.get_by_role("group", name="Proposal").scroll_into_view_if_needed()


def my_verdict(page: Page) -> None:
    """Verdicts are the person's; the repair is accepted, and the event waits for one."""
    page.get_by_role("button", name="Done by me: decisions").click()
    page.get_by_role("button", name="Verdicts", exact=True).click()
    page.get_by_role("button", name="Accept", exact=True).click()
    page.get_by_role("button", name="It matches").click()
    page.get_by_text("Does the event happen?").wait_for()


def in_the_inspector(page: Page) -> None:
    """An action selected in the timeline."""
    page.locator(".tl [data-action] .body").first.click()
    page.get_by_role("tab", name="Inspector").click()


def wrong_text(page: Page) -> None:
    """The program as text, with a mistake that was checked."""
    page.get_by_role("tab", name="Program").click()
    area = page.get_by_label("Program as YAML")
    text = area.input_value().split("\n")
    at = next(n for n, line in enumerate(text) if line.strip().startswith("duration:"))
    text[at] = text[at].split(":")[0] + ": a while"
    area.fill("\n".join(text))
    page.get_by_role("button", name="Validate").click()
    page.locator(".problems button").first.click()


def from_the_side(page: Page) -> None:
    """The scene seen from outside, with the camera that took the photo."""
    page.get_by_role("tab", name="Scene").click()
    page.get_by_label("Camera", exact=True).click()
    page.get_by_role("button", name="Front", exact=True).click()


def new_session(page: Page) -> None:
    """The dialog of a new session, with a photo, a sentence and a box around each thing."""
    page.get_by_role("button", name="Open…").click()
    page.get_by_role("button", name="New from a photo…").click()
    page.locator("input[type=file]").set_input_files(str(assets_dir() / "demo" / "input.png"))
    page.get_by_label("Sentence").fill("The red ball rolls to the right and hits the block.")
    page.get_by_label("Name 2").wait_for()
    box = page.locator("[data-photo]").bounding_box()
    assert box is not None
    scale = box["width"] / 832
    for x0, y0, x1, y1 in ((130, 305, 232, 405), (462, 182, 550, 322)):
        page.mouse.move(box["x"] + x0 * scale, box["y"] + y0 * scale)
        page.mouse.down()
        page.mouse.move(box["x"] + x1 * scale, box["y"] + y1 * scale, steps=4)
        page.mouse.up()


SHOTS = (
    Shot("studio", "assets/cans", "knocks_red_over", nothing),
    Shot("studio-cans", "assets/cans", "knocks_red_over", compared, to_the_end=True),
    Shot("studio-table", "assets/table", "falls_off", falling, to_the_end=True),
    Shot("studio-impact", "assets/demo", "knocks_block_over", at_impact, to_the_end=True),
    Shot("studio-edit", "assets/table", "stays_on_table", editing),
    Shot("studio-verdict", "assets/table", "stays_on_table", my_verdict),
    Shot("studio-inspector", "assets/demo", "only_the_cube", in_the_inspector, dark=True),
    Shot("studio-program", "assets/demo", "only_the_cube", wrong_text),
    Shot("studio-scene", "assets/demo", "only_the_cube", from_the_side, dark=True),
    Shot("studio-new", "assets/demo", "only_the_cube", new_session),
    Shot("studio-small", "assets/table", "stays_on_table", nothing, size=(1000, 700), dark=True),
    Shot("studio-tour", "assets/demo", "only_the_cube", touring, tour=True),
    Shot("studio-sessions", "assets/cans", "only_blue", sessions),
    Shot("studio-presenter", "assets/cans", "knocks_red_over", presenting, to_the_end=True),
)
REPLAY = Shot("studio-replay", "assets/cans", "only_blue", nothing, to_the_end=True)


class Sessions:
    """Workspaces by what was done in them; each is made once, and every picture gets a copy."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._made: dict[tuple[str, str, bool], Path] = {}

    def of(self, shot: Shot) -> Path:
        """A workspace that has the shot's case open, one step or all the way done."""
        key = (shot.case, shot.event, shot.to_the_end)
        if key not in self._made:
            root = self._folder / f"made{len(self._made)}"
            workbench = Workbench(Store(root), evidence=False)
            workbench.post(commands.OpenCase(ROOT / shot.case, shot.event))
            workbench.post(commands.Run() if shot.to_the_end else commands.Step())
            if not workbench.wait(MADE_WITHIN):
                raise SystemExit(f"{shot.name}: the session took more than half an hour")
            workbench.close()
            self._made[key] = root
        copy = self._folder / shot.name
        shutil.copytree(self._made[key], copy)
        return copy


@contextmanager
def studio_on(shot: Shot, sessions: Sessions) -> Iterator[Studio]:
    """A studio on a copy of the shot's session."""
    store = Store(sessions.of(shot))
    workbench = Workbench(store, evidence=False)
    workbench.post(commands.OpenSession(store.list()[0].id))
    if not workbench.wait(120):
        raise SystemExit(f"{shot.name}: the session does not open")
    studio = serve(workbench, port=0)
    try:
        yield studio
    finally:
        studio.stop()
        workbench.close()


def take(browser: Browser, shot: Shot, sessions: Sessions) -> Path:
    """Takes one picture and returns where it lies."""
    page = _page(browser, shot)
    with studio_on(shot, sessions) as studio:
        page.goto(studio.address)
        page.locator(".tl [data-action]").first.wait_for()
        page.wait_for_function(FADED_IN, timeout=PATIENCE)
        page.wait_for_function(FRAMES_THERE, timeout=PATIENCE)
        page.wait_for_timeout(1000)
        shot.act(page)
        page.wait_for_timeout(2500)
        path = _keep(page, shot.name)
    page.close()
    return path


def take_replay(browser: Browser, sessions: Sessions) -> Path:
    """The page that a session leaves as, opened from the disk."""
    page = _page(browser, REPLAY)
    with tempfile.TemporaryDirectory() as folder, studio_on(REPLAY, sessions) as studio:
        file = Path(folder) / "replay.html"
        studio.workbench.post(commands.Write(file, "The replay", replay_of))
        if not studio.workbench.wait(300):
            raise SystemExit("the replay took more than five minutes")
        page.goto(file.as_uri())
        page.wait_for_function("() => document.querySelector('video').readyState >= 2")
        page.get_by_role("button", name="frame ").nth(1).click()
        page.wait_for_timeout(1500)
        path = _keep(page, REPLAY.name)
    page.close()
    return path


def _page(browser: Browser, shot: Shot) -> Page:
    width, height = shot.size
    scheme = "dark" if shot.dark else "light"
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    page.set_default_timeout(PATIENCE)
    if not shot.tour:
        page.add_init_script("localStorage.setItem('studio.toured', 'true')")
    return page


def _keep(page: Page, name: str) -> Path:
    """Saves the page as a PNG of as many colours as its size allows."""
    path = FOLDER / f"{name}.png"
    page.screenshot(path=path, timeout=PATIENCE)
    whole = Image.open(path).convert("RGB")
    for colours in (256, 160, 96, 64, 40):
        palette = whole.quantize(colours, kmeans=3)
        dithered = whole.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
        dithered.save(path, optimize=True)
        if path.stat().st_size <= LARGEST:
            break
    return path


def main(names: list[str]) -> None:
    """Takes the chosen pictures, or all."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        made = Sessions(Path(folder))
        browser = playwright.chromium.launch(executable_path=find_browser(), args=FLAGS)
        for shot in SHOTS:
            if not names or shot.name in names:
                print(take(browser, shot, made).relative_to(ROOT), flush=True)
        if not names or REPLAY.name in names:
            print(take_replay(browser, made).relative_to(ROOT), flush=True)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
