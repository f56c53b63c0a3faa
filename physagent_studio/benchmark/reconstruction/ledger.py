"""`physagent bench ledger`: what each heuristic is worth on pictures it never saw.

Every heuristic is left out by itself; over the results that this changes it has to raise the mean
by what its `Measure` asks for and to help `MORE` of them more than it hurts. Those that do not are
deleted, so that what was measured of them stays in the report, below the heading `DELETED`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.benchmark.reconstruction.plates import steps_of
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks
from physagent_studio.benchmark.rows import Row, shown
from physagent_studio.benchmark.scenes import Pictured, scene
from physagent_studio.benchmark.scenes.catalogue import turned_in_place
from physagent_studio.language import hints
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.reconstruction import photo_hash
from physagent_studio.reconstruction.background.plate import background, hole_of
from physagent_studio.reconstruction.masks.foot_spill import sound_masks
from physagent_studio.reconstruction.masks.grabcut import CUT
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.switches import BODIES, HEURISTICS, MASKS, PLATES, without
from physagent_studio.records.case import Case, Image

SHADE = 8.0
"""Grey levels by which what a thing shades or is mirrored in differs from the empty picture."""
TURN = math.pi / 2
"""By how much bodies are turned about the vertical to be seen from another side."""


def plates(
    seed: int, drawn: Pictured, way: str, left_out: Sequence[str]
) -> tuple[Results, set[str]]:
    """Minus the error of the background from true masks and camera, grey levels."""
    masks = [subject.mask for subject in drawn.subjects]
    with without(left_out) as asked:
        found = segments(drawn.image)
        plate = background(drawn.image, masks, camera=drawn.stage.camera, found=found)
    error = _error(drawn.image, drawn.emptied(), plate, hole_of(masks, plate.shape[:2]))
    return {(seed, way, "background"): -error}, set(asked)


def _error(image: Image, empty: Image, plate: Image, hole: NDArray[np.bool_]) -> float:
    """Error of tone and of steps, over all that was to be taken out or was changed beside it."""
    made, truth, seen = (picture.astype(np.float32) for picture in (plate, empty, image))
    off = np.abs(cv2.GaussianBlur(made - truth, (0, 0), 2.0)).mean(-1)
    off += np.abs(cv2.GaussianBlur(steps_of(made) - steps_of(truth), (0, 0), 3.0))
    shade = np.abs(cv2.GaussianBlur(seen - truth, (0, 0), 1.0)).mean(-1) > SHADE
    changed = hole | shade | (plate != image).any(-1)
    return float(off[changed].sum() / np.count_nonzero(hole | shade))


def bodies(
    seed: int, drawn: Pictured, way: str, left_out: Sequence[str]
) -> tuple[Results, set[str]]:
    """IoU of each drawn body with the true thing, as it stands and turned about the vertical."""
    truth = TrueMasks({s.name: s.mask for s in drawn.subjects})
    said = tuple((s.name, s.box) for s in drawn.subjects)
    things = tuple(SceneObject(name=name, grounding=own) for name, own in said)
    state = SceneState(camera=drawn.stage.camera, objects=things)
    hashed = photo_hash(drawn.image)
    case = Case("drawn", drawn.image, hashed, said, (), (), "The objects stay.")
    with without(left_out) as asked:
        made = reconstruct(case, state, segmenter=truth)
    out: Results = {}
    camera = drawn.stage.camera
    for item, subject in zip(made.state.objects, drawn.subjects, strict=True):
        mesh = made.meshes[item.name]
        shown = silhouette(camera, in_world(item, mesh), mesh.faces)
        out[seed, way, item.name] = iou(shown, subject.mask)
        shown = silhouette(camera, _turned(in_world(item, mesh)), mesh.faces)
        whose = drawn.stage.taken_of([turned_in_place(subject.thing, TURN)])[1]
        out[seed, way, f"{item.name}, turned"] = iou(shown, whose == 0)
    return out, set(asked)


def _turned(world: FloatArray) -> FloatArray:
    """Vertices (V, 3) turned about the vertical through the middle of their bounds."""
    middle = (world.min(0) + world.max(0)) / 2
    return (world - middle) @ matrix_of(about_up(TURN)).T + middle


SEEDS = range(1000, 1060)
"""Pictures of the ledger."""
MORE = 5
"""Results helped more than hurt, which a heuristic has to show."""
CHANGED = 0.1
"""Difference from which a result is another one, in what its measure asks for."""
ROUNDS = 4
"""Iterations of the plain GrabCut that results are held against."""
DELETED = "## Deleted"
WAYS = ("click", "box")

Results = dict[tuple[int, str, str], float]
"""What is the more the better, by seed, way of looking at it, and name of the thing."""


@dataclass(frozen=True, slots=True)
class Measure:
    """What heuristics are held to. results: of a seed, its picture, a way, and what is left out.

    worth: mean gain that a heuristic has to show, in `unit`.
    """

    unit: str
    worth: float
    heuristics: Mapping[str, str]
    ways: tuple[str, ...]
    results: Callable[[int, Pictured, str, Sequence[str]], tuple[Results, set[str]]]


@dataclass(frozen=True, slots=True)
class Entry:
    """What a heuristic does to the results it changes: how many, and by how much in the mean.

    worth: what that has to be.
    """

    name: str
    worth: float
    changed: int
    helped: int
    hurt: int
    gain: float

    @property
    def stays(self) -> bool:
        """Whether it earns its place."""
        return self.gain >= self.worth and self.helped - self.hurt >= MORE

    @property
    def line(self) -> str:
        """Its row in the table."""
        verdict = "stays" if self.stays else "to be deleted"
        figures = f"{self.changed} | {self.helped} | {self.hurt} | {self.gain:+.3f}"
        return f"| {self.name} | {HEURISTICS[self.name]} | {figures} | {verdict} |"


def bench(
    cases: Path | None = None, out: Path | None = None, seeds: Iterable[int] = SEEDS
) -> list[Row]:
    """How well things are cut out, filled in and built, and what each heuristic adds to it."""
    plain: list[float] = []
    found = {name: ({}, {rule: {} for rule in own.heuristics}) for name, own in MEASURES.items()}
    for seed in seeds:
        drawn = scene(seed)
        plain += plain_cuts(drawn)
        for name, own in MEASURES.items():
            _measured(own, seed, drawn, *found[name])
    rows = _figures(found["masks"][0], plain)
    entries = {
        name: [entry_of(rule, found[name][0], less, own.worth) for rule, less in left.items()]
        for (name, own), (_, left) in zip(MEASURES.items(), found.values(), strict=True)
    }
    if out is not None:
        _write(out, rows, entries)
    every = [one for own in entries.values() for one in own]
    return [*rows, *(shown(f"{one.name}: mean change", one.gain) for one in every)]


def _measured(
    own: Measure, seed: int, drawn: Pictured, with_all: Results, left_out: Mapping[str, Results]
) -> None:
    """Adds the results of a picture, with all heuristics and without each that is asked for."""
    for way in own.ways:
        found, asked = own.results(seed, drawn, way, ())
        with_all |= found
        for name in left_out.keys() & asked:
            left_out[name].update(own.results(seed, drawn, way, (name,))[0])


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


MEASURES = {
    "masks": Measure("IoU", 0.01, MASKS, WAYS, results),
    "background": Measure("grey levels", 0.25, PLATES, ("true masks",), plates),
    "bodies": Measure("IoU", 0.01, BODIES, ("true camera",), bodies),
}
"""By what is measured: masks, the filled background, and drawn bodies seen from other sides."""


def entry_of(
    name: str,
    with_all: Results,
    left_out: Mapping[tuple[int, str, str], float],
    worth: float = 0.01,
) -> Entry:
    """What a heuristic changes, from results with it and without."""
    gains = np.array([with_all[key] - value for key, value in left_out.items()])
    gains = gains[np.abs(gains) >= CHANGED * worth]
    mean = float(gains.mean()) if len(gains) else 0.0
    return Entry(name, worth, len(gains), int((gains > 0).sum()), int((gains < 0).sum()), mean)


def plain_cuts(drawn: Pictured) -> list[float]:
    """The IoU of each boxed thing as `plain_cut` has it."""
    return [iou(plain_cut(drawn.image, s.box.box), s.mask) for s in drawn.subjects if s.box.box]


def plain_cut(image: Image, box: tuple[float, float, float, float]) -> NDArray[np.bool_]:
    """(H, W) what OpenCV's GrabCut makes of a box, and nothing else."""
    x0, y0 = (max(0, int(value)) for value in box[:2])
    x1, y1 = min(image.shape[1], int(box[2]) + 1), min(image.shape[0], int(box[3]) + 1)
    labels = np.zeros(image.shape[:2], np.uint8)
    cv2.setRNGSeed(CUT.random_seed)
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


