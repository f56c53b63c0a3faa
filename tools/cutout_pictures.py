"""Things cut out of photographs, put before other photographs: real looks with known masks.

Generated pictures are what the network of the masks was fitted on; what it is worth beyond them is
measured on these. Nothing of them is part of this repository: any folder of PNGs with transparency
and any folder of photographs will do. The figures in docs/ledger.md are of 136 photos among the
stamps of Tux Paint (Debian's tuxpaint-stamps-default), before twelve pictures of OpenCV's samples,
scikit-learn's and Gradio's.

    python -m tools.cutout_pictures THINGS GROUNDS [--every N]    IoU of masks by click and by box
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.case import Image

SIZE = (720, 480)
LEAST_PX, LEAST_SIDE_PX, LEAST_COLOURS = 5000, 150, 1500
"""Of a thing: pixels, those of its longer side, and colours: drawings have fewer than photos."""
MOST_SOFT = 0.25
"""Share of a thing that may be half transparent."""


@dataclass(frozen=True, eq=False, slots=True)
class Cutout:
    """A picture (H, W, 3) with one thing in it, and the thing's mask (H, W)."""

    name: str
    image: Image
    mask: BoolArray

    @property
    def box(self) -> Grounding:
        """The box around the thing."""
        rows, columns = self.mask.nonzero()
        sides = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
        return Grounding(box=tuple(float(side) for side in sides))

    @property
    def click(self) -> Grounding:
        """A click where the thing is widest."""
        solid = np.pad(self.mask, 1).astype(np.uint8)
        inner = cv2.distanceTransform(solid, cv2.DIST_L2, 5)[1:-1, 1:-1]
        row, column = np.unravel_index(int(inner.argmax()), inner.shape)
        return Grounding(points=(Click(x=float(column), y=float(row)),))


def things_in(folder: Path) -> list[Path]:
    """The photographs with transparency that are large enough and not merely drawn."""
    return [path for path in sorted(folder.rglob("*.png")) if _is_photographed(path)]


def _is_photographed(path: Path) -> bool:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim < 3 or image.shape[2] < 4:
        return False
    alpha = image[..., 3]
    solid = alpha > 128
    if solid.sum() < LEAST_PX or max(solid.shape) < LEAST_SIDE_PX:
        return False
    colours = np.unique((image[solid][:, :3] // 4).astype(int) @ (1, 64, 4096))
    soft = np.count_nonzero((alpha > 20) & (alpha < 235))
    return len(colours) >= LEAST_COLOURS and soft < MOST_SOFT * solid.sum()


def cutout(thing: Path, grounds: list[Path], seed: int) -> Cutout:
    """A thing somewhere before one of the photographs, sharp, blurred or over a plain ground."""
    rng = np.random.default_rng(seed)
    ground = _ground(grounds[rng.integers(len(grounds))], rng)
    cut = cv2.imread(str(thing), cv2.IMREAD_UNCHANGED)
    rows, columns = ground.shape[:2]
    factor = rng.uniform(0.35, 0.7) * rows / max(cut.shape[0], 0.8 * cut.shape[1])
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    cut = cv2.resize(cut, None, fx=factor, fy=factor, interpolation=how)[: rows - 8, : columns - 8]
    height, width = cut.shape[:2]
    x = int(rng.uniform(4, columns - width - 3))
    y = int(rng.uniform(min(0.35 * rows, rows - height - 4), rows - height - 3))
    shade = np.zeros((rows, columns), np.float32)
    foot = (x + round(0.6 * width), y + height - 4), (max(5, width // 2), max(4, height // 11))
    cv2.ellipse(shade, *foot, 0, 0, 360, 1, -1)
    ground *= 1 - 0.45 * cv2.GaussianBlur(shade, (0, 0), max(2, 0.03 * height))[..., None]
    alpha = np.zeros((rows, columns, 1), np.float32)
    alpha[y : y + height, x : x + width] = cut[..., 3:] / 255
    ground[y : y + height, x : x + width] += alpha[y : y + height, x : x + width] * (
        cut[..., :3] - ground[y : y + height, x : x + width]
    )
    seen = cv2.GaussianBlur(ground, (0, 0), 0.6) + rng.normal(0, 1.5, ground.shape)
    image = np.ascontiguousarray(np.clip(seen, 0, 255).astype(np.uint8)[..., ::-1])
    return Cutout(thing.stem, image, alpha[..., 0] > 0.5)


def _ground(path: Path, rng: np.random.Generator) -> np.ndarray:
    """A piece of a photograph, one in four with a plain ground below a horizon."""
    photo = cv2.imread(str(path))
    columns, rows = SIZE
    factor = max(columns / photo.shape[1], rows / photo.shape[0]) * rng.uniform(1.0, 1.6)
    photo = cv2.resize(photo, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    y, x = (
        rng.integers(have - want + 1)
        for have, want in zip(photo.shape[:2], (rows, columns), strict=True)
    )
    part = photo[y : y + rows, x : x + columns].astype(np.float32)
    kind = rng.random()
    if kind < 0.4:
        part = cv2.GaussianBlur(part, (0, 0), rng.uniform(4, 12))
    if kind < 0.25:
        low = int(rows * rng.uniform(0.2, 0.45))
        tone = part.mean((0, 1)) * rng.uniform(0.6, 1.3)
        even = np.linspace(0.85, 1.1, rows - low)[:, None, None]
        part[low:] = np.clip(tone * even + rng.normal(0, 4, (rows - low, columns, 1)), 0, 255)
    return part


def cutouts(things: Path, grounds: Path) -> Iterator[Cutout]:
    """A picture of each thing; the same bits each time."""
    behind = sorted(one for kind in ("*.jpg", "*.png") for one in grounds.glob(kind))
    for seed, path in enumerate(things_in(things)):
        yield cutout(path, behind, seed)


def main() -> None:
    """Prints the IoU of each thing's first mask, by click and by box, and what they come to."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("things", type=Path)
    words.add_argument("grounds", type=Path)
    words.add_argument("--every", type=int, default=1)
    asked = words.parse_args()
    found: list[tuple[float, float]] = []
    for number, one in enumerate(cutouts(asked.things, asked.grounds)):
        if number % asked.every:
            continue
        offers = (
            EmbeddedSegmenter().segment(one.image, [("thing", way)])["thing"]
            for way in (one.click, one.box)
        )
        found.append(tuple(iou(offer[0].mask, one.mask) if offer else 0.0 for offer in offers))
        print(one.name, *(f"{value:.2f}" for value in found[-1]), flush=True)
    for title, values in zip(("click", "box"), np.transpose(found), strict=True):
        print(f"{title}: mean {values.mean():.3f}, median {np.median(values):.3f},", end=" ")
        print(f"p25 {np.quantile(values, 0.25):.3f}, above .8 {(values > 0.8).mean():.2f}")


if __name__ == "__main__":
    main()
