"""How high a table is, by its legs: from where they stand to where the board begins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import is_solid, support_kind
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright_through
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds


@dataclass(frozen=True, slots=True)
class LegSettings:
    """What the edges of a table's legs are like."""

    board_ratio: float = 1.1  # 1..1.3: height of the top over that of the board's lower side
    max_width_ratio: float = 0.2  # 0.05..0.4: of a leg, over the table's; wider is a body
    max_bend_rad: float = math.radians(12.0)  # 0.05..0.4: more is no leg
    max_lean_rad: float = math.radians(5.0)  # 0.02..0.2: from the picture of an upright line
    min_area_px: int = 100  # 20..1000: of the mask, before anything is read off it
    min_length_ratio: float = 0.03  # 0.01..0.1: over the picture's height: shorter is grain
    lower_share: float = 0.12  # 0.05..0.3: legs in front may seem so much lower than the highest
    min_rise_share: float = 0.04  # 0.01..0.2: of the camera's height, that is believed
    max_rise_share: float = 0.95  # 0.8..1: what a camera sees from above is lower than it


LEG = LegSettings()


def rises_by_legs(
    state: SceneState,
    unit: Camera,
    offers: Mapping[str, Sequence[BoolArray]],
    covered: BoolArray,
    edges: Segments,
) -> dict[str, float]:
    """Height of each table's top over the ground, as a share of the camera's height above it.

    unit: the camera, at any height. offers: masks (H, W) of each support, the likeliest first.
    covered: (H, W) pixels of objects, which may hide feet. edges: of the picture. Nothing for
    tables whose legs are not seen down to their feet.
    """
    found: dict[str, float] = {}
    for support in state.supports:
        solid = is_solid(support.name)
        if support.shape is not None or support_kind(support.name) != "slab" or solid:
            continue
        shares = [
            own
            for mask in offers.get(support.name, ())[:1]
            for own in _shares(unit, mask, covered, edges)
        ]
        if shares:
            found[support.name] = float(np.median(shares)) * LEG.board_ratio
    return found


def _shares(unit: Camera, mask: BoolArray, covered: BoolArray, edges: Segments) -> list[float]:
    """What upright edges say that lead from the lower side of the board to the ground.

    Legs are often of another shade than the board. The legs behind begin where the board hides
    the rest of them and seem lower: the highest counts.
    """
    if np.count_nonzero(mask) < LEG.min_area_px:
        return []
    rim = _lower_side(mask)
    shares: list[tuple[float, float]] = []
    for ends, bend in zip(edges.ends, edges.bend, strict=True):
        (x0, y0), (x, y) = ends[np.argsort(ends[:, 1])]
        column = int(np.clip(x0, 0, len(rim) - 1))
        near = abs(y0 - rim[column]) < max(4.0, 0.3 * (y - y0))
        if (
            bend > LEG.max_bend_rad
            or not near
            or y - rim[column] < LEG.min_length_ratio * mask.shape[0]
        ):
            continue
        if _is_hidden((float(x), float(y)), mask, covered) or not _is_upright(
            unit, (x, y), (x0, y0)
        ):
            continue
        share = _share(unit, (float(x), float(y)), (float(x0), float(rim[column])))
        if share is not None and LEG.min_rise_share < share < LEG.max_rise_share:
            shares.append((share, float(x)))
    best = max(shares, default=(0.0, 0.0))[0]
    alike = [(share, x) for share, x in shares if share > best * (1 - LEG.lower_share)]
    # A leg has two edges side by side; what stands on the ground as one body has them far apart.
    feet = np.sort([x for _, x in alike])
    is_leg = len(feet) > 1 and np.diff(feet).min() < LEG.max_width_ratio * np.isfinite(rim).sum()
    return [share for share, _ in alike] if is_leg else []


def _lower_side(mask: BoolArray) -> FloatArray:
    """(W,) row at which the board ends below in each column, without legs; nan beside it."""
    x0, y0, x1, y1 = bounds(mask)
    across = np.ones((1, max(3, round(LEG.max_width_ratio * (x1 - x0)))), np.uint8)
    board = cv2.morphologyEx(mask[y0:y1, x0:x1].astype(np.uint8), cv2.MORPH_OPEN, across) > 0
    out = np.full(mask.shape[1], np.nan)
    if board.any():
        rows = np.where(board.any(0), y0 + len(board) - board[::-1].argmax(0), np.nan)
        out[x0:x1] = rows
    return out


def _is_upright(unit: Camera, foot: tuple[float, float], head: tuple[float, float]) -> bool:
    """Whether an edge in the picture leads straight up from its lower end."""
    ground = on_plane(unit, [foot], 0.0)[0]
    if not np.isfinite(ground).all():
        return False
    above = ground + np.array([0.0, 0.0, 0.05 * unit.position[2]])
    up = unit.project(np.array([ground, above]))[0]
    plumb, own = up[1] - up[0], np.subtract(head, foot)
    cosine = float(plumb @ own) / max(float(np.hypot(*plumb) * np.hypot(*own)), 1e-9)
    return cosine > math.cos(LEG.max_lean_rad)


def _is_hidden(foot: tuple[float, float], mask: BoolArray, covered: BoolArray) -> bool:
    """Whether a foot is cut off by the picture's border or by something in front of it."""
    x, y = round(foot[0]), round(foot[1])
    height, width = mask.shape
    if y >= height - 2 or not 2 <= x < width - 2:
        return True
    return bool(covered[y - 3 : y + 5, max(0, x - 4) : x + 5].any())


def _share(unit: Camera, foot: tuple[float, float], joint: tuple[float, float]) -> float | None:
    ground = on_plane(unit, [foot], 0.0)[0]
    if not np.isfinite(ground).all():
        return None
    toward = (np.asarray(unit.position) - ground) * (1.0, 1.0, 0.0)
    normal = toward / max(float(np.linalg.norm(toward)), 1e-9)
    return float(on_upright_through(unit, [joint], ground, normal)[0, 2]) / unit.position[2]
