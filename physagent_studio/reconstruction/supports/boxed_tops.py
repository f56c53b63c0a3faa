"""The corners of a table's top from a box around the table: its far edge, and its near one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.base import Pixel
from physagent_studio.reconstruction.photo.line_segments import Segments, joined


@dataclass(frozen=True, slots=True)
class BoxedSettings:
    """Which edges of the picture bound the top of a boxed table that stands square to it."""

    max_tilt_deg: float = 6.0  # 2..12: of either edge
    rim_share: float = 0.05  # 0.01..0.1: of the box's width: how far a box is drawn off an edge
    min_near_share: float = 0.85  # 0.6..1: of the box's width, from one end of the near edge on
    min_far_share: float = 0.4  # 0.2..0.8: the same of the far edge, which is farther off
    min_gap_px: float = 4.0  # 2..12: between the two: less is one edge
    # share, 0..0.3: by which a far edge that is not seen is nearer to the middle of the picture
    unseen_taper: float = 0.12


BOXED = BoxedSettings()


def top_in_box(
    found: Segments, box: tuple[float, float, float, float], feet: Sequence[Pixel], width: float
) -> tuple[Pixel, Pixel, Pixel, Pixel] | None:
    """Corners of the level top of what a box is around: near left, near right, far right, far left.

    found: edges of the picture. box: left, top, right, bottom, pixels. feet: pixels where things
    stand on it; the far edge runs above them along the top of the box, the near one is the first
    below them that runs from side to side. width: of the picture. None where no near edge is seen.
    """
    left, top, right, bottom = box
    wide, rim = right - left, BOXED.rim_share * (right - left)
    ends, _ = joined(found.only(np.abs(np.sin(found.angle)) < math.sin(math.radians(12))))
    if not len(ends) or not feet:
        return None
    ends = np.take_along_axis(ends, np.argsort(ends[..., :1], axis=1), axis=1)
    ends = ends[(ends[..., 0].min(1) > left - rim) & (ends[..., 0].max(1) < right + rim)]
    ends = ends[(ends[..., 1].min(1) > top - rim) & (ends[..., 1].max(1) < bottom + rim)]
    spans = (ends[:, 1, 0] - ends[:, 0, 0]) / wide
    tilts = np.abs(ends[:, 1, 1] - ends[:, 0, 1]) / np.maximum(spans * wide, 1e-9)
    level = tilts < math.tan(math.radians(BOXED.max_tilt_deg))
    below = np.array([min(_row(one, x) - y for x, y in feet) for one in ends])
    above = np.array([min(y - _row(one, x) for x, y in feet) for one in ends])
    nears = np.flatnonzero(level & (spans > BOXED.min_near_share) & (below > -BOXED.min_gap_px / 2))
    fars = np.flatnonzero(level & (spans > BOXED.min_far_share) & (above > BOXED.min_gap_px))
    fars = fars[ends[fars][..., 1].mean(1) < top + rim] if len(fars) else fars
    if not len(nears):
        return None
    near = ends[min(nears, key=lambda k: below[k])]
    # What stands square to the picture is widest at its near edge.
    near = np.array([(x, _row(near, x)) for x in (left, right)])
    if len(fars):
        far = ends[max(fars, key=lambda k: spans[k])]
    else:
        columns = near[:, 0] + BOXED.unseen_taper * (width / 2 - near[:, 0])
        far = np.column_stack([columns, [top, top]])
    return _pixel(near[0]), _pixel(near[1]), _pixel(far[1]), _pixel(far[0])


def _row(line: FloatArray, x: float) -> float:
    """The row of a line, carried on, at a column."""
    (x0, y0), (x1, y1) = line
    return float(y0 + (y1 - y0) * (x - x0) / (x1 - x0)) if x1 > x0 else float(y0)


def _pixel(at: FloatArray) -> Pixel:
    return round(float(at[0]), 1), round(float(at[1]), 1)
