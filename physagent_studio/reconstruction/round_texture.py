"""The photo on a ball, an egg or a fruit, of which it shows less than half.

The rim of that is seen at too flat an angle to be of use when the thing has rolled.

The body is covered by the six sides of a cube around it, the first of which looks at the camera.
The others show the first one again, folded over the edges that they share with it, in the light
that falls on them; where they meet they pass into one another.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.camera import Camera
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene import Ellipsoid, Revolved, SceneObject, Sphere
from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh

FloatArray = NDArray[np.float64]
OFF = 0.05
"""How far vertices may be off a round outline, in radii: what has stems is no ball."""
LEAST = 0.72
"""How near to its middle the outline of a round thing may come, in radii."""
ROUNDISH = 0.45
"""How flat or slim it may be."""
SHOWN = (60.0, 70.0)
"""Angle from the view within which the photo itself is shown, and beyond which no longer, °."""
NARROW = 8
"""How narrow the zones are in which two sides pass into one another."""
WIDE = 1.3
"""Half the extent of a side's picture, in its distance from the middle of the body."""
SIDE = (16, 256)
"""Pixels across such a picture, at least and at most."""
LIT = 62.0
"""Angle from the view within which the photo tells how light falls on the body, °."""
DARK = 16.0
"""Added to colours before their log is taken, grey levels."""
SPOT = 8.0
"""Percentile below which what is dark on it is a spot that is there once."""
GLOSS = 92.0
"""Percentile beyond which what is bright on the body is gloss, and stays on the first side."""

# x is right and y up as the camera sees the body, z looks at the camera.
_FIRST = np.eye(3)
_SIDES = {
    "right": np.array([[0, 0, 1], [0, 1, 0], [1, 0, 0]], float),
    "left": np.array([[0, 0, -1], [0, 1, 0], [-1, 0, 0]], float),
    "up": np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]], float),
    "down": np.array([[1, 0, 0], [0, 0, -1], [0, -1, 0]], float),
    "back": np.array([[-1, 0, 0], [0, 1, 0], [0, 0, -1]], float),
}
"""By which map each side's directions become those of the first one."""


