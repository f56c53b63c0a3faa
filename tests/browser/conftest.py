"""A real studio on a free port and a real Chromium; polling with deadlines, never sleeping."""

from __future__ import annotations

import itertools
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from playwright.sync_api import Browser, FloatRect, Locator, Page, expect, sync_playwright

from physagent_studio.agent.rules import RulePlanner
from physagent_studio.agent.rules.planner import goal_search
from physagent_studio.assets import assets_dir
from physagent_studio.session import Store
from physagent_studio.studio import Studio, serve
from physagent_studio.studio.site import jpeg_of
from physagent_studio.workbench import Snapshot, Workbench, commands, engine

FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
]  # fmt: skip
PATIENCE = 120.0
"""Seconds to wait for what has to happen; only where it does not, they are spent."""

expect.set_options(timeout=1000 * PATIENCE)

DOT = jpeg_of(np.zeros((1, 1, 3), np.uint8))
"""Stands for the frames of the strip where nobody looks at them."""

DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Until what has been done on a page is drawn: what it shows is drawn once a frame."""
STILL = """async (node) => {
  const place = () => JSON.stringify(node.getBoundingClientRect());
  await document.fonts.ready;
  for (let still = 0, last = ""; still < 3;) {
    await new Promise(requestAnimationFrame);
    still = place() === last ? still + 1 : 0;
    last = place();
  }
}"""


@pytest.fixture(scope="session")
def browser(chromium: str) -> Iterator[Browser]:
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium, headless=True, args=FLAGS)
        yield running
        running.close()


MARKS = itertools.count(1)


def until_told(page: Page) -> None:
    """Waits until a page has been sent everything there is when it comes."""
    page.evaluate(
        "import('/wire.js').then(w => new Promise(done => w.on('library', () => done(true))))"
    )


class Desk:
    """What a test drives: the page, and the workbench behind it to look at."""

    def __init__(self, studio: Studio, page: Page) -> None:
        self.studio = studio
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.open()

    @property
    def workbench(self) -> Workbench:
        return self.studio.workbench

    @property
    def snapshot(self) -> Snapshot:
        return self.workbench.snapshot()

    def open(self) -> None:
        """Goes to the studio and waits until it has told the page what there is to see."""
        self.page.goto(self.studio.address)
        self.told()

    def reload(self) -> None:
        """Loads the page anew, and waits in the same way."""
        self.page.reload()
        self.told()

    def told(self) -> None:
        """Until the page has every panel; keys and clicks that came before have nothing to act on.

        The list of cases is the last that a page is sent when it comes.
        """
        until_told(self.page)

    def until(self, holds: Callable[[], Any], what: str = "", patience: float = PATIENCE) -> Any:
        """Waits until `holds` gives something true, which is returned."""
        ends, pause = time.monotonic() + patience, 10.0
        while time.monotonic() < ends:
            value = holds()
            if value:
                return value
            self.page.wait_for_timeout(pause)
            pause = min(1.3 * pause, 100.0)
        notices = [one.text for one in self.snapshot.notices]
        raise AssertionError(f"never happened: {what or holds}; notices: {notices}")

    def heard(self) -> None:
        """Until the studio has carried out what the page has sent: messages keep their order."""
        mark = f"{next(MARKS):012x}"
        send = "token => import('/wire.js').then(w => w.send({ do: 'viewer', token }))"
        self.until(lambda: self.page.evaluate(send, mark), "a line to the studio")
        self.until(lambda: mark in self.studio.tokens.values(), "what the page has sent")
        again = "import('/wire.js').then(w => w.send({ do: 'viewer', token: w.viewerToken }))"
        self.page.evaluate(again)

    def shown(self) -> None:
        """Until the page has drawn what the workbench holds now."""
        now, mark = self.snapshot.revision, next(MARKS)
        self.until(lambda: self.studio.snapshot.revision >= now, "the studio's own picture of it")
        self.studio.later(lambda: self.studio.hub.tell(None, "mark", mark))
        there = "mark => import('/wire.js').then(w => (w.value('mark') || 0) >= mark)"
        self.until(lambda: self.page.evaluate(there, mark), "it on the page")

    def idle(self) -> None:
        """Until everything that was asked for is done, and the page shows it."""
        self.heard()
        assert self.workbench.wait(PATIENCE)
        self.until(lambda: self.snapshot.busy is None, "nothing is running")
        self.shown()

    def drawn(self) -> None:
        """Until the page shows what a hand has just done: until then it shows what was before."""
        self.page.evaluate(DRAWN)

    def box(self, found: Locator) -> FloatRect:
        """Where something is on the page, once it stays there: for a hand that goes there."""
        found.evaluate(STILL)
        box = found.bounding_box()
        assert box is not None
        return box

    def button(self, name: str) -> Any:
        return self.page.get_by_role("button", name=name, exact=True)

    def empty_scene(self) -> None:
        """Opens an empty scene and goes to where things are added to it."""
        self.button("Open…").click()
        self.button("Empty scene").click()
        self.until(lambda: self.snapshot.case and self.snapshot.case.image is None, "a scene")
        # The page is drawn anew for it, and a click on its old tab goes for nothing.
        table = self.button("Table")
        self.until(lambda: self.tab("Scene") or table.is_visible(), "where things are added")

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name).click()

    def proposal(self) -> Any:
        """The open proposal, waiting for it."""
        found = self.until(
            lambda: (
                self.snapshot.busy is None
                and self.snapshot.state.phase == "decide"
                and self.snapshot.state.current
                and self.snapshot.state.current.proposal
            ),
            "a proposal",
        )
        expect(self.page.get_by_role("group", name="Proposal")).to_be_visible()
        return found


@dataclass(frozen=True)
class Hard:
    """An event of an example whose first program does not make it happen.

    opened, decide: workspaces whose one session was just opened, or stands at the first proposal.
    """

    opened: Path
    decide: Path


@pytest.fixture(scope="session")
def hard(prepared: Path) -> Hard:
    """Such an event of the examples; prepared once, also for several processes of tests."""
    root = prepared / "hard"
    mine, found = root / "mine", root / "found"
    root.mkdir(exist_ok=True)
    try:
        mine.mkdir()
    except FileExistsError:
        ends = time.monotonic() + 2 * PATIENCE
        while not found.exists():
            assert time.monotonic() < ends, "another process of tests prepares no session"
            time.sleep(0.1)
    else:
        partial = found.with_suffix(".partial")
        partial.write_text(_prepared(root))
        partial.rename(found)
    event = found.read_text()
    return Hard(root / "opened" / event, root / "decide" / event)


def _prepared(root: Path) -> str:
    """The first event of the examples that needs a repair; in both folders is one of its name."""
    cases = sorted(assets_dir().glob("*/case.yaml"), key=lambda path: path.parent.name != "demo")
    for case in cases:
        events = yaml.safe_load(case.read_text())["events"]
        # Where something has to stay as it is, the first program fails more often.
        for event in sorted(events, key=lambda name: "stay" not in name):
            opened, decide = root / "opened" / event, root / "decide" / event
            _carried_out(opened, commands.OpenCase(case.parent, event))
            shutil.copytree(opened, decide)
            opening = commands.OpenSession(Store(decide).list()[0].id)
            if _carried_out(decide, opening, commands.Step()) == "decide":
                return event
    raise AssertionError("every event of every example happens at the first try")


def _carried_out(root: Path, *wanted: commands.Command) -> str:
    """Does these in a workspace; the phase in which its session is then."""
    workbench = Workbench(Store(root), evidence=False)
    for command in wanted:
        workbench.post(command)
    assert workbench.wait(2 * PATIENCE)
    phase = workbench.snapshot().state.phase
    workbench.close()
    return phase


@pytest.fixture(scope="session")
def decided_once(hard: Hard) -> Path:
    """A workspace whose one session stands at the first proposal."""
    return hard.decide


@pytest.fixture
def fresh(tmp_path: Path, browser: Browser, hard: Hard) -> Iterator[Desk]:
    """A studio with an example just opened, on an event that needs a repair."""
    root = tmp_path / "workspace"
    shutil.copytree(hard.opened, root)
    yield from running(root, browser, Store(root).list()[0].id)


@pytest.fixture
def drawn(
    tmp_path: Path, browser: Browser, decided_once: Path, brief_search: None
) -> Iterator[Desk]:
    """The same, with the 3D scene drawn."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id, scene=True)


