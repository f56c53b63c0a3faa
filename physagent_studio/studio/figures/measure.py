"""Measures a studio: from an intent to the wire, and in a real browser where there is one."""

import gc
import json
import random
import statistics
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from websockets.sync.connection import Connection

from physagent_studio.assets import assets_dir
from physagent_studio.program import SetField
from physagent_studio.studio.figures.browser import in_a_browser
from physagent_studio.studio.figures.masks import four_masks
from physagent_studio.studio.figures.wire import (
    PATIENCE,
    Figure,
    Wire,
    drifting,
    lengthen,
    memory,
    open_page,
    open_viewer,
    p95,
    running,
    settle,
    until,
)
from physagent_studio.workbench import commands

OBJECTS = 50


def measure_studio(
    *,
    scrubs: int = 1000,
    drops: int = 40,
    dragged: int = 200,
    rounds: int = 50,
    many: int = 200,
    browser: bool = True,
    watched: float = 4.0,
    photos: Sequence[Path] = (),
) -> list[Figure]:
    """All figures. The rows of a real browser are left out where none is installed.

    photos: folders of cases in whose photos things are clicked.
    """
    return [
        *_motion(scrubs, watched),
        *four_masks(photos),
        *_demo(drops, dragged, browser),
        _rounds(rounds),
        _opening(many),
    ]


# --- playing and scrubbing ---------------------------------------------------------------------


def _motion(scrubs: int, watched: float) -> list[Figure]:
    with running(commands.OpenProgram(drifting(OBJECTS), "bench")) as studio:
        opened = time.perf_counter()
        with open_page(studio) as page, open_viewer(studio) as viewer:
            until(page, "timeline")
            usable = time.perf_counter() - opened
            Wire(page)  # a page that is not read would be closed
            wire = Wire(viewer)
            settle(studio)
            delays = [_scrub(page, wire, frame % 81) for frame in range(1, 101)]
            before = memory()
            for frame in range(scrubs):
                page.send(json.dumps({"do": "scrub", "frame": frame % 81}))
            settle(studio)
            grown = memory() - before
            rate, share = _play(page, wire, watched)
    return [
        Figure(f"scrub to pose on the wire, {OBJECTS} objects, p95", p95(delays), "ms", 10),
        Figure("page's values after opening", usable * 1000, "ms", 3000),
        Figure(f"playback frames a second, {OBJECTS} objects", rate, "1/s", 30, above=True),
        Figure(f"share of a core while playing, {OBJECTS} objects", share * 100, "%", 25),
        Figure(f"memory grown over {scrubs} scrubs", max(grown, 0.0), "MB", 5),
    ]


def _scrub(page: Connection, wire: Wire, frame: int) -> float:
    delay = wire.after(lambda: page.send(json.dumps({"do": "scrub", "frame": frame})))
    time.sleep(0.03)  # a hand moves on; the next one is measured by itself
    return delay


def _play(page: Connection, wire: Wire, seconds: float) -> tuple[float, float]:
    """Frames a second on the wire, and the share of one core, while playing."""
    page.send(json.dumps({"do": "play", "on": True}))
    time.sleep(0.3)
    count, used, started = wire.count, time.process_time(), time.perf_counter()
    time.sleep(seconds)
    passed = time.perf_counter() - started
    share = (time.process_time() - used) / passed
    rate = (wire.count - count) / passed
    page.send(json.dumps({"do": "play", "on": False}))
    return rate, share


# --- editing the demo --------------------------------------------------------------------------


def _demo(drops: int, dragged: int, browser: bool) -> list[Figure]:
    with running(commands.OpenCase(assets_dir() / "demo", "knocks_block_over")) as studio:
        studio.workbench.post(commands.Step())
        studio.workbench.wait(PATIENCE)
        action = studio.workbench.snapshot().program.event.actions[0].id
        with open_page(studio) as page, open_viewer(studio) as viewer:
            until(page, "timeline")
            Wire(page)
            wire = Wire(viewer)
            settle(studio)
            dropped = [_drop(page, wire, action, 8 + 4 * (n % 20)) for n in range(drops)]
            before = memory()
            for n in range(dragged):
                _drag(page, action, 8 + 4 * (n % 20))
            settle(studio)
            grown = memory() - before
        return [
            Figure("bar dropped to new trajectory on the wire, demo, p95", p95(dropped), "ms", 400),
            Figure(f"memory grown over {dragged} dragged bars", max(grown, 0.0), "MB", 100),
            *(in_a_browser(studio, action) if browser else ()),
        ]


def _drag(page: Connection, action: str, step: int) -> None:
    """A bar under the pointer, tried on its way and then let go."""
    for at in (step - 2, step - 1):
        edit = {"op": "set", "path": f"event.actions.{action}.start_step", "value": at}
        page.send(json.dumps({"do": "try", "edits": [edit]}))
        time.sleep(0.02)
    edit = {"op": "set", "path": f"event.actions.{action}.start_step", "value": step}
    page.send(json.dumps({"do": "edit", "edits": [edit], "reason": "timeline", "ticket": 1}))
    time.sleep(0.05)


