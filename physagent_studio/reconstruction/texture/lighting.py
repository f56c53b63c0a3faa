"""The light on a round thing, read off the photo and taken out of its texture.

Steps of the log of its brightness, from pixel to pixel, are fitted by those of a smooth function
of the surface's normal. Where paint meets paint, and where it shines, colours jump and are not
followed. Where light explains little of the rest there is none to take out, and the texture stays
the photo.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import (
    Capsule,
    Cylinder,
    Ellipsoid,
    Frustum,
    Inflated,
    Revolved,
    Sphere,
    Torus,
)
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, shrink
from physagent_studio.reconstruction.photo.statistics import lengths
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.block_light import block_terms, evened_rims, is_block
from physagent_studio.reconstruction.texture.round_light import thrown_back
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh, Shading
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.lit import (
    DARK,
    FARTHEST,
    LOWEST,
    gloss_frame,
    light_at,
    lit,
    terms_of,
)
from physagent_studio.rendering.raster import Lens, rasterise


@dataclass(frozen=True, slots=True)
class LightingSettings:
    """When light is read off a thing and taken out of its look."""

    min_px: int = 150  # 50..1000: below this nothing is told
    max_px: int = 8000  # 1000..50000: that are looked at; more tell no more of so smooth a light
    # 0.02..0.5: over the thing's width: how far apart the pixels of a pair are
    pair_ratios: tuple[float, float, float] = (0.06, 0.12, 0.24)
    max_pairs: int = 2000  # count, 200..20000: for each distance and direction
    min_explained_share: float = 0.4  # 0.1..0.9: of how colours change without jumps, that is light
    # 0..0.8: of what light varies, as under one lamp: wide bands of paint are not
    min_lamp_share: float = 0.3
    min_range_log: float = 0.10  # 0.02..0.4: over nine tenths of what is seen; less is no light
    # 0..0.2: for each pixel: how strongly each term is drawn to 0, fine ones the more
    pulls_share: tuple[float, ...] = (0.0, *[0.002] * 3, *[0.008] * 5, *[0.03] * 7)
    hue_pull_factor: float = 12.0  # 1..50: how much more strongly the terms of the light's hue are
    # 0..5: the same on pale things: green on a white ball is the cloth's light
    pale_pull_factor: float = 0.4
    max_pale_log: float = 0.2  # 0.05..0.5: up to which a thing has hardly a hue of its own
    # 0..5: the same of those by height alone in the hue of what lies around the thing's foot, which
    # throws light back at it
    thrown_pull_factor: float = 0.1
    # 0..1: how far what is the thing's own colour may stray in the first rounds
    strays_log: tuple[float, float, float, float] = (0.6, 0.45, 0.3, 0.2)
    shady_ratio: float = 0.75  # 0.4..1: light below which the photo is not taken at its word
    calmed_share: float = 0.8  # 0..1: by which it is calmed in the darkest light
    min_gloss_log: float = 0.16  # 0.05..0.5: by which gloss is brighter than the light
    min_whiter_share: float = 0.15  # 0..0.6: of its saturation, that a thing loses in gloss
    max_gloss_share: float = 0.20  # 0.05..0.5: of what is seen; more is paint
    min_saturation_log: float = 0.12  # 0.03..0.4: below which a thing is grey
    white_levels: float = 130.0  # 90..220: beyond which what is grey is white
    band_share: float = 0.85  # 0.6..1: of a row of a thing, from which on it is a painted band
    lamp_levels: int = 170  # 120..250: least white in the middle of a spot of gloss
    min_own_share: float = 0.7  # 0.4..1: of what lies around a spot, in the thing's own hue
    min_spot_share: float = 0.0004  # 0..0.01: of what is seen; smaller spots are noise
    rim_ratio: float = 0.015  # 0..0.05: over the thing's width: the soft rim of a spot
    # 8..512: least and most, across the picture of the gloss
    gloss_side_px: tuple[int, int] = (16, 160)


LIGHTING = LightingSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What the camera sees of a mesh. normals: (H, W, 3) unit, world. shown: (H, W) where."""

    normals: FloatArray
    shown: BoolArray