@pytest.fixture
def waiting(
    tmp_path: Path, browser: Browser, decided_once: Path, brief_search: None
) -> Iterator[Desk]:
    """A studio with a proposal that waits for a decision."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id)


@pytest.fixture
def brief_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """A repair is searched for in few runs: here only what is done with it matters."""
    monkeypatch.setattr(engine, "RulePlanner", lambda: RulePlanner(limit=8))
    brief = replace(goal_search.GOAL, max_runs=12)
    monkeypatch.setattr(goal_search, "GOAL", brief)


def running(
    root: Path,
    browser: Browser,
    session: str = "",
    *,
    scene: bool = False,
    tour: bool = False,
    pictures: bool = False,
) -> Iterator[Desk]:
    """A studio over a workspace with that session open, and a page on it.

    tour: as for whoever comes first. pictures: with the frames of the strip.

    Drawing in software takes most of the machine, so only tests that look at the scene, or at the
    sampled frames of a round, get them.
    """
    workbench = Workbench(Store(root), evidence=False)
    if session:
        workbench.post(commands.OpenSession(session))
    assert workbench.wait(PATIENCE)
    studio = serve(workbench, port=0)
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(1000 * PATIENCE)
    if not tour:
        page.add_init_script("localStorage.setItem('studio.toured', 'true')")
    # The playhead stays where a test puts it.
    page.add_init_script("localStorage.setItem('studio.autoplay', 'false')")
    if not scene:
        page.route("**/viewer/**", lambda route: route.fulfill(body=""))
    if not pictures:
        page.route("**/frame/**", lambda route: route.fulfill(body=DOT, content_type="image/jpeg"))
    desk = Desk(studio, page)
    yield desk
    errors = list(desk.errors)
    page.close()
    studio.stop()
    workbench.close()
    assert errors == []
