"""Fits the weights of `reconstruction.masks.sureness`: python tools/fit_sureness.py ROWS.

Rows are collected once, seed by seed, into the file ROWS (JSON lines), so that a run can go on
where it was ended: `--collect 0:120`. Without `--collect` the weights of masks from clicks and from
boxes are fitted on the seeds below 500 and printed, with their calibration on those from 500 on.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from physagent_studio.benchmark.scenes import scene
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.masks.sureness import features
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.doubts import SURE_FROM

HELD_OUT = 500
"""Seed from which scenes are kept for the calibration."""
RIDGE = 1.0
"""Penalty on squared weights, in units of one mask's log-likelihood."""


def rows_of(seed: int) -> list[dict[str, object]]:
    """One row for each thing and way of marking it: its features and its IoU."""
    pictured = scene(seed)
    out: list[dict[str, object]] = []
    for way in ("click", "box"):
        said = [(one.name, getattr(one, way)) for one in pictured.subjects]
        offers = EmbeddedSegmenter().segment(pictured.image, said)
        masks = choose(offers, said, pictured.image.shape[:2], pictured.image)
        for one, (name, grounding) in zip(pictured.subjects, said, strict=True):
            if not masks[name].any():
                continue
            found = features(pictured.image, masks[name], offers[name], grounding, name)
            overlap = iou(masks[name], one.mask)
            out.append({"seed": seed, "name": name, "way": way, "iou": overlap, "of": found})
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


def calibration(chance: np.ndarray, good: np.ndarray, bins: int = 5) -> float:
    """Expected calibration error over bins of equal numbers of masks."""
    order = np.array_split(np.argsort(chance), bins)
    return float(sum(abs(chance[k].mean() - good[k].mean()) * len(k) for k in order) / len(chance))


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
                f"ECE {calibration(chance, well):.3f}, sure that are good {well[sure].mean():.2f}, "
                f"poor that are doubted {doubted[poor].mean():.2f}, "
                f"good that are doubted {doubted[well].mean():.2f}, "
                f"good that are sure {sure[well].mean():.2f}"
            )


def main() -> None:
    """Collects rows, or fits what was collected."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("rows", type=Path)
    words.add_argument("--collect", help="seeds, FIRST:LAST (exclusive)")
    asked = words.parse_args()
    if asked.collect:
        first, last = (int(part) for part in asked.collect.split(":"))
        with asked.rows.open("a") as file:
            for seed in range(first, last):
                for row in rows_of(seed):
                    file.write(json.dumps(row) + "\n")
                file.flush()
        return
    rows = [json.loads(line) for line in asked.rows.read_text().splitlines()]
    for way in ("click", "box"):
        report(way, [row for row in rows if row["way"] == way])


if __name__ == "__main__":
    main()