@dataclass(frozen=True, eq=False, slots=True)
class _Ball:
    """A body as a unit sphere. frame: (3, 3) columns are its x, y and z in the world. stretch:
    (3, 3) from the unit sphere to the ellipsoid, world. axis: (3,) unit, and outline: (K, 2) how
    far out the body is, in the ellipsoid's radii, by the cosine with that axis. photo, origin:
    the crop, and its corner in the photo. light: (6, 3) see `_terms`, log. mean: (3,) of it.
    least, most: (3,) darkest and brightest detail, log.
    """

    frame: FloatArray
    stretch: FloatArray
    place: FloatArray
    camera: Camera
    axis: FloatArray
    outline: FloatArray
    photo: Image
    origin: FloatArray
    light: FloatArray
    mean: FloatArray
    least: FloatArray
    most: FloatArray

    @classmethod
    def of(
        cls,
        camera: Camera,
        item: SceneObject,
        radii: FloatArray,
        outline: FloatArray,
        crop: tuple[Image, tuple[int, int]],
    ) -> Self:
        """Without any light on it yet."""
        place = np.asarray(item.position, float)
        turn = matrix_of(item.rotation)
        stretch = turn @ np.diag(radii) @ turn.T
        view = np.linalg.solve(stretch, np.asarray(camera.position) - place)
        view /= np.linalg.norm(view)
        across = np.cross(-camera.matrix[:, 1], view)
        across /= np.linalg.norm(across)
        frame = np.stack([across, np.cross(view, across), view], 1)
        dull = np.zeros((6, 3)), np.zeros(3), np.full(3, -np.inf), np.full(3, np.inf)
        where = crop[0], np.array(crop[1], float)
        return cls(frame, stretch, place, camera, turn[:, 2], outline, *where, *dull)

    def pixels(self, ways: FloatArray) -> FloatArray:
        """Where in the crop (N, 2) directions (N, 3) of the first side are seen."""
        unit = ways @ self.frame.T
        upright = np.clip(unit @ self.axis, -1, 1)
        out = np.interp(upright, self.outline[:, 0], self.outline[:, 1])
        world = self.place + (out[:, None] * unit) @ self.stretch.T
        return self.camera.project(world)[0] - self.origin

    def colours(self, ways: FloatArray) -> FloatArray:
        """Colours (N, 3) in all directions (N, 3)."""
        angle = np.degrees(np.arccos(np.clip(ways[:, 2], -1, 1)))
        first = np.clip((SHOWN[1] - angle) / (SHOWN[1] - SHOWN[0]), 0, 1)[:, None]
        detail, total = np.zeros((len(ways), 3)), np.zeros((len(ways), 1))
        for fold in (_FIRST, *_SIDES.values()):
            own = ways @ fold.T
            weight = np.maximum(own[:, 2:] - math.cos(math.radians(LIT)), 0) ** NARROW
            detail += weight * np.clip(self._detail(own), self.least, self.most)
            total += weight
        others = np.exp(self._tone(ways) + detail / np.maximum(total, 1e-12)) - DARK
        return first * self._photographed(ways) + (1 - first) * others

    def _detail(self, ways: FloatArray) -> FloatArray:
        """What the photo shows (N, 3) beside the light, log, in directions of the first side."""
        return np.log(self._photographed(ways) + DARK) - _terms(ways) @ self.light

    def _tone(self, ways: FloatArray) -> FloatArray:
        """The log of the body's colour in its light (N, 3), evener the farther from the view."""
        angle = np.arccos(np.clip(ways[:, 2], -1, 1))
        limit = math.radians(LIT)
        flat = ways[:, :2] / np.maximum(np.linalg.norm(ways[:, :2], axis=1, keepdims=True), 1e-9)
        near = np.minimum(angle, limit)[:, None]
        seen = np.column_stack([flat * np.sin(near), np.cos(near)])
        share = np.clip((angle - limit) / (math.pi - limit), 0, 1)[:, None]
        even = (1 - share) ** 2
        return even * (_terms(seen) @ self.light) + (1 - even) * self.mean

    def _photographed(self, ways: FloatArray) -> FloatArray:
        where = (self.pixels(np.where(ways[:, 2:] > 0, ways, (0.0, 0, 1))) - 0.5).astype(np.float32)
        x, y = (np.ascontiguousarray(where[:, k])[None] for k in (0, 1))
        fold = 16384
        parts = [
            cv2.remap(
                self.photo,
                x[:, k : k + fold],
                y[:, k : k + fold],
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )[0]
            for k in range(0, len(ways), fold)
        ]
        return np.concatenate(parts).astype(float)

    def lit(self, mask: BoolArray) -> Self:
        """The same, with the light that the photo shows on it where the mask (H, W) is."""
        share = (np.arange(24) + 0.5) / 24
        around = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        # Evenly spread over the cap that the camera sees well.
        up = np.repeat(1 - share * (1 - math.cos(math.radians(LIT))), len(around))
        flat = np.sqrt(1 - up**2)
        turn = np.tile(around, len(share))
        ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], 1)
        column, row = (self.pixels(ways) + self.origin).astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < mask.shape[1]) & (row < mask.shape[0])
        inside[inside] = mask[row[inside], column[inside]]
        if np.count_nonzero(inside) < 40:
            return self
        ways = ways[inside]
        tone = np.log(self._photographed(ways) + DARK)
        fit = _fitted(_terms(ways), tone)
        rest = tone - _terms(ways) @ fit
        mean = (_terms(ways) @ fit).mean(0)
        least, most = np.percentile(rest, (SPOT, GLOSS), axis=0)
        return replace(self, light=fit, mean=mean, least=least, most=most)


def _terms(ways: FloatArray) -> FloatArray:
    """(N, 6) of which light on a body is a sum, by direction (N, 3)."""
    x, y = ways[:, 0], ways[:, 1]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)


def _fitted(terms: FloatArray, tone: FloatArray) -> FloatArray:
    """(6, 3) by which terms (N, 6) come nearest to most of what is seen (N, 3)."""
    pull = 0.01 * len(terms) * np.diag([0.0, 1, 1, 1, 1, 1])
    weight, fit = np.ones(len(terms)), np.zeros((terms.shape[1], 3))
    for _ in range(8):
        fit = np.linalg.solve((terms.T * weight) @ terms + pull, (terms.T * weight) @ tone)
        rest = np.abs(tone - terms @ fit).mean(-1)
        # What is painted otherwise, and highlights, are no light.
        weight = 1 / (1 + (rest / max(1.5 * float(np.median(rest)), 0.03)) ** 2)
    return np.asarray(fit, np.float64)