def _drop(page: Connection, wire: Wire, action: str, step: int) -> float:
    edit = {"op": "set", "path": f"event.actions.{action}.start_step", "value": step}
    text = json.dumps({"do": "edit", "edits": [edit], "reason": "timeline", "ticket": 1})
    delay = wire.after_naming(lambda: page.send(text), b"/trails/now/")
    time.sleep(0.05)
    return delay


# --- many rounds -------------------------------------------------------------------------------


def _rounds(rounds: int) -> Figure:
    """Hand-made rounds one after the other; what they leave in memory besides themselves."""
    with running(commands.OpenProgram(drifting(8), "bench")) as studio:
        workbench = studio.workbench
        with open_page(studio) as page, open_viewer(studio) as viewer:
            Wire(page)
            Wire(viewer)
            before = 0.0
            for number in range(rounds + 10):
                if number == 10:  # what is kept once is there by then
                    settle(studio)
                    before = memory()
                path = "event.actions.go_ball_0.start_step"
                workbench.post(commands.ApplyEdits((SetField(path=path, value=number + 1),)))
                workbench.post(commands.Step())
                workbench.wait(60)
            settle(studio)
            grown = memory() - before
    return Figure(f"memory grown over {rounds} rounds", max(grown, 0.0), "MB", 25)


def _listed(value: Any) -> int:
    """How many rounds a history has: those that are listed, and those before and after them."""
    beyond = [value[side]["count"] for side in ("before", "after") if value[side]]
    return len(value["rounds"]) + sum(beyond)


def _opening(rounds: int) -> Figure:
    with running(commands.OpenProgram(drifting(3), "bench")) as studio:
        workbench = studio.workbench
        workbench.post(commands.Step())
        workbench.wait(60)
        session_id = workbench.snapshot().session_id
        assert session_id is not None
        workbench.post(commands.OpenProgram(drifting(1), "another"))
        workbench.wait(60)
        lengthen(workbench.store, session_id, rounds)
        with open_page(studio) as page:
            until(page, "rounds")
            started = time.perf_counter()
            workbench.post(commands.OpenSession(session_id))
            until(page, "rounds", lambda value: _listed(value) == rounds)
            seconds = time.perf_counter() - started
    return Figure(f"{rounds} rounds open after", seconds * 1000, "ms", 2000)


HOUR = 3600.0
"""Seconds."""
WARM_UP = 600.0
"""Seconds after which what is kept on purpose is there; in short runs a third of them."""
SCRUB_SECONDS = 1 / 30
"""Between two frames that a hand on the timeline asks for."""
MARKS = 120
"""How often memory is read over the run."""
SHORT_RUN_MB = 5.0
"""Over minutes the noise of the allocator is more than what an hour may add."""


def soaked(seconds: float) -> list[Figure]:
    """Memory's slope and the threads that are left, over `seconds` after a warm-up."""
    with running() as studio:
        studio.workbench.post(commands.OpenCase(assets_dir() / "demo"))
        studio.workbench.post(commands.Step())
        studio.workbench.wait(300)
        with open_page(studio) as page, open_viewer(studio) as view:
            Wire(page)
            Wire(view)
            page.send(json.dumps({"do": "play", "on": True}))
            rng, marks = random.Random(0), list[tuple[float, float, int]]()

            def scrub_for(how_long: float) -> None:
                until = time.monotonic() + how_long
                while time.monotonic() < until:
                    page.send(json.dumps({"do": "scrub", "frame": rng.randrange(80)}))
                    time.sleep(SCRUB_SECONDS)

            scrub_for(min(WARM_UP, seconds / 3))
            began = time.monotonic()
            for _ in range(MARKS):
                scrub_for(seconds / MARKS)
                # The interpreter keeps up to 2000 tuples of each length until then: half a megabyte
                # comes together within an hour, and no more.
                gc.collect()
                marks.append((time.monotonic() - began, memory(), threading.active_count()))
            settle(studio)
    return _figures(seconds, marks)


def _figures(seconds: float, marks: list[tuple[float, float, int]]) -> list[Figure]:
    times, held, threads = zip(*marks, strict=True)
    words = f"{seconds:g} s of the demo's loop, scrubbed at 30 Hz"
    grown = statistics.linear_regression(times, held).slope * min(seconds, HOUR)
    bound = 1.0 if seconds >= HOUR else SHORT_RUN_MB
    return [
        Figure(f"memory grown by its slope over {words}", grown, "MB", bound),
        Figure(f"threads grown over {words}", threads[-1] - threads[0], "", 0),
    ]
