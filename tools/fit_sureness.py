"""Fits the weights of `reconstruction.masks.sureness`: python -m tools.fit_sureness ROWS.

Rows are collected once, seed by seed, into the file ROWS (JSON lines), so that a run can go on
where it was ended: `--collect 0:120`. Without `--collect` the weights of masks from clicks and from
boxes are fitted on the seeds below 500 and printed, with their calibration on those from 500 on.
`--kind cutouts --of THINGS GROUNDS --collect 0:68` takes every second one of the things that
`tools.cutout_pictures` puts before photographs, and `500:568` the others.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physagent_studio.benchmark.reconstruction import lookalikes, synthetic
from physagent_studio.benchmark.reconstruction.many_parts import calibration_error
from physagent_studio.benchmark.scenes import scene
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.masks.sureness import features
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image
from physagent_studio.records.doubts import SURE_FROM
from tools.cutout_pictures import cutout, things_in

HELD_OUT = 500
"""Seed from which scenes are kept for the calibration."""
RIDGE = 0.2
"""Penalty on squared weights, in units of one mask's log-likelihood."""


KINDS = ("parts", "plain", "stack", "cutouts")
"""Pictures of many-part things, of things of one colour, of stacks, and real cut-outs."""


def pictured(
    kind: str, seed: int, of: Sequence[Path]
) -> tuple[Image, list[tuple[str, BoolArray, Grounding, Grounding]]]:
    """A picture, and each thing in it with its mask (H, W), a click and a box on it."""
    if kind == "cutouts":
        things, grounds = things_in(of[0]), sorted(of[1].iterdir())
        number = 2 * (seed % HELD_OUT) + (seed >= HELD_OUT)
        one = cutout(things[number], grounds, number)
        name = re.sub(r"[^a-z]+", " ", one.name.lower()).strip().replace(" ", "_") or "thing"
        return one.image, [(name, one.mask, *_marked(np.random.default_rng(seed), one.mask))]
    if kind == "parts":
        found = scene(seed)
        return found.image, [(one.name, one.mask, one.click, one.box) for one in found.subjects]
    drawn = synthetic.scene(seed) if kind == "plain" else lookalikes.stack(seed)
    rng = np.random.default_rng(seed)
    things = [(name, mask) for name, mask in drawn.masks.items() if mask.sum() > 60]
    return drawn.image, [(name, mask, *_marked(rng, mask)) for name, mask in things]


def _marked(rng: np.random.Generator, mask: BoolArray) -> tuple[Grounding, Grounding]:
    """A click near the middle of a mask, and a box a little wider than it."""
    rows, columns = mask.nonzero()
    middle = np.array([columns.mean(), rows.mean()]) + rng.normal(0, 0.08, 2) * np.ptp(columns)
    at = int(np.hypot(columns - middle[0], rows - middle[1]).argmin())
    wider = 0.04 * max(np.ptp(columns), np.ptp(rows)) * rng.random(4)
    height, width = mask.shape
    box = (
        float(max(columns.min() - wider[0], 0)),
        float(max(rows.min() - wider[1], 0)),
        float(min(columns.max() + 1 + wider[2], width)),
        float(min(rows.max() + 1 + wider[3], height)),
    )
    click = Click(x=float(columns[at]), y=float(rows[at]))
    return Grounding(points=(click,)), Grounding(box=box)


def rows_of(kind: str, seed: int, of: Sequence[Path]) -> list[dict[str, object]]:
    """One row for each thing and way of marking it: its features and its IoU."""
    image, things = pictured(kind, seed, of)
    out: list[dict[str, object]] = []
    for way, which in (("click", 2), ("box", 3)):
        said = [(one[0], one[which]) for one in things]
        offers = EmbeddedSegmenter().segment(image, said)
        masks = choose(offers, said, image.shape[:2], image)
        for (name, mask, *_), (_, grounding) in zip(things, said, strict=True):
            if masks[name].any():
                found = features(image, masks[name], offers[name], grounding, name)
                row = {"kind": kind, "seed": seed, "name": name, "way": way, "of": found}
                out.append(row | {"iou": iou(masks[name], mask)})
    return out


def fitted(table: np.ndarray, good: np.ndarray) -> np.ndarray:
    """Weights (F,) of a logistic regression by Newton's method; the first column is constant."""
    weights = np.zeros(table.shape[1])
    penalty = np.diag([0.0] + [RIDGE] * (table.shape[1] - 1))
    for _ in range(50):
        chance = 1.0 / (1.0 + np.exp(-table @ weights))
        slope = table.T @ (good - chance) - penalty @ weights
        curve = (table * (chance * (1 - chance))[:, None]).T @ table + penalty
        weights = weights + np.linalg.solve(curve + 1e-9 * np.eye(len(weights)), slope)
    return weights


def report(way: str, rows: list[dict]) -> None:
    """Prints the weights for one way of marking things, and what they are worth."""
    keys = list(rows[0]["of"])
    table = np.array([[row["of"][key] for key in keys] for row in rows])
    overlap = np.array([row["iou"] for row in rows])
    good, held = overlap > SURE_FROM, np.array([row["seed"] >= HELD_OUT for row in rows])
    weights = fitted(table[~held], good[~held])
    print(f"{way.upper()}_WEIGHTS: Mapping[str, float] = {{")
    for key, weight in zip(keys, weights, strict=True):
        print(f'    "{key}": {weight:.2f},')
    print("}")
    for title, part in (("fitted on", ~held), ("held out", held)):
        if part.any():
            chance = 1.0 / (1.0 + np.exp(-table[part] @ weights))
            values, well = overlap[part], good[part]
            poor, sure, doubted = values < 0.6, chance >= 0.8, chance < 0.5
            print(
                f"# {title}: {part.sum()} masks, median IoU {np.median(values):.3f}, "
                f"p25 {np.quantile(values, 0.25):.3f}, good {well.mean():.2f}, "
                f"ECE {calibration_error(chance, well):.3f}, "
                f"sure that are good {well[sure].mean():.2f}, "
                f"poor that are doubted {doubted[poor].mean():.2f}, "
                f"good that are doubted {doubted[well].mean():.2f}, "
                f"good that are sure {sure[well].mean():.2f}"
            )


def main() -> None:
    """Collects rows, or fits what was collected."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("rows", type=Path)
    words.add_argument("--kind", choices=KINDS, default="parts")
    words.add_argument("--of", type=Path, nargs=2, default=(), metavar="FOLDER")
    words.add_argument("--collect", help="seeds, FIRST:LAST (exclusive)")
    asked = words.parse_args()
    if asked.collect:
        first, last = (int(part) for part in asked.collect.split(":"))
        with asked.rows.open("a") as file:
            for seed in range(first, last):
                for row in rows_of(asked.kind, seed, asked.of):
                    file.write(json.dumps(row) + "\n")
                file.flush()
        return
    rows = [json.loads(line) for line in asked.rows.read_text().splitlines()]
    for way in ("click", "box"):
        report(way, [row for row in rows if row["way"] == way])


if __name__ == "__main__":
    main()
