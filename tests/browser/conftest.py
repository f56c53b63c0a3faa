"""A real studio on a free port and a real Chromium; polling with deadlines, never sleeping."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from playwright.sync_api import Browser, Page, expect, sync_playwright

from physagent_studio.assets import assets_dir
from physagent_studio.session import Store
from physagent_studio.studio import Studio, serve
from physagent_studio.workbench import Snapshot, Workbench, commands

FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
]  # fmt: skip
PATIENCE = 60.0

expect.set_options(timeout=20_000)


@pytest.fixture(scope="session")
def browser(chromium: str) -> Iterator[Browser]:
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium, headless=True, args=FLAGS)
        yield running
        running.close()


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
        self.page.wait_for_function(
            "import('/wire.js').then(wire => Boolean(wire.value('playhead')))"
        )

    def until(self, holds: Callable[[], Any], what: str = "", patience: float = PATIENCE) -> Any:
        """Waits until `holds` gives something true, which is returned."""
        ends = time.monotonic() + patience
        while time.monotonic() < ends:
            value = holds()
            if value:
                return value
            self.page.wait_for_timeout(25)
        notices = [one.text for one in self.snapshot.notices]
        raise AssertionError(f"never happened: {what or holds}; notices: {notices}")

    def idle(self) -> None:
        """Until everything that was asked for is done."""
        self.page.wait_for_timeout(100)
        assert self.workbench.wait(PATIENCE)
        self.until(lambda: self.snapshot.busy is None, "nothing is running")

    def button(self, name: str) -> Any:
        return self.page.get_by_role("button", name=name, exact=True)

    def empty_scene(self) -> None:
        """Opens an empty scene and goes to where things are added to it."""
        self.button("Open…").click()
        self.button("Empty scene").click()
        self.until(lambda: self.snapshot.case and self.snapshot.case.image is None, "a scene")
        self.tab("Scene")

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

    root: a workspace whose one session stands at the first proposal for it.
    """

    case: Path
    event: str
    root: Path


@pytest.fixture(scope="session")
def hard(tmp_path_factory: pytest.TempPathFactory) -> Hard:
    """The first such event of the examples; prepared once, its workspace copied by tests."""
    cases = sorted(assets_dir().glob("*/case.yaml"), key=lambda path: path.parent.name != "demo")
    for case in cases:
        for event in yaml.safe_load(case.read_text())["events"]:
            root = tmp_path_factory.mktemp("prepared")
            workbench = Workbench(Store(root), evidence=False)
            workbench.post(commands.OpenCase(case.parent, event))
            workbench.post(commands.Step())
            assert workbench.wait(240)
            phase = workbench.snapshot().state.phase
            workbench.close()
            if phase == "decide":
                return Hard(case.parent, event, root)
    raise AssertionError("every event of every example happens at the first try")


@pytest.fixture(scope="session")
def decided_once(hard: Hard) -> Path:
    """A workspace whose one session stands at the first proposal."""
    return hard.root


@pytest.fixture
def fresh(tmp_path: Path, browser: Browser, hard: Hard) -> Iterator[Desk]:
    """A studio with an example just opened, on an event that needs a repair."""
    yield from running(tmp_path / "workspace", browser, event=hard.event, case=hard.case)


@pytest.fixture
def drawn(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The same, with the 3D scene drawn."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id, scene=True)


@pytest.fixture
def waiting(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """A studio with a proposal that waits for a decision."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id)


def running(
    root: Path,
    browser: Browser,
    session: str = "",
    *,
    event: str | None = None,
    case: Path | None = None,
    scene: bool = False,
    tour: bool = False,
    nothing: bool = False,
) -> Iterator[Desk]:
    """A studio over a workspace, and a page on it; `tour`: as for whoever comes first;
    `nothing`: with no session open.

    Drawing in software takes most of the machine, so only tests that look at the scene get one.
    """
    workbench = Workbench(Store(root), evidence=False)
    if nothing:
        pass
    elif not session:
        workbench.post(commands.OpenCase(case or assets_dir() / "demo", event))
    else:
        workbench.post(commands.OpenSession(session))
    assert workbench.wait(60)
    studio = serve(workbench, port=0)
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    if not tour:
        page.add_init_script("localStorage.setItem('studio.toured', 'true')")
    if not scene:
        page.route("**/viewer/**", lambda route: route.fulfill(body=""))
    desk = Desk(studio, page)
    yield desk
    errors = list(desk.errors)
    page.close()
    studio.stop()
    workbench.close()
    assert errors == []
