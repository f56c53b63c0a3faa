"""How soon the four masks are there after a click in the photo, or a box: from page to page."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from websockets.sync.connection import Connection

from physagent_studio.assets import assets_dir
from physagent_studio.program.scene import Grounding
from physagent_studio.records import Scene
from physagent_studio.studio.figures.figure import Figure
from physagent_studio.studio.figures.wire import open_page, settle, until
from physagent_studio.studio.studio import Studio
from physagent_studio.workbench import commands

EXAMPLES = ("demo", "table", "cans")
SOON = 1.0
"""Seconds that nobody minds to wait."""
WIDER = 0.04
"""By how much a box that a hand draws is wider than the thing, on each side."""

Running = Callable[[commands.Command], AbstractContextManager[Studio]]


def examples(cases: Path | None) -> list[Path]:
    """The cases in a folder; those that the package comes with where none is given."""
    if cases is None:
        return [assets_dir() / name for name in EXAMPLES]
    return sorted(path.parent for path in cases.glob("*/case.yaml"))


def four_masks(folders: Sequence[Path], running: Running) -> list[Figure]:
    """Seconds from asking to the answer on the wire, over all things in some cases.

    Every thing is clicked a pixel beside where the case has it, so that nothing is known of it.
    """
    seconds: dict[str, list[float]] = {"click": [], "box": []}
    for folder in folders:
        with running(commands.OpenCase(folder)) as studio, open_page(studio) as page:
            settle(studio)
            for kind, name, said in _asked(studio):
                seconds[kind].append(_answered(page, name, said, len(seconds[kind])))
    return [
        Figure(f"four masks after a {kind}, {len(took)} things, {word}", value(took), "s", SOON)
        for kind, took in seconds.items()
        if took
        for word, value in (("median", statistics.median), ("slowest", max))
    ]


def _asked(studio: Studio) -> Iterator[tuple[str, str, Grounding]]:
    """What is asked in one photo: a click on each thing, and a box around it."""
    snapshot = studio.workbench.snapshot()
    for item in snapshot.program.scene.objects:
        points = item.grounding.points
        if any(click.label for click in points):
            beside = tuple(c.model_copy(update={"x": max(c.x - 1, 0)}) for c in points)
            yield "click", item.name, Grounding(points=beside)
        box = _box(snapshot.scene, item.name)
        if box is not None:
            yield "box", item.name, Grounding(box=box)


def _box(scene: Scene | None, name: str) -> tuple[float, float, float, float] | None:
    """A box (x0, y0, x1, y1) around what the scene takes for a thing, pixels."""
    mask: NDArray[np.bool_] | None = None if scene is None else scene.masks.get(name)
    if mask is None or not mask.any():
        return None
    rows, columns = np.nonzero(mask)
    pad_x, pad_y = WIDER * np.ptp(columns) + 1, WIDER * np.ptp(rows) + 1
    height, width = mask.shape
    low = (max(float(columns.min() - pad_x), 0.0), max(float(rows.min() - pad_y), 0.0))
    high = (float(columns.max() + pad_x), float(rows.max() + pad_y))
    return (*low, min(high[0], width - 1.0), min(high[1], height - 1.0))


def _answered(page: Connection, name: str, said: Grounding, ticket: int) -> float:
    """Seconds until the page has the masks; what is still added to them is waited for as well."""
    grounding = said.model_dump(mode="json")
    text = json.dumps({"do": "masks", "name": name, "grounding": grounding, "ticket": ticket})
    started = time.perf_counter()
    page.send(text)
    answer = until(page, "masks", lambda value: value["ticket"] == ticket)
    took = time.perf_counter() - started
    while answer.get("more"):
        answer = until(page, "masks", lambda value: value["ticket"] == ticket)
    return took