def round_textured(
    camera: Camera,
    item: SceneObject,
    mesh: Mesh,
    mask: BoolArray,
    crop: tuple[Image, tuple[int, int]],
) -> Mesh | None:
    """The mesh of a ball, an ellipsoid or a roundish fruit with the photo on all its sides.

    None for others. crop: the photo around the thing (h, w, 3) and its top left corner (x, y) in
    the photo.
    """
    radii = _radii(item, mesh)
    if radii is None:
        return None
    unit = mesh.vertices / radii
    away = np.linalg.norm(unit, axis=1)
    if away.min() < LEAST:
        return None
    upright = unit[:, 2] / away
    order = np.argsort(upright, kind="stable")
    outline = np.stack([upright[order], away[order]], 1)
    if np.abs(np.interp(upright, *outline.T) - away).max() > OFF:
        return None
    ball = _Ball.of(camera, item, radii, outline, crop).lit(mask)
    turned = mesh.vertices @ matrix_of(item.rotation).T
    ways = np.linalg.solve(ball.stretch, turned.T).T @ ball.frame
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    folds = [_FIRST, *_SIDES.values()]
    middle = ways[mesh.faces].mean(1)
    side = np.argmax([(middle @ fold.T)[:, 2] for fold in folds], 0)
    return _laid_out(ball, mesh, ways, side, folds)


def _radii(item: SceneObject, mesh: Mesh) -> FloatArray | None:
    """(3,) of the ellipsoid that a body is or comes near to; None for none."""
    if isinstance(item.shape, Sphere):
        return np.full(3, item.shape.radius)
    if isinstance(item.shape, Ellipsoid):
        return np.asarray(item.shape.radii, float)
    if not isinstance(item.shape, Revolved) or item.shape.wall is not None:
        return None
    radii = np.maximum(np.abs(mesh.vertices).max(0), 1e-9)
    return radii if ROUNDISH < radii[2] / radii[0] < 1 / ROUNDISH else None


def _laid_out(
    ball: _Ball, mesh: Mesh, ways: FloatArray, side: NDArray[np.intp], folds: list[FloatArray]
) -> Mesh:
    """Every side's faces with vertices of their own, and the sides' pictures beside the crop."""
    rows, columns = ball.photo.shape[:2]
    across = int(np.clip(0.8 * min(rows, columns), *SIDE))
    texture = np.zeros((max(rows, across), columns + across * (len(folds) - 1), 3), np.uint8)
    texture[:rows, :columns] = ball.photo
    vertices, faces, places = [], [], []
    count = 0
    for number, fold in enumerate(folds):
        own = mesh.faces[side == number]
        used, compact = np.unique(own, return_inverse=True)
        vertices.append(mesh.vertices[used])
        faces.append(compact.reshape(-1, 3) + count)
        count += len(used)
        if number == 0:
            places.append(ball.pixels(ways[used]))
            continue
        left = columns + across * (number - 1)
        texture[:across, left : left + across] = _picture(ball, fold, across)
        local = ways[used] @ fold.T
        flat = local[:, :2] / np.maximum(local[:, 2:], 0.2)
        spot = (np.clip(flat, -WIDE, WIDE) / WIDE + 1) / 2 * across
        places.append(np.clip(spot, 0.5, across - 0.5) + np.array([left, 0]))
    uv = np.concatenate(places)
    edge = np.array([texture.shape[1], texture.shape[0]])
    return Mesh(
        np.concatenate(vertices),
        np.concatenate(faces).astype(np.int32),
        np.clip(uv, 0.5, edge - 0.5),
        texture,
        mesh.color,
    )


def _picture(ball: _Ball, fold: FloatArray, across: int) -> Image:
    """What a side shows, (across, across, 3)."""
    y, x = ((np.indices((across, across)) + 0.5) / across * 2 - 1) * WIDE
    local = np.stack([x.ravel(), y.ravel(), np.ones(across * across)], 1)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    colours = ball.colours(local @ fold)  # The folds are their own inverses but for a transpose.
    return np.clip(colours + 0.5, 0, 255).reshape(across, across, 3).astype(np.uint8)
