"""The colours of a round body in all directions, from a photo that shows less than half of it.

The photo is taken where the body is seen at no flat angle. Beyond, its detail comes again, folded
over the edges of a cube around the body, in the light that falls there. What is there once, as the
calyx of a fruit is, is not repeated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Self

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray, FloatImage
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.round_light import fitted, is_pattern, terms_of
from physagent_studio.records.case import Image
from physagent_studio.rendering.lit import bilinear


@dataclass(frozen=True, slots=True)
class BallSettings:
    """How the sides of a ball are painted from its first one."""

    max_off_ratio: float = 0.05  # 0.01..0.2: over the radius: what has stems is no ball
    # 40..85: from the view: the photo itself within the first, not beyond the second
    shown_deg: tuple[float, float] = (60.0, 70.0)
    # 30..80: the same where the light is off it: what is left of shade at its rim would roll along
    unlit_shown_deg: tuple[float, float] = (45.0, 60.0)
    # exponent, 2..20: how narrow the zones are in which sides pass into one another
    zone_power: int = 8
    # 1..2: over the middle's distance: half the extent of a side's picture
    side_half_ratio: float = 1.3
    side_px: tuple[int, int] = (16, 256)  # 8..512: across such a picture, least and most
    lit_deg: float = 62.0  # 45..75: from the view within which the photo tells how light falls
    # 4..40: added to colours before their log, so that dark noise stays small
    dark_levels: float = 16.0
    spot_percent: float = 8.0  # %, 1..20: below it what is dark is a spot that is there once
    # %, 80..99: beyond it what is bright is gloss and stays on the first side
    gloss_percent: float = 92.0
    knee_ratio: float = 1.5  # 1..3: over those two: how far detail comes
    # 1..4: over the middle's distance: half the picture of what is repeated
    span_ratio: float = 2.0
    detail_px: int = 160  # 64..400: across it
    min_strange_log: float = 0.3  # 0.1..0.8: of detail that is there once
    strange_factor: float = 4.0  # 2..10: of what is usual on the body, likewise
    # 0.4..1.5: of such detail, from which a body is of several colours
    many_colours_log: float = 0.8
    painted_log: float = 0.45  # 0.2..1: of such detail, from which a body is painted in patches


BALL = BallSettings()

SEEN_WELL = math.cos(math.radians(BALL.lit_deg))

# x is right and y up as the camera sees the body, z looks at the camera.
FOLDS = (
    np.eye(3),
    np.array([[0, 0, 1], [0, 1, 0], [1, 0, 0]], float),
    np.array([[0, 0, -1], [0, 1, 0], [-1, 0, 0]], float),
    np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]], float),
    np.array([[1, 0, 0], [0, 0, -1], [0, -1, 0]], float),
    np.array([[-1, 0, 0], [0, 1, 0], [0, 0, -1]], float),
)
"""By which map each side's directions become those of the first one: first itself, then the right,
left, upper, lower and back sides."""


@dataclass(frozen=True, eq=False, slots=True)
class Ball:
    """A body as a unit sphere. frame: (3, 3) columns are its x, y and z in the world. stretch:
    (3, 3) from the unit sphere to the ellipsoid, world. photo, origin: the crop, and its corner in
    the photo. light: (6, 3) see `terms_of`, log. mean: (3,) of it. least, most: (3,) darkest and
    brightest detail, log. strange: from what detail on something is there once, log. detail:
    (K, K, 3) of the first side, see `_usual`. shown: as `shown_deg`.
    """

    frame: FloatArray
    stretch: FloatArray
    place: FloatArray
    camera: Camera
    photo: Image
    origin: FloatArray
    light: FloatArray
    mean: FloatArray
    least: FloatArray
    most: FloatArray
    shown: tuple[float, float] = BALL.shown_deg
    strange: float = math.inf
    patterned: bool = False
    detail: FloatImage = field(default_factory=lambda: np.zeros((2, 2, 3), np.float32))

    @classmethod
    def of(
        cls,
        camera: Camera,
        item: SceneObject,
        radii: FloatArray,
        crop: tuple[Image, tuple[int, int]],
        shown: tuple[float, float],
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
        return cls(frame, stretch, place, camera, *where, *dull, shown)

    def pixels(self, ways: FloatArray) -> FloatArray:
        """Where in the crop (N, 2) directions (N, 3) of the first side are seen."""
        world = self.place + ways @ self.frame.T @ self.stretch.T
        return self.camera.project(world)[0] - self.origin

    def colours(self, ways: FloatArray) -> FloatArray:
        """Colours (N, 3) in all directions (N, 3)."""
        angle = np.degrees(np.arccos(np.clip(ways[:, 2], -1, 1)))
        if self.patterned:
            return self._photographed(_led_inward(ways))
        first = np.clip((self.shown[1] - angle) / (self.shown[1] - self.shown[0]), 0, 1)[:, None]
        detail, total = np.zeros((len(ways), 3)), np.zeros((len(ways), 1))
        for fold in FOLDS:
            own = ways @ fold.T
            weight = (
                np.maximum(own[:, 2:] - math.cos(math.radians(BALL.lit_deg)), 0) ** BALL.zone_power
            )
            detail += weight * _bent(self._repeated(own), self.least, self.most)
            total += weight
        others = np.exp(self._tone(ways) + detail / np.maximum(total, 1e-12)) - BALL.dark_levels
        return first * self._photographed(ways) + (1 - first) * others

    def _repeated(self, ways: FloatArray) -> FloatArray:
        """Detail (N, 3) that may be there several times, in directions of the first side."""
        flat = ways[:, :2] / np.maximum(ways[:, 2:], 0.2)
        where = (flat / BALL.span_ratio + 1) / 2 * len(self.detail) - 0.5
        return bilinear(self.detail, where).astype(np.float64)

    def _usual(self, mask: BoolArray) -> tuple[FloatImage, bool]:
        """(K, K, 3) the detail of the first side without what is there once: a calyx, a bruise;

        and whether what stands out there is a pattern.
        """
        y, x = (
            (np.indices((BALL.detail_px, BALL.detail_px)) + 0.5) / BALL.detail_px * 2 - 1
        ) * BALL.span_ratio
        ways = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], 1)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        detail = self._detail(ways)
        strange = (np.abs(detail).mean(-1) > self.strange) & (ways[:, 2] > SEEN_WELL)
        patterned = is_pattern(strange.reshape(x.shape))
        if not at_work("things once") or patterned:
            return np.asarray(detail.reshape(*x.shape, 3), np.float32), patterned
        strange |= ~self._within(ways, mask)
        wide = cv2.dilate(strange.reshape(x.shape).astype(np.uint8), np.ones((5, 5), np.uint8))
        kept = cv2.GaussianBlur(1 - grow(wide > 0, 3).astype(np.float32), (0, 0), 1.5)
        kept = np.where(wide > 0, 0, kept)[..., None]
        return np.asarray(kept * detail.reshape(*x.shape, 3), np.float32), False

    def _within(self, ways: FloatArray, mask: BoolArray) -> BoolArray:
        """(N,) whether directions (N, 3) of the first side are seen in the mask (H, W)."""
        column, row = (self.pixels(ways) + self.origin).astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < mask.shape[1]) & (row < mask.shape[0])
        inside[inside] = mask[row[inside], column[inside]]
        return np.asarray(inside, bool)

    def _detail(self, ways: FloatArray) -> FloatArray:
        """What the photo shows (N, 3) beside the light, log, in directions of the first side."""
        return np.log(self._photographed(ways) + BALL.dark_levels) - terms_of(ways) @ self.light

    def _tone(self, ways: FloatArray) -> FloatArray:
        """The log of the body's colour in its light (N, 3), evener the farther from the view."""
        angle = np.arccos(np.clip(ways[:, 2], -1, 1))
        limit = math.radians(BALL.lit_deg)
        flat = ways[:, :2] / np.maximum(np.linalg.norm(ways[:, :2], axis=1, keepdims=True), 1e-9)
        near = np.minimum(angle, limit)[:, None]
        seen = np.column_stack([flat * np.sin(near), np.cos(near)])
        share = np.clip((angle - limit) / (math.pi - limit), 0, 1)[:, None]
        even = (1 - share) ** 2
        return even * (terms_of(seen) @ self.light) + (1 - even) * self.mean

    def _photographed(self, ways: FloatArray) -> FloatArray:
        where = self.pixels(np.where(ways[:, 2:] > 0, ways, (0.0, 0, 1))) - 0.5
        return bilinear(self.photo, where).astype(np.float64)

    def lit(self, mask: BoolArray) -> Self:
        """The same, with the light that the photo shows on it where the mask (H, W) is."""
        share = (np.arange(24) + 0.5) / 24
        around = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        # Evenly spread over the cap that the camera sees well.
        up = np.repeat(1 - share * (1 - math.cos(math.radians(BALL.lit_deg))), len(around))
        flat = np.sqrt(1 - up**2)
        turn = np.tile(around, len(share))
        ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], 1)
        inside = self._within(ways, mask)
        if np.count_nonzero(inside) < 40:
            return self
        ways = ways[inside]
        tone = np.log(self._photographed(ways) + BALL.dark_levels)
        fit = fitted(terms_of(ways), tone)
        rest = tone - terms_of(ways) @ fit
        mean = (terms_of(ways) @ fit).mean(0)
        least, most = np.percentile(rest, (BALL.spot_percent, BALL.gloss_percent), axis=0)
        strange = max(
            BALL.min_strange_log, BALL.strange_factor * float(np.median(np.abs(rest).mean(-1)))
        )
        lit = replace(self, light=fit, mean=mean, least=least, most=most, strange=strange)
        detail, patterned = lit._usual(mask)
        return replace(lit, detail=detail, patterned=patterned or strange > BALL.painted_log)


def _led_inward(ways: FloatArray) -> FloatArray:
    """Directions (N, 3), those beyond the rim of what is shown led back, farthest to its middle.

    So patches of paint go on over the rim and stay patches, if larger ones.
    """
    angle = np.arccos(np.clip(ways[:, 2], -1, 1))
    rim = math.radians(BALL.shown_deg[1])
    led = np.where(angle > rim, rim * (np.pi - angle) / (np.pi - rim), angle)
    flat = ways[:, :2] / np.maximum(np.linalg.norm(ways[:, :2], axis=1, keepdims=True), 1e-9)
    return np.column_stack([flat * np.sin(led)[:, None], np.cos(led)])


def _bent(values: FloatArray, least: FloatArray, most: FloatArray) -> FloatArray:
    """Values (N, 3) drawn in towards least < 0 and most > 0 (3,), without flats where they end."""
    bound = BALL.knee_ratio * np.where(values < 0, np.minimum(least, -1e-6), np.maximum(most, 1e-6))
    known = np.where(np.isfinite(bound), bound, 1.0)
    return np.where(np.isfinite(bound), known * np.tanh(values / known), values)
