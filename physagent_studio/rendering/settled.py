"""The photo where it still holds: around objects that have not moved yet.

The plate has every object, its rim and what lies in its contact shadow filled in. While an
object stands where the photo shows it, the photo itself is the better picture of that place;
as soon as it moves, the plate takes over within a few pixels of motion.
"""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import NEAR, FloatArray, IntArray, Lens

_STILL = 0.25
"""Pixels of motion that nobody sees."""
_GONE = 0.02
"""Share of its own size on the picture after which an object has left its place."""
_PIXELS = (2.0, 6.0)
"""The same in pixels, at least and at most."""
_LINGERS = 0.3
"""Share of its own size over which its shadow in the photo gives way to one that is drawn."""
_RIM = 6.0
"""Pixels around an object's mask that are its own, whatever falls there."""
_DIMMER = 0.5
"""By how much farther a mirror image counts with each pixel below its object: it gets fainter."""
_SHARED = 0.01
"""By how much farther a shadow counts with each pixel from its object: shadows overlap."""
_SOFT = 5.0
"""Standard deviation of the blur, pixels, over which one object's shadow gives way to another's."""
_BLURRED = 24
"""Rows from which a blur of that width takes anything."""


@dataclass(frozen=True, eq=False, slots=True)
class Settled:
    """Pixels in which photo and plate differ, each with the object that is the reason.

    pixel: (K,) flat, where photo and plate differ. apart: (K,) 0 … 1 how far that is from all
    masks. near: (H·W,) the object that is the reason,
    −1 without masks. photo: (H·W, 3). rows: (K,) vertices that tell motion; owner:
    (K,) their object; outline: (K, 2) their pixels at the initial pose. size: (N,) pixels
    across each object.
    """

    pixel: NDArray[np.int64]
    apart: NDArray[np.float32]
    near: NDArray[np.int32]
    photo: Picture
    rows: IntArray
    owner: IntArray
    outline: FloatArray
    size: FloatArray
    lens: Lens

    @classmethod
    def of(
        cls,
        photo: Picture,
        plate: Picture,
        masks: list[NDArray[np.bool_] | None],
        shadows: list[NDArray[np.bool_]],
        batch: Batch,
        points: FloatArray,
        lens: Lens,
    ) -> Self:
        """Prepare; points: (V, 3) camera frame, initial pose.

        masks: (H, W) per object. shadows: (H, W) where each casts one that the photo shows.
        """
        near = _reasons(masks, shadows, photo.shape[:2]).ravel()
        pixel = np.flatnonzero((photo != plate).any(-1).ravel() & (near >= 0))
        apart = apart_from(masks, photo.shape[:2]).ravel()[pixel]
        flat = np.ascontiguousarray(photo).reshape(-1, 3)
        rows = np.concatenate([caster.rows for caster in batch.casters] or [[]]).astype(np.int32)
        outline, owner = _projected(points[rows], lens), batch.owner[rows]
        size = _sizes(outline, owner, len(batch.casters))
        return cls(pixel, apart, near, flat, rows, owner, outline, size, lens)

    def weights(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N,) how much each object is still where the photo shows it: 1 exactly, 0 not at all;
        and (N,) how much of the shade and shine that the photo shows away from it still holds.

        points: (V, 3) camera frame, now.
        """
        moved = np.linalg.norm(_projected(points[self.rows], self.lens) - self.outline, axis=1)
        farthest = np.zeros(len(self.size))
        np.maximum.at(farthest, self.owner, moved)
        reach = np.clip(_GONE * self.size, *_PIXELS)
        slower = np.maximum(_LINGERS * self.size, reach)
        still, lingering = (1 - np.clip((farthest - _STILL) / r, 0, 1) for r in (reach, slower))
        return still, lingering

    def restore(self, plate: Picture, weights: FloatArray, lingering: FloatArray) -> Picture:
        """The plate with the photo where its objects still stand, and their shade beside them."""
        share = weights[self.near[self.pixel]]
        if len(share) and min(share.min(), lingering.min()) < 1:
            share = share + (self._soft(lingering) - share) * self.apart
        mine = np.flatnonzero(share > 0)
        if not len(mine):
            return plate
        result = plate.copy()
        flat = result.reshape(-1, 3)
        pixel, part = self.pixel[mine], share[mine, None].astype(np.float32)
        mixed = flat[pixel] * (1 - part) + self.photo[pixel] * part
        flat[pixel] = (mixed + 0.5).astype(np.uint8)
        return result

    def _soft(self, weights: FloatArray) -> NDArray[np.float32]:
        """(K,) the weights, those of neighbours running into one another."""
        width = self.lens.width
        first = max(int(self.pixel[0]) // width - _BLURRED, 0)
        near = self.near[first * width : (int(self.pixel[-1]) // width + _BLURRED) * width]
        whole = np.append(weights, 0).astype(np.float32)[near]
        soft = cv2.GaussianBlur(whole.reshape(-1, width), (0, 0), _SOFT)
        return np.asarray(soft, np.float32).ravel()[self.pixel - first * width]

    def shares(
        self, pixel: NDArray[np.int64], owner: NDArray[np.int32], weights: FloatArray
    ) -> NDArray[np.float32]:
        """(K,) how much of the photo still holds at pixels where objects are drawn.

        It shows the object itself, or the one before it, so both must stand where they stood.
        """
        near = self.near[pixel]
        share = weights[owner] * np.where(near >= 0, weights[near], 0)
        return np.asarray(share, np.float32)

    def keep(
        self,
        colors: NDArray[np.float32],
        pixel: NDArray[np.int64],
        owner: NDArray[np.int32],
        weights: FloatArray,
    ) -> NDArray[np.float32]:
        """Colours (K, 3) of objects, the photo's own where they stand as it shows them."""
        share = self.shares(pixel, owner, weights)
        if not share.any():
            return colors
        return np.asarray(colors + (self.photo[pixel] - colors) * share[:, None], np.float32)