def unlit(
    photo: Image, mask: BoolArray, camera: Camera, item: SceneObject, mesh: Mesh
) -> tuple[Image, Shading] | None:
    """The photo (H, W, 3) with the light taken off the thing, and that light; None for none.

    None for what is neither smooth and round nor a block, and where the photo tells of no light
    on it.
    """
    block = is_block(item) and at_work("light on blocks")
    if not at_work("light off") or not (block or _smooth(item)) or not mask.any():
        return None
    seen = _seen(camera, item, mesh)
    inner = shrink(mask, 2) & seen.shown
    towards = np.asarray(camera.position) - np.asarray(item.position)
    towards /= np.linalg.norm(towards)
    inner &= (seen.normals @ towards) > math.cos(FARTHEST)
    if np.count_nonzero(inner) < LIGHTING.min_px:
        return None
    terms = (
        block_terms(photo, seen.normals, inner, item)
        if block
        else _fitted(photo, seen.normals, inner, towards, thrown_back(photo, mask))
    )
    if terms is None:
        return None
    x, y, z = (float(part) for part in towards)
    shading = Shading(tuple(tuple(row) for row in terms.T.tolist()), (x, y, z), item.rotation)
    own = mask & seen.shown
    plain = _without(photo, seen, own, shading)
    if block:
        return evened_rims(plain, seen.normals, own, item), shading
    if isinstance(item.shape, Inflated) or not at_work("gloss off"):
        return plain, shading
    return _without_gloss(photo, plain, seen, own, shading)


def no_light(camera: Camera, item: SceneObject) -> Shading:
    """Light that changes nothing, as the camera sees the thing."""
    towards = np.asarray(camera.position) - np.asarray(item.position)
    x, y, z = (float(part) for part in towards / np.linalg.norm(towards))
    none = (0.0,) * len(LIGHTING.pulls_share)
    return Shading((none, none, none), (x, y, z), item.rotation)


def _smooth(item: SceneObject) -> bool:
    shape = item.shape
    if isinstance(shape, Inflated):
        return not shape.flat
    return isinstance(shape, Sphere | Ellipsoid | Revolved | Cylinder | Capsule | Frustum | Torus)


def _seen(camera: Camera, item: SceneObject, mesh: Mesh) -> Seen:
    batch = Batch.of([mesh])
    turn = matrix_of(item.rotation)
    world = mesh.vertices @ turn.T + np.asarray(item.position)
    points = (world - np.asarray(camera.position)) @ camera.matrix
    lens = Lens(*camera.size, camera.focal, *camera.principal)
    hits = rasterise(points, batch.faces, lens, batch.one_sided)
    normals = np.zeros((lens.height, lens.width, 3))
    found = np.einsum("ki,kij->kj", hits.weights, batch.normals[hits.face]) @ turn.T
    found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
    normals.reshape(-1, 3)[hits.pixel] = found
    shown = np.zeros((lens.height, lens.width), bool)
    shown.ravel()[hits.pixel] = True
    return Seen(normals, shown)


