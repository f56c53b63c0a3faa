"""Which level top or side of a ramp each pixel shows, where the picture bears the scene out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import IntArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Support
from physagent_studio.reconstruction.background.lines_behind import along_edge, faces_of
from physagent_studio.reconstruction.background.shift_map import to_level
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class SurfaceSettings:
    """Which faces a picture bears out."""

    min_seen_share: float = 0.5  # 0.2..0.9: of a face's outline, to be seen as an edge
    beyond_number: int = -1  # number, -1..-1: of what lies above the horizon, where no ground is
    foot_share: float = 0.15  # 0.05..0.4: of a thing, from below: what stands on the face


SURFACE = SurfaceSettings()


def surfaces(
    photo: Image, hole: BoolArray, camera: Camera, supports: Sequence[Support]
) -> IntArray:
    """(H, W) the number of the face that is there, 0 for the floor, walls and whatever else.

    `BEYOND` above the horizon, where no ground is.

    Faces whose outlines are not seen in the photo beside the hole (H, W) are left out.
    """
    out = np.zeros(hole.shape, np.int32)
    grey = cv2.GaussianBlur(photo, (0, 0), 1.5).astype(float)
    number = 0
    for support in supports:
        for face in faces_of(support, camera):
            edges = np.stack([face, np.roll(face, -1, 0)], 1)
            seen = [along_edge(grey, hole, edge)[1] for edge in edges]
            long = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
            number += 1
            if float(np.average(seen, weights=long + 1e-9)) > SURFACE.min_seen_share:
                corners = np.clip(np.round(face), -20000, 20000).astype(np.int32)
                cv2.fillPoly(out, [corners], number)
    rows, columns = np.indices(hole.shape) + 0.5
    level = to_level(camera)[2]
    out[(level[0] * columns + level[1] * rows + level[2] <= 0) & (out == 0)] = SURFACE.beyond_number
    return out.astype(np.int64)


def reduced(what: BoolArray | IntArray, size: tuple[int, int]) -> IntArray:
    """Masks or numbers of faces (H, W) at another size, (width, height)."""
    small = cv2.resize(what.astype(np.int32), size, interpolation=cv2.INTER_NEAREST_EXACT)
    return np.asarray(small, np.int64)


def under(own: BoolArray, faces: IntArray) -> BoolArray:
    """(H, W) the face on which a thing (H, W) stands; 0, with what is `BEYOND`, counts as one."""
    _, y0, _, y1 = bounds(own)
    foot = grow(own, 4) & ~own
    foot[: y1 - max(1, round(SURFACE.foot_share * (y1 - y0)))] = False
    most = (
        np.bincount(faces[foot] - SURFACE.beyond_number).argmax() + SURFACE.beyond_number
        if foot.any()
        else 0
    )
    return faces <= 0 if most <= 0 else faces == most
