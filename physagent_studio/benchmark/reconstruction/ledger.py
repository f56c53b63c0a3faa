"""`physagent bench ledger`: what each heuristic of the segmenter is worth on pictures it never saw.

Every heuristic is left out by itself; over the things whose result that changes it has to raise the
mean IoU by `WORTH` and to help `MORE` things more than it hurts. Those that do not are deleted, so
that what was measured of them stays in the report as it is, below the heading `DELETED`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.rows import Row, shown
from physagent_studio.benchmark.scenes import Pictured, scene
from physagent_studio.language import hints
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.masks.foot_spill import sound_masks
from physagent_studio.reconstruction.masks.grabcut import SEED
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.switches import HEURISTICS, without
from physagent_studio.records.case import Image

SEEDS = range(1000, 1060)
"""Pictures of the ledger."""
WORTH, MORE = 0.01, 5
"""Mean gain in IoU, and things helped more than hurt, which a heuristic has to show."""
CHANGED = 0.001
"""Difference in IoU from which a result is another one."""
ROUNDS = 4
"""Iterations of the plain GrabCut that results are held against."""
DELETED = "## Deleted"
WAYS = ("click", "box")

Results = dict[tuple[int, str, str], float]
"""IoU by seed, how it was marked, and name of the thing."""


@dataclass(frozen=True, slots=True)
class Entry:
    """What a heuristic does to the things whose result it changes: how many, and IoU gained."""

    name: str
    changed: int
    helped: int
    hurt: int
    gain: float

    @property
    def stays(self) -> bool:
        """Whether it earns its place."""
        return self.gain >= WORTH and self.helped - self.hurt >= MORE

    @property
    def line(self) -> str:
        """Its row in the table."""
        verdict = "stays" if self.stays else "to be deleted"
        figures = f"{self.changed} | {self.helped} | {self.hurt} | {self.gain:+.3f}"
        return f"| {self.name} | {HEURISTICS[self.name]} | {figures} | {verdict} |"


def bench(
    cases: Path | None = None, out: Path | None = None, seeds: Iterable[int] = SEEDS
) -> list[Row]:
    """How well things are cut out, and what each heuristic adds to it."""
    with_all: Results = {}
    left_out: dict[str, Results] = {name: {} for name in HEURISTICS}
    plain: list[float] = []
    for seed in seeds:
        drawn = scene(seed)
        plain += [
            iou(plain_cut(drawn.image, s.box.box), s.mask) for s in drawn.subjects if s.box.box
        ]
        for way in WAYS:
            found, asked = results(seed, drawn, way)
            with_all |= found
            for name in asked & HEURISTICS.keys():
                left_out[name] |= results(seed, drawn, way, (name,))[0]
    entries = [entry_of(name, with_all, found) for name, found in left_out.items()]
    rows = _figures(with_all, plain)
    if out is not None:
        _write(out, rows, entries)
    return [*rows, *(shown(f"{one.name}: mean change", one.gain) for one in entries)]


def results(
    seed: int, drawn: Pictured, way: str, left_out: Sequence[str] = ()
) -> tuple[Results, set[str]]:
    """The IoU of each thing with some heuristics left out, and which were asked for."""
    said = [(s.name, s.click if way == "click" else s.box) for s in drawn.subjects]
    with without(left_out) as asked:
        offers = EmbeddedSegmenter().segment(drawn.image, said)
        masks = choose(offers, said, drawn.image.shape[:2], drawn.image)
        things = [SceneObject(name=name, grounding=own) for name, own in said]
        masks = sound_masks(drawn.image, masks, things, hints("", [name for name, _ in said], []))
    return {(seed, way, s.name): iou(masks[s.name], s.mask) for s in drawn.subjects}, set(asked)


def entry_of(name: str, with_all: Results, left_out: Mapping[tuple[int, str, str], float]) -> Entry:
    """What a heuristic changes, from results with it and without."""
    gains = np.array([with_all[key] - value for key, value in left_out.items()])
    gains = gains[np.abs(gains) >= CHANGED]
    mean = float(gains.mean()) if len(gains) else 0.0
    return Entry(name, len(gains), int((gains > 0).sum()), int((gains < 0).sum()), mean)


def plain_cut(image: Image, box: tuple[float, float, float, float]) -> NDArray[np.bool_]:
    """(H, W) what OpenCV's GrabCut makes of a box, and nothing else."""
    x0, y0 = (max(0, int(value)) for value in box[:2])
    x1, y1 = min(image.shape[1], int(box[2]) + 1), min(image.shape[0], int(box[3]) + 1)
    labels = np.zeros(image.shape[:2], np.uint8)
    cv2.setRNGSeed(SEED)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    area = (x0, y0, x1 - x0, y1 - y0)
    cv2.grabCut(image, labels, area, *models, ROUNDS, cv2.GC_INIT_WITH_RECT)
    return (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)


def _figures(with_all: Results, plain: Sequence[float]) -> list[Row]:
    by_way = {way: [v for (_, how, _), v in with_all.items() if how == way] for way in WAYS}
    rows = [shown("things", len(plain))]
    for way, values in (*by_way.items(), ("plain GrabCut from the box", plain)):
        rows.append(shown(f"{way}: mask IoU, median", float(np.median(values))))
        rows.append(shown(f"{way}: mask IoU, lower quarter", float(np.percentile(values, 25))))
    return rows


def _write(out: Path, rows: Sequence[Row], entries: Sequence[Entry]) -> None:
    """The report; what was measured of heuristics that are gone is kept."""
    before = out.read_text(encoding="utf-8") if out.is_file() else ""
    gone = before[before.index(DELETED) :] if DELETED in before else f"{DELETED}\n"
    lines = [
        "# Ledger of the segmenter's heuristics",
        "",
        f"Made by `physagent bench ledger --out docs/ledger.md` on pictures {SEEDS[0]} to",
        f"{SEEDS[-1]} of `benchmark/scenes`. Changed, helped, hurt: things whose mask is another",
        "with the heuristic than without, by click and by box. A heuristic stays that raises the",
        f"mean IoU of the things it changes by {WORTH} and helps {MORE} more than it hurts.",
        "",
        "| figure | value |",
        "|---|---|",
        *(f"| {row.name} | {row.value:.3g} |" for row in rows),
        "",
        "## At work",
        "",
        "| heuristic | what it does | changed | helped | hurt | mean change | verdict |",
        "|---|---|---|---|---|---|---|",
        *(entry.line for entry in entries),
        "",
    ]
    out.write_text("\n".join(lines) + "\n" + gone, encoding="utf-8")
