"""Pictures of floors and walls with things before them, and the same pictures without.

The truth of a background plate: how far what was filled in is from what was there, over textures
that make different mistakes visible (boards in perspective, tiles, carpet, a bare wall, a lane).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.benchmark.rows import Row, at_most
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.background.plate import background, hole_of
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.records.case import Image

SIZE = (416, 256)
SEEDS = 2
WALL = 5.0
"""Where the floor ends, in heights of the camera."""


@dataclass(frozen=True, eq=False, slots=True)
class Vacated:
    """A picture with things in it, their masks, the same without them, and the camera."""

    image: Image
    truth: Image
    masks: tuple[BoolArray, ...]
    camera: Camera


def vacated(texture: str, seed: int) -> Vacated:
    """Things that shade the ground before one of `TEXTURES`."""
    rng = np.random.default_rng(seed)
    pitch = math.radians(rng.uniform(10, 24))
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    camera = Camera.from_horizon(SIZE, SIZE[1] / 2 - focal * math.tan(pitch), 1.0, focal=focal)
    x, y = _ground(camera)
    floor = (y > 0) & (y < WALL)
    wall = np.array([168.0, 164, 158]) + rng.uniform(-25, 25, 3)
    light = 1 + 0.12 * (np.indices(floor.shape)[1] / SIZE[0] - 0.5)[..., None]
    clean = np.where(floor[..., None], TEXTURES[texture](x, y, rng), wall) * light
    truth = cv2.GaussianBlur(clean, (0, 0), 0.6)
    seen, masks = truth.copy(), []
    for at in (rng.uniform(0.22, 0.42), rng.uniform(0.58, 0.8)):
        foot = (at * SIZE[0], rng.uniform(0.68, 0.86) * SIZE[1])
        high = rng.uniform(0.2, 0.34) * SIZE[1]
        wide = high * rng.uniform(0.45, 1.0)
        shade = _ellipse((foot[0] + 0.45 * wide, foot[1] - 2), (0.75 * wide, 0.11 * high))
        soft = cv2.GaussianBlur(shade.astype(float), (0, 0), 0.05 * high)
        seen *= 1 - 0.55 * (soft * floor)[..., None]
        mask = _ellipse((foot[0], foot[1] - high / 2), (wide / 2, high / 2))
        seen[mask] = rng.uniform(30, 230, 3)
        masks.append(mask)
    noise = rng.normal(0, 1.5, seen.shape)
    return Vacated(_image(seen + noise), _image(truth + noise), tuple(masks), camera)


def _image(values: FloatArray) -> Image:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def _ellipse(at: tuple[float, float], radii: tuple[float, float]) -> BoolArray:
    y, x = np.indices((SIZE[1], SIZE[0]))
    return ((x - at[0]) / radii[0]) ** 2 + ((y - at[1]) / radii[1]) ** 2 < 1


def _ground(camera: Camera) -> tuple[FloatArray, FloatArray]:
    """Where on the floor each pixel lies, in heights of the camera; y < 0 above the horizon."""
    rows, columns = np.indices((SIZE[1], SIZE[0]))
    rays = camera.rays(np.stack([columns + 0.5, rows + 0.5], -1).reshape(-1, 2).astype(float))
    down = np.where(rays[:, 2] < -1e-3, -rays[:, 2], np.nan)
    ground = rays[:, :2] / down[:, None]
    ground = np.nan_to_num(ground, nan=-1.0).reshape(*rows.shape, 2)
    return ground[..., 0], ground[..., 1]


def _noise(x: FloatArray, y: FloatArray, rng: np.random.Generator, fine: float) -> FloatArray:
    """Smooth noise of unit contrast over the ground, `fine` grains to a height of the camera."""
    tile = cv2.GaussianBlur(
        rng.normal(0, 1, (256, 256)), (0, 0), 1.5, borderType=cv2.BORDER_REFLECT
    )
    tile = (tile / tile.std()).astype(np.float32)
    u, v = ((w * fine * 3 % 256).astype(np.float32) for w in (x, y))
    grain = cv2.remap(tile, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return np.asarray(grain, float)


def _boards(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> FloatArray:
    number = np.floor(x / 0.16).astype(int)
    tone = rng.uniform(-16, 16, 400)[number % 400]
    grain = _noise(x * 6, y * 0.5, rng, 9) * 5
    gap = np.abs(x / 0.16 - np.round(x / 0.16)) < 0.035
    return (tone + grain - 55 * gap)[..., None] + np.array([168.0, 120, 74])


def _tiles(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> FloatArray:
    odd = (np.floor(x / 0.3) + np.floor(y / 0.3)) % 2
    joint = (np.abs(x / 0.3 - np.round(x / 0.3)) < 0.03) | (
        np.abs(y / 0.3 - np.round(y / 0.3)) < 0.03
    )
    return (odd * 50 - 30 * joint + 3 * _noise(x, y, rng, 20))[..., None] + np.array(
        [120.0, 126, 130]
    )


def _carpet(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> FloatArray:
    return (16 * _noise(x, y, rng, 24))[..., None] + np.array([120.0, 86, 78])


def _bare(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> FloatArray:
    return (2 * _noise(x, y, rng, 6))[..., None] + np.array([196.0, 186, 170])


def _lane(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> FloatArray:
    line = np.min([np.abs(x - at) for at in (-0.62, -0.1, 0.42)], axis=0) < 0.022
    return (120 * line + 5 * _noise(x, y, rng, 16))[..., None] + np.array([70.0, 96, 84])


TEXTURES: dict[str, Callable[[FloatArray, FloatArray, np.random.Generator], FloatArray]] = {
    "boards": _boards,
    "tiles": _tiles,
    "carpet": _carpet,
    "bare": _bare,
    "lane": _lane,
}


def plate_of(item: Vacated) -> Image:
    """The plate that a reconstruction with true masks and camera would make."""
    found = segments(item.image)
    return background(item.image, item.masks, camera=item.camera, found=found)


def scores(item: Vacated, plate: Image) -> tuple[float, float, float, float]:
    """Errors of a plate: of tone in the masks, of contrast, at the seams, and shadow left over.

    Tone: mean difference in blurred colour, grey levels. Contrast: |log2| of the mean step
    between pixels against the truth's. Seam: how much larger than the truth's the steps across
    the rim are, grey levels. Shadow: mean darkness left around the feet, grey levels.
    """
    hole = hole_of(item.masks, item.truth.shape[:2])
    made, truth = plate.astype(np.float32), item.truth.astype(np.float32)
    off = np.abs(cv2.GaussianBlur(made - truth, (0, 0), 2.0)).mean(-1)
    step, true_step = steps_of(made), steps_of(truth)
    contrast = abs(math.log2(max(step[hole].mean(), 0.01) / true_step[hole].mean()))
    rim = cv2.morphologyEx(hole.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3))) > 0
    seam = float(step[rim].mean() - true_step[rim].mean())
    shaded = (item.truth.astype(float) - item.image).mean(-1) > 12
    for mask in item.masks:
        shaded &= ~mask
    dark = cv2.GaussianBlur(truth - made, (0, 0), 2.0).mean(-1)
    return float(off[hole].mean()), contrast, seam, float(np.maximum(dark[shaded], 0).mean())


def steps_of(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) how much lightness steps from pixel to pixel of a picture (H, W, 3)."""
    grey = picture.mean(-1)
    return np.hypot(cv2.Sobel(grey, -1, 1, 0) / 8, cv2.Sobel(grey, -1, 0, 1) / 8)


def plate_rows() -> list[Row]:
    """The rows of the bench: errors over textures and seeds.

    Means but for shadow, where it is the median: on chequered tiles it is not told from the tiles.
    """
    made = [vacated(texture, seed) for texture in TEXTURES for seed in range(SEEDS)]
    errors = np.array([scores(m, plate_of(m)) for m in made])
    tone, contrast, seam, _ = errors.mean(0)
    shadow = np.median(errors[:, 3])
    return [
        at_most("plates: error of tone where things stood", float(tone), 7.5, "grey levels"),
        at_most("plates: error of contrast there", float(contrast), 0.25, "octaves"),
        at_most("plates: steps at the rim beyond the true ones", float(seam), 0.5, "grey levels"),
        at_most("plates: shadow left at the feet", float(shadow), 6.0, "grey levels"),
    ]
