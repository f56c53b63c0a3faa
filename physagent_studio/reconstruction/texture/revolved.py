"""The photo on what is round about an axis: cans, bottles, cups, tops.

Near its outline such a body is seen at too flat an angle, and half of it not at all. What is not
seen of a ring shows what is seen of it, folded over from either side; a ring that is not seen
shows the nearest seen ring of its direction, the farther the plainer. What is before another part
of the same thing tells nothing of that, and the inside of a vessel nothing of its outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.hidden_sides import commonest
from physagent_studio.reconstruction.texture.unrolled import Unrolled
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.light import lambert
from physagent_studio.rendering.lit import bilinear


@dataclass(frozen=True, slots=True)
class RevolvedSettings:
    """How what is not seen of a surface of revolution is painted."""

    min_ring_share: float = 0.06  # 0.01..0.3: of a ring, from which it is seen
    blend_share: float = 0.3  # 0.05..1: of a gap, in which its two sides pass into one another
    pass_share: float = 0.03  # 0.01..0.1: of a turn, in which what is filled in passes into it
    # 0.02..0.5: over the outline's length: how far a ring's pattern goes on
    fade_ratio: float = 0.05
    near_ratio: float = 0.2  # 0.02..0.3: over the same: rings that tell the plain colour of others
    # one minus cosine, 0..1: of two rings' directions, beyond which no pattern goes on
    max_crease: float = 1 - math.cos(math.radians(40.0))
    bend_ratio: float = 0.25  # 0..3: what a full turn of direction counts as, in outlines' lengths
    deep_ratio: float = 0.25  # 0.05..1: over the outline's length: from there on a vessel is deep
    deep_share: float = 0.45  # 0.3..1: of the light, that comes there
    grain_share: float = 0.5  # 0..3: of its colour's own unevenness that is kept
    margin_px: int = 8  # 2..32: by which the picture goes on beyond itself


REVOLVED = RevolvedSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """Which faces (F,) of a mesh show the picture (h, w, 3), and where (K, 3, 2) their corners."""

    faces: BoolArray
    corners: FloatArray
    picture: Image


def around(
    camera: Camera,
    item: SceneObject,
    mesh: Mesh,
    mask: BoolArray,
    crop: tuple[Image, tuple[int, int]],
    lit: bool,
) -> Around | None:
    """What of a body about an axis the photo shows not at all or badly, painted.

    None for bodies without an axis, and where nothing of them is seen. crop: the photo around the
    thing (h, w, 3) and its top left corner (x, y). lit: whether it has the light on it.
    """
    if not at_work("turned sides"):
        return None
    depth = float(camera.project(np.asarray(item.position, float)[None])[1][0])
    laid = Unrolled.of(item, mesh, max(depth, 1e-6) / camera.focal)
    if laid is None:
        return None
    pixels, shown, seen = laid.seen(camera, item, mesh, mask)
    if not (seen.mean(1) > REVOLVED.min_ring_share).any():
        return None
    where = pixels.reshape(-1, 2) - np.array(crop[1]) - 0.5
    colours = bilinear(crop[0], where).astype(np.float64).reshape(*seen.shape, 3)
    filled = _filled(laid, colours, seen, lit)
    picture = np.where(shown[..., None], colours, _passed_into(filled, colours, shown & ~seen))
    return _laid_on(mesh, laid, shown, np.clip(picture + 0.5, 0, 255).astype(np.uint8))


def _filled(laid: Unrolled, colours: FloatArray, seen: BoolArray, lit: bool) -> FloatArray:
    """The unrolled picture (H, W, 3) with what is not seen of it filled in."""
    told = seen.mean(1) > REVOLVED.min_ring_share
    out = colours.copy()
    source, weight = _folded(seen[told])
    rows = np.arange(source.shape[1])[:, None]
    pair = [colours[told][rows, part] for part in source]
    out[told] = pair[0] + weight[..., None] * (pair[1] - pair[0])
    return _rings_filled(laid, out, seen, told, lit)


def _passed_into(filled: FloatArray, colours: FloatArray, rim: BoolArray) -> FloatArray:
    """The picture (H, W, 3) led over to what is shown, without being told from, at a rim (H, W)."""
    if not rim.any():
        return filled
    width = rim.shape[1]
    reach = REVOLVED.pass_share * width
    wide = np.hstack([rim] * 3)
    off = np.hstack([np.where(rim[..., None], colours - filled, 0.0)] * 3)
    near = cv2.GaussianBlur(wide.astype(np.float64), (0, 0), reach)
    off = cv2.GaussianBlur(off, (0, 0), reach) / np.maximum(near, 1e-4)[..., None]
    away = cv2.distanceTransform((~wide).astype(np.uint8), cv2.DIST_L2, 5) / reach
    return np.asarray(filled + (off * np.exp(-(away**2))[..., None])[:, width : 2 * width])


def _folded(seen: BoolArray) -> tuple[NDArray[np.int64], FloatArray]:
    """(2, N, W) where rings (N, W) take their colours from, from before and from behind them, and
    (N, W) the share of the latter. What is seen takes its own.

    A gap is folded over from both its ends, drawn out where it is wider than what is seen.
    """
    count, width = seen.shape
    thrice = np.hstack([seen] * 3)
    at = np.arange(3 * width)
    before = np.maximum.accumulate(np.where(thrice, at, -1), axis=1)
    behind = np.minimum.accumulate(np.where(thrice, at, 3 * width)[:, ::-1], axis=1)[:, ::-1]
    middle = slice(width, 2 * width)
    here = at[middle]
    back, ahead = here - before[:, middle], behind[:, middle] - here
    gap = np.maximum(back + ahead, 1)
    drawn = np.minimum(1.0, seen.sum(1, keepdims=True) / gap)
    one = np.round(before[:, middle] - drawn * back).astype(np.int64) % width
    other = np.round(behind[:, middle] + drawn * ahead).astype(np.int64) % width
    # What is folded may fall into another gap.
    rows = np.arange(count)[:, None]
    source = np.stack([before[rows, width + one], behind[rows, width + other]]) % width
    share = np.clip((back / gap - 0.5) / REVOLVED.blend_share + 0.5, 0, 1)
    return source, np.where(seen, 0.0, share)


def _rings_filled(
    laid: Unrolled, colours: FloatArray, seen: BoolArray, told: BoolArray, lit: bool
) -> FloatArray:
    """The picture (H, W, 3) with its rings (H,) that are not told filled from others."""
    middles = laid.places.mean(1)
    reach = np.linalg.norm(laid.places[..., :2], axis=2).mean(1)
    steps = np.hypot(np.diff(reach), np.diff(middles[:, 2]))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    along /= max(float(along[-1]), 1e-12)
    out_of = laid.places[..., :2] / np.maximum(reach, 1e-12)[:, None, None]
    ways = np.stack([(laid.normals[..., :2] * out_of).sum(2).mean(1), laid.normals[..., 2].mean(1)])
    ways /= np.maximum(np.linalg.norm(ways, axis=0), 1e-12)
    bends = 1 - ways.T @ ways
    bright = lambert(ways[1]) if lit else np.ones(len(along))
    # The same picture each time: a seed that depends on nothing.
    grain = np.random.default_rng(0).normal(0, 1, seen.shape)
    grain = REVOLVED.grain_share * cv2.GaussianBlur(grain, (0, 0), 1.0)
    plains: dict[int, FloatArray] = {}
    out = colours.copy()
    for row in np.flatnonzero(~told):
        known = np.flatnonzero(told & (laid.inside == laid.inside[row]))
        strange = not len(known)
        known = np.flatnonzero(told) if strange else known
        cost = np.abs(along[known] - along[row]) + REVOLVED.bend_ratio * bends[row, known]
        best = int(known[cost.argmin()])
        if best not in plains:
            beside = known[cost < cost.min() + REVOLVED.near_ratio]
            plains[best] = _plain(colours[beside][seen[beside]], grain)
        away = abs(along[row] - along[best])
        creased = strange or bends[row, best] > REVOLVED.max_crease
        fade = 1.0 if creased else min(away / REVOLVED.fade_ratio, 1.0)
        # Little light comes down into a vessel.
        deep = 1.0 if strange else min(away / REVOLVED.deep_ratio, 1.0)
        dim = 1 - (1 - REVOLVED.deep_share) * deep * laid.inside[row]
        look = (1 - fade) * colours[best] + fade * plains[best][row]
        out[row] = dim * bright[row] / bright[best] * look
    return out


def _plain(colours: FloatArray, grain: FloatArray) -> FloatArray:
    """(H, W, 3) the commonest of colours (N, 3), as uneven as that is. grain: (H, W) noise."""
    found = commonest(colours.astype(np.uint8))
    usual, stray = found or (np.median(colours, axis=0), 0.0)
    return np.asarray(usual + stray * grain[..., None])


def _laid_on(mesh: Mesh, laid: Unrolled, shown: BoolArray, picture: Image) -> Around:
    """What of the mesh shows the unrolled picture: all of the body that is not seen well."""
    count, width = laid.rings.shape
    ring = np.zeros(int(laid.rings.max()) + 1, np.int64)
    turn = np.zeros(len(ring), np.int64)
    ring[laid.rings] = np.arange(count)[:, None]
    turn[laid.rings] = np.arange(width)
    body = (mesh.faces < len(ring)).all(1)
    faces = mesh.faces[body]
    column = turn[faces].astype(float)
    pole = (ring[faces] == 0) | (ring[faces] == count - 1)
    column[pole] = np.nan
    # A face that lies across the seam ends beyond it.
    across = np.nanmax(column, 1) - np.nanmin(column, 1) > 1
    column[across[:, None] & (column == 0)] = width
    middle = np.nanmean(column, 1, keepdims=True)
    column = np.where(pole, middle, column) * picture.shape[1] / width
    corners = np.stack([column, laid.row[ring[faces]]], 2)
    spots = corners.mean(1).astype(int)
    down = np.clip(spots[:, 1], 0, len(picture) - 1)
    hidden = ~shown[down, spots[:, 0] % picture.shape[1]]
    chosen = np.zeros(len(mesh.faces), bool)
    chosen[np.flatnonzero(body)[hidden]] = True
    margin = REVOLVED.margin_px
    padded = np.pad(picture, ((0, 0), (margin, margin), (0, 0)), mode="wrap")
    return Around(chosen, corners[hidden] + (margin, 0), padded)
