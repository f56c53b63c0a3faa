"""A long run: the demo plays in a loop and somebody scrubs; what that leaves in memory."""

from __future__ import annotations

import gc
import json
import random
import statistics
import threading
import time

from physagent_studio.assets import assets_dir
from physagent_studio.studio.figures.figure import Figure, memory
from physagent_studio.studio.figures.wire import Wire, open_page, open_viewer, running, settle
from physagent_studio.workbench import commands

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