def _write(out: Path, rows: Sequence[Row], entries: Mapping[str, Sequence[Entry]]) -> None:
    """The report; what was measured of heuristics that are gone is kept."""
    before = out.read_text(encoding="utf-8") if out.is_file() else ""
    gone = before[before.index(DELETED) :] if DELETED in before else f"{DELETED}\n"
    lines = [
        "# Ledger of heuristics",
        "",
        f"Made by `physagent bench ledger --out docs/ledger.md` on pictures {SEEDS[0]} to",
        f"{SEEDS[-1]} of `benchmark/scenes`. Changed, helped, hurt: results that are others with",
        f"the heuristic than without. It stays where it helps {MORE} more than it hurts and raises",
        "the mean of those it changes by what the heading says.",
        "",
        "| figure | value |",
        "|---|---|",
        *(f"| {row.name} | {row.value:.3g} |" for row in rows),
        "",
    ]
    for name, own in entries.items():
        lines += [f"## At work: {name} ({MEASURES[name].worth:g} {MEASURES[name].unit})", ""]
        lines += ["| heuristic | what it does | changed | helped | hurt | mean change | verdict |"]
        lines += ["|---|---|---|---|---|---|---|", *(entry.line for entry in own), ""]
    out.write_text("\n".join(lines) + "\n" + gone, encoding="utf-8")