def _fitted(
    photo: Image, normals: FloatArray, inner: BoolArray, towards: FloatArray, thrown: FloatArray
) -> FloatArray | None:
    """(9, 3) terms of the log of light where `inner` (H, W) is; None where there is none."""
    one, other = _pairs(inner)
    logs = np.log(photo.reshape(-1, 3).astype(np.float64) + DARK)
    ways = normals.reshape(-1, 3)
    own = np.flatnonzero(inner)[:: max(1, np.count_nonzero(inner) // LIGHTING.max_px)]
    # Of what is seen aslant there are few pixels for much surface.
    share = 1 / np.maximum(ways @ towards, 0.25)
    steps = terms_of(ways[other]) - terms_of(ways[one])
    change = logs[other] - logs[one]
    hues = logs[own] - logs[own].mean(-1, keepdims=True)
    pale = float(np.median(np.linalg.norm(hues, axis=1))) < LIGHTING.max_pale_log
    pull = LIGHTING.pale_pull_factor if pale else LIGHTING.hue_pull_factor
    fit, sure = _followed(steps, change, np.sqrt(share[one] * share[other]), pull, thrown)
    terms = terms_of(ways[own])
    light = terms @ fit.mean(-1)
    low, high = np.percentile(light, (5, 95))
    tone = change.mean(-1)
    left = tone - steps @ fit.mean(-1)
    if high - low < LIGHTING.min_range_log or (sure @ left**2) > (
        1 - LIGHTING.min_explained_share
    ) * (sure @ tone**2):
        return None
    if _spread(terms[:, :4] @ fit[:4].mean(-1), share[own]) < LIGHTING.min_lamp_share * _spread(
        light, share[own]
    ):
        return None
    fit[0] -= np.median(terms @ fit, axis=0)
    # Nothing may become brighter than white without its light.
    bright = np.exp(logs[own] - np.maximum(terms @ fit, math.log(LOWEST)))
    fit[0] += max(0.0, math.log(float(np.percentile(bright.max(-1), 99)) / (255 + DARK)))
    return np.asarray(fit, np.float64)


def _pairs(inner: BoolArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices (K,) of pixels that are compared with others (K,), near and far, both inside."""
    numbers = np.arange(inner.size).reshape(inner.shape)
    rows, columns = np.nonzero(inner)
    width = min(np.ptp(rows), np.ptp(columns)) + 1
    one, other = [], []
    for apart in LIGHTING.pair_ratios:
        far = max(2, round(apart * width))
        for down, right in ((0, far), (far, 0), (far, far), (far, -far)):
            first = (rows + down < inner.shape[0]) & (columns + right < inner.shape[1])
            first &= columns + right >= 0
            y, x = rows[first], columns[first]
            both = inner[y + down, x + right]
            y, x = y[both], x[both]
            step = max(1, len(y) // LIGHTING.max_pairs)
            one.append(numbers[y, x][::step])
            other.append(numbers[y + down, x + right][::step])
    return np.concatenate(one), np.concatenate(other)


def _followed(
    steps: FloatArray, change: FloatArray, share: FloatArray, hue_pull: float, thrown: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(T, 3) by which steps of the terms (N, T) come nearest to most steps of colour, log (N, 3),

    by weights (N,), and weights (N,) of those that are followed: where paint meets paint, colours
    jump, and light does not. hue_pull: how strongly its hue is drawn to none, but for what the
    ground throws back: the more of the hue `thrown` (3,) the lower a surface faces.
    """
    tone = change.mean(-1)
    hues = change - tone[:, None]
    fit, sure = np.zeros((steps.shape[1], 3)), share
    stray, off = tone, np.linalg.norm(hues, axis=1)
    pull = len(tone) * np.diag(LIGHTING.pulls_share)
    pull[0, 0] = 1.0
    # Terms that change with height alone are those that are not 0 straight up.
    upright = terms_of(np.array([[0.0, 0, 1]]))[0] != 0
    upright = pull * np.where(upright, LIGHTING.thrown_pull_factor, hue_pull)
    for width in (*LIGHTING.strays_log, *[0.0] * 6):
        bounds = (width or max(1.5 * float(np.median(np.abs(v))), 0.03) for v in (stray, off))
        sure = share.copy()
        for value, bound in zip((stray, off), bounds, strict=True):
            sure /= (1 + (value / bound) ** 2) ** 2
        sure /= sure.mean()
        root = steps.T * sure
        squares = root @ steps
        along = hues @ thrown
        fit = np.linalg.solve(squares + pull, root @ tone)[:, None] + np.linalg.solve(
            squares + hue_pull * pull, root @ (hues - np.outer(along, thrown))
        )
        fit += np.outer(np.linalg.solve(squares + upright, root @ along), thrown)
        rest = change - steps @ fit
        # As `rest.mean(-1)`, which takes ten times as long over an axis of three.
        stray = (rest[:, 0] + rest[:, 1] + rest[:, 2]) / 3
        off = lengths(rest - stray[:, None])
    return fit, sure


def _spread(values: FloatArray, weights: FloatArray) -> float:
    """The variance of values (N,) by weights (N,)."""
    away = values - np.average(values, weights=weights)
    return float(np.average(away**2, weights=weights))


def _without(photo: Image, seen: Seen, own: BoolArray, shading: Shading) -> Image:
    """The photo without the light where the thing is `own` (H, W)."""
    light = light_at(shading, seen.normals[own])
    logs = np.log(photo[own] + DARK) - np.log(light)
    usual = np.median(logs, axis=0)
    tone = (logs - usual).mean(-1, keepdims=True)
    hue = logs - usual - tone
    # In what is dark, hues are noise, and what has some other light there would be far too bright.
    dim = np.clip(
        (LIGHTING.shady_ratio - light.mean(-1, keepdims=True)) / (LIGHTING.shady_ratio - LOWEST),
        0,
        1,
    )
    tone = np.where(tone > 0, (1 - LIGHTING.calmed_share * dim) * tone, tone)
    plain = np.exp(usual + tone + (1 - LIGHTING.calmed_share * dim) * hue) - DARK
    result = photo.copy()
    result[own] = np.clip(plain + 0.5, 0, 255).astype(np.uint8)
    return result


def _without_gloss(
    photo: Image, plain: Image, seen: Seen, own: BoolArray, shading: Shading
) -> tuple[Image, Shading]:
    """The picture (H, W, 3) without light, now without what shines too, which joins the light."""
    spots = _spots(photo, plain, own)
    if not spots.any():
        return plain, shading
    rows, columns = np.nonzero(own)
    size = min(np.ptp(rows), np.ptp(columns))
    wide = grow(spots, max(2, round(LIGHTING.rim_ratio * size))) & own
    radius = max(3, round(0.15 * math.sqrt(np.count_nonzero(wide))))
    part = (slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1))
    # What lies around the thing is no part of it.
    hole = (wide | ~own)[part].astype(np.uint8)
    clean = plain.copy()
    filled = np.asarray(cv2.inpaint(plain[part], hole, radius, cv2.INPAINT_TELEA), np.uint8)
    clean[part] = np.where(wide[part][..., None], filled, plain[part])
    shaded = lit(shading, clean[wide].astype(np.float64), seen.normals[wide])
    room = 255 - shaded
    more = ((photo[wide] - shaded) * room).sum(-1) / np.maximum((room**2).sum(-1), 1)
    across = int(np.clip(0.9 * size, *LIGHTING.gloss_side_px))
    gloss = _spread_out(seen.normals[own], np.clip(more, 0, 1), wide[own], shading, across)
    return clean, replace(shading, gloss=gloss)


def _spots(photo: Image, plain: Image, own: BoolArray) -> BoolArray:
    """(H, W) where a thing without its light is brighter and whiter than itself all around."""
    none = np.zeros(own.shape, bool)
    inner = shrink(own, 2)
    if not inner.any():
        return none
    logs = np.log(plain.astype(np.float64) + DARK)
    tone = logs.mean(-1)
    usual = np.median(tone[inner])
    stray = 1.5 * float(np.median(np.abs(tone[inner] - usual)))
    hues = logs - tone[..., None]
    paint = np.median(hues[inner], axis=0)
    off = np.linalg.norm(hues - paint, axis=-1)
    length = float(np.linalg.norm(paint))
    if length < LIGHTING.min_saturation_log and usual > math.log(LIGHTING.white_levels + DARK):
        # On what is white, gloss is not told from paint, and little of it is seen.
        return none
    whiter = np.linalg.norm(hues, axis=-1) < (1 - LIGHTING.min_whiter_share) * max(
        length, LIGHTING.min_saturation_log
    )
    bright = inner & (tone - usual > max(LIGHTING.min_gloss_log, 2.5 * stray)) & whiter
    usually = off < max(3 * float(np.median(off[inner])), 0.15)
    spots = _among_its_own(bright, inner, usually, photo.min(-1))
    return (
        spots
        if np.count_nonzero(spots) < LIGHTING.max_gloss_share * np.count_nonzero(inner)
        else none
    )


def _among_its_own(
    bright: BoolArray, inner: BoolArray, usual: BoolArray, white: NDArray[np.uint8]
) -> BoolArray:
    """The patches (H, W) of what is bright around which a thing has its usual hue.

    white: (H, W) how much white the photo shows: a lamp that is mirrored comes near to all of it.
    """
    count, labels, stats, _ = cv2.connectedComponentsWithStats(bright.astype(np.uint8))
    kept = np.zeros(bright.shape, bool)
    for index in range(1, count):
        if stats[index, cv2.CC_STAT_AREA] < LIGHTING.min_spot_share * np.count_nonzero(inner):
            continue
        patch = labels == index
        if white[patch].max() < LIGHTING.lamp_levels or _is_band(patch, inner):
            continue
        ring = grow(patch, 5) & ~grow(patch, 2) & inner & ~bright
        if ring.any() and usual[ring].mean() > LIGHTING.min_own_share:
            kept |= patch
    return kept


def _is_band(patch: BoolArray, inner: BoolArray) -> bool:
    """Whether a patch (H, W) goes across all of a thing from side to side: no gloss does."""
    rows = patch.any(1)
    across = patch[rows].sum(1) > LIGHTING.band_share * inner[rows].sum(1)
    return bool(across.mean() > 0.5)


def _spread_out(
    normals: FloatArray, more: FloatArray, wide: BoolArray, shading: Shading, across: int
) -> NDArray[np.uint8]:
    """(across, across) the share of white that gloss adds, 0 … 255, from pixels (N,) with normals
    (N, 3) of which `wide` have a share (M,)."""
    flat = normals @ gloss_frame(np.asarray(shading.towards, float)).T
    where = np.clip(((flat * (1, -1) + 1) / 2 * across).astype(int), 0, across - 1)
    value = np.zeros(len(normals))
    value[wide] = more
    total, count = np.zeros((across, across), np.float32), np.zeros((across, across), np.float32)
    np.add.at(total, (where[:, 1], where[:, 0]), value)
    np.add.at(count, (where[:, 1], where[:, 0]), 1)
    near = [cv2.GaussianBlur(part, (0, 0), 1.0) for part in (total, count)]
    # Between the pixels of the photo, what lies around.
    mean = np.where(count > 0, total / np.maximum(count, 1), near[0] / np.maximum(near[1], 1e-3))
    return np.clip(255 * mean + 0.5, 0, 255).astype(np.uint8)
