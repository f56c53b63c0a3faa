"""Holes in photographs where nothing is taken out: what is filled in against what is there.

The truth of a background plate on real ground, walls and furniture. In place of a thing there is a
plain oval of any two colours, so that no edge runs through it.
"""

from collections.abc import Iterable

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.benchmark.rows import Row, at_most
from physagent_studio.reconstruction.background.lines_behind import each_once, lines_through
from physagent_studio.reconstruction.background.plate import fill
from physagent_studio.reconstruction.photo.line_segments import segments, with_grain, with_hues
from physagent_studio.records.case import Image

HOLES = 3
LONGER_PX = 960
"""The longer side of the picture in which holes are filled."""
RADII = (0.08, 0.15)
"""Of a hole, over the picture's shorter side."""


def holes_of(photo: Image, seed: int) -> list[tuple[Image, BoolArray]]:
    """The photo (H, W, 3) with an oval (H, W) before it, several times; in its lower part."""
    rng = np.random.default_rng(seed)
    rows, columns = photo.shape[:2]
    out = []
    for _ in range(HOLES):
        wide, high = rng.uniform(*RADII, 2) * min(rows, columns)
        margin = 20
        x = rng.uniform(wide + margin, columns - wide - margin)
        y = rng.uniform(0.4 * rows, rows - high - margin)
        oval = np.zeros((rows, columns), np.uint8)
        cv2.ellipse(oval, (int(x), int(y)), (int(wide), int(high)), 0, 0, 360, 1, -1)
        covered = photo.copy()
        covered[oval > 0] = rng.integers(0, 255, 3)
        covered[cv2.erode(oval, np.ones((9, 9))) > 0] = rng.integers(0, 255, 3)
        out.append((covered, oval > 0))
    return out


def filled(photo: Image, hole: BoolArray) -> Image:
    """The photo (H, W, 3), its hole (H, W) filled as a background is."""
    found = with_grain(photo, with_hues(photo, segments(photo)))
    return fill(photo, hole, each_once(lines_through(photo, hole, found)))


def hole_rows(photos: Iterable[Image]) -> list[Row]:
    """The error in the holes, and beside OpenCV's Navier-Stokes inpainting in the same run."""
    own, other = [], []
    for seed, photo in enumerate(photos):
        scale = min(1.0, LONGER_PX / max(photo.shape))
        truth = cv2.resize(photo, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        truth = np.asarray(truth, np.uint8)
        for covered, hole in holes_of(truth, seed):
            made = (filled(covered, hole), cv2.inpaint(covered, hole.astype(np.uint8), 5, 0))
            for errors, plate in zip((own, other), made, strict=True):
                off = np.abs(np.asarray(plate, np.float32) - truth)[hole]
                errors.append(float(off.mean()))
    error, usual = float(np.mean(own)), float(np.mean(other))
    return [
        at_most("photographs, holes: error of what is filled in", error, 15.0, "grey levels"),
        at_most("photographs, holes: the same over that of cv2.inpaint", error / usual, 1.0, ""),
    ]