def _projected(points: FloatArray, lens: Lens) -> FloatArray:
    return lens.project(np.maximum(points, (-np.inf, -np.inf, NEAR)))


def _sizes(outline: FloatArray, owner: IntArray, count: int) -> FloatArray:
    sizes = np.zeros(count)
    for index in range(count):
        mine = outline[owner == index]
        sizes[index] = np.ptp(mine, axis=0).max() if len(mine) else 0.0
    return sizes


def apart_from(
    masks: list[NDArray[np.bool_] | None], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(H, W) 0 within the rims of the masks, 1 far from all of them."""
    things = [mask for mask in masks if mask is not None and mask.shape == shape]
    free = ~np.any([np.zeros(shape, bool), *things], axis=0)
    away = cv2.distanceTransform(free.astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray(np.clip(away / _RIM - 1, 0, 1), np.float32)


def _reasons(
    masks: list[NDArray[np.bool_] | None], shadows: list[NDArray[np.bool_]], shape: tuple[int, ...]
) -> NDArray[np.int32]:
    """(H, W) index of the object to which a place belongs; −1 where there are no masks.

    That is the one whose mask, then shadow, then mirror image is there, or nearest; where several
    cast a shadow it is the one whose mask is nearest.
    """
    nearest = np.full(shape, -1, np.int32)
    least = np.full(shape, np.inf, np.float32)
    for index, (mask, shadow) in enumerate(zip(masks, shadows, strict=True)):
        if mask is None or mask.shape != shape or not mask.any():
            continue
        below = np.maximum(np.arange(shape[0])[:, None] - np.flatnonzero(mask.any(1))[-1], 0)
        own = _away(mask)
        cast = _away(shadow) + _RIM + _SHARED * own
        for away in (own, cast, _away(_mirrored(mask)) + _RIM + _DIMMER * below):
            closer = away < least
            nearest[closer] = index
            least = np.minimum(least, away)
    return nearest


def _away(part: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(H, W) pixels to the nearest place of a part."""
    return np.asarray(cv2.distanceTransform((~part).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def _mirrored(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The mask (H, W) upside down below its lowest row, as polished ground shows its object."""
    rows = 2 * int(np.flatnonzero(mask.any(1))[-1]) + 1 - np.arange(len(mask))
    inside = (rows >= 0) & (rows < len(mask))
    return np.asarray(mask[rows.clip(0, len(mask) - 1)] & inside[:, None])
