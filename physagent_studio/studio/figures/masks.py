"""How soon the four masks are there after a click in the photo, or a box: from page to page."""

import json
import statistics
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from websockets.sync.connection import Connection

from physagent_studio.arrays import BoolArray
from physagent_studio.assets import assets_dir
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.choice import CHOICE
from physagent_studio.records import Scene
from physagent_studio.studio.figures.wire import Figure, open_page, running, settle, until
from physagent_studio.studio.studio import Studio
from physagent_studio.workbench import commands

EXAMPLES = ("demo", "table", "cans")
SOON, LATER = 1.0, 2.0
"""Seconds that nobody minds to wait for masks, and after which none of them should change."""
WIDER = 0.04
"""By how much a box that a hand draws is wider than the thing, on each side."""


def examples(cases: Path | None) -> list[Path]:
    """The cases in a folder; those that the package comes with where none is given."""
    if cases is None:
        return [assets_dir() / name for name in EXAMPLES]
    return sorted(path.parent for path in cases.glob("*/case.yaml"))


def four_masks(folders: Sequence[Path]) -> list[Figure]:
    """Seconds from asking to four masks on the wire, over all things in some cases.

    Where finding takes longer, four are shown early; those that stand in the end are timed as well.
    Every thing is clicked a pixel beside where the case has it, so that nothing is known of it.
    """
    seconds: dict[tuple[str, bool], list[float]] = {}
    for folder in folders:
        with running(commands.OpenCase(folder)) as studio, open_page(studio) as page:
            settle(studio)
            for ticket, (kind, name, said) in enumerate(_asked(studio)):
                for settled, took in enumerate(_answered(page, name, said, ticket)):
                    seconds.setdefault((kind, bool(settled)), []).append(took)
    words = {False: "four masks after", True: "no closer look to come after"}
    return [
        Figure(
            f"{words[settled]} a {kind}, {len(took)} things, {word}",
            value(took),
            "s",
            LATER if settled else SOON,
        )
        for (kind, settled), took in sorted(seconds.items(), key=lambda item: item[0][1])
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
    mask: BoolArray | None = None if scene is None else scene.masks.get(name)
    if mask is None or not mask.any():
        return None
    rows, columns = np.nonzero(mask)
    pad_x, pad_y = WIDER * np.ptp(columns) + 1, WIDER * np.ptp(rows) + 1
    height, width = mask.shape
    low = (max(float(columns.min() - pad_x), 0.0), max(float(rows.min() - pad_y), 0.0))
    high = (float(columns.max() + pad_x), float(rows.max() + pad_y))
    return (*low, min(high[0], width - 1.0), min(high[1], height - 1.0))


def _answered(page: Connection, name: str, said: Grounding, ticket: int) -> tuple[float, float]:
    """Seconds until the page has four masks or all that there are, and until none of them changes.

    What the clicks on a whole stack give is added later; it is waited for, but not timed.
    """
    grounding = said.model_dump(mode="json")
    text = json.dumps({"do": "masks", "name": name, "grounding": grounding, "ticket": ticket})
    started, four = time.perf_counter(), None

    def next_one() -> dict[str, Any]:
        return until(page, "masks", lambda value: value["ticket"] == ticket)

    page.send(text)
    answer = next_one()
    while answer.get("early"):
        if four is None and len(answer["masks"]) >= CHOICE.max_offers_count:
            four = time.perf_counter() - started
        answer = next_one()
    took = time.perf_counter() - started
    while answer.get("more"):
        answer = next_one()
    return (took if four is None else four), took
