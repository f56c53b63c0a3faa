"""The surface that was clicked: what is of one colour there, as far as strong edges go.

What things stand on (tables, boards, belts) fills much of the picture and often leaves it, so it is
no thing as the network of `thing_map` knows them. The picture is smoothed to patches of one colour
(mean shift) and flooded from the clicks with growing tolerance; of all the regions that gives, that
one counts whose rim lies on the strongest edges.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    resized,
    without_pinholes,
)
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

FloatArray = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SurfaceSettings:
    """How far a surface goes on from where it was clicked."""

    side_px: int = 256  # 128..640: the picture's longer side on which it is sought
    patch_px: int = 6  # 2..15: of the mean shift: grain vanishes
    patch_levels: int = 14  # 5..30: of the mean shift: edges of things stay
    tolerance_lab: tuple[int, int] = (3, 40)  # 1..60: from a click's colour, from and below
    lightness_factor: float = 1.6  # 1..3: as far in lightness as in hue, by shading
    full_step_lab: float = 60.0  # 20..150: an edge is strong enough from here on
    # 0..2: edges' steps that one of tolerance is worth: of like rims the narrower
    wider_step_lab: float = 0.3
    area_shares: tuple[float, float] = (0.002, 0.8)  # 0..1: of the picture that a surface fills


SURFACE = SurfaceSettings()


def with_surface(
    image: Image, grounding: Grounding, offers: Sequence[Candidate]
) -> tuple[Candidate, ...]:
    """Candidates of a clicked surface (H, W), that first whose rim lies on the strongest edges."""
    factor = min(1.0, SURFACE.side_px / max(image.shape[:2]))
    sized = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.asarray(sized, np.uint8)
    steps = _steps(small)
    size = (small.shape[1], small.shape[0])
    best = max((_rim(resized(one.mask, size), steps) for one in offers), default=0.0)
    found, strength = None, best
    for tolerance, mask in _flooded(small, grounding, factor):
        rim = _rim(mask, steps) - SURFACE.wider_step_lab * tolerance
        if rim > strength:
            found, strength = mask, rim
    if found is None:
        return tuple(offers)
    whole = resized(without_pinholes(found, 0.02), (image.shape[1], image.shape[0]))
    first = Candidate(whole, min(strength / SURFACE.full_step_lab, 1.0), "surface")
    return (first, *offers[:3])


def _flooded(
    small: NDArray[np.uint8], grounding: Grounding, factor: float
) -> list[tuple[int, BoolArray]]:
    """Regions (h, w) around the clicks that hold none of those beside it, by their tolerance."""
    rows, columns = small.shape[:2]
    patches = cv2.pyrMeanShiftFiltering(small, SURFACE.patch_px, SURFACE.patch_levels)
    lab = cv2.cvtColor(patches, cv2.COLOR_RGB2Lab)
    on, off = (
        [
            (min(int(c.x * factor), columns - 1), min(int(c.y * factor), rows - 1))
            for c in grounding.points
            if c.label == said
        ]
        for said in (1, 0)
    )
    flags = 4 | cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY | 255 << 8
    out = []
    for tolerance in range(*SURFACE.tolerance_lab):
        reached = np.zeros((rows + 2, columns + 2), np.uint8)
        within = (SURFACE.lightness_factor * tolerance, tolerance, tolerance)
        for seed in on:
            cv2.floodFill(lab, reached, seed, (0, 0, 0), within, within, flags)
        mask = reached[1:-1, 1:-1] > 0
        share = float(mask.mean())
        if share > SURFACE.area_shares[1] or any(mask[y, x] for x, y in off):
            break
        if share >= SURFACE.area_shares[0]:
            out.append((tolerance, mask))
    return out


def _steps(small: NDArray[np.uint8]) -> FloatArray:
    """(h, w) how strongly colours change there, the strongest of what is next to it."""
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2Lab).astype(np.float32)
    soft = cv2.GaussianBlur(lab, (0, 0), 1.0)
    across, down = (cv2.Sobel(soft, cv2.CV_32F, *way) for way in ((1, 0), (0, 1)))
    size = np.sqrt((across**2 + down**2).sum(axis=2))
    return np.asarray(
        cv2.dilate(np.minimum(size, SURFACE.full_step_lab), np.ones((3, 3))), np.float32
    )


def _rim(mask: BoolArray, steps: FloatArray) -> float:
    """How strong the edges are on the outer rim of a mask (h, w), where it is in the picture."""
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5)))
    outlines, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return 0.0
    x, y = max(outlines, key=cv2.contourArea)[:, 0].T
    rows, columns = mask.shape
    seen = (x > 1) & (x < columns - 2) & (y > 1) & (y < rows - 2)
    return float(steps[y[seen], x[seen]].mean()) if seen.any() else 0.0
