"""Pictures laid out as a sheet, each under its label, and clicks drawn on them."""

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Click
from physagent_studio.records.case import Image

SHEET_COLUMNS = 6
CELL_WIDTH = 320
LABEL_ROWS = 20
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def fitted(pixels: Image, side: int) -> Image:
    """The picture with its longest side at most `side` pixels; never enlarged."""
    rows, columns = pixels.shape[:2]
    scale = side / max(rows, columns)
    if scale >= 1:
        return pixels
    size = (max(1, round(columns * scale)), max(1, round(rows * scale)))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)


def marked(pixels: Image, clicks: Sequence[tuple[str, Click]]) -> Image:
    """A copy with every click drawn and named: a ring inside a thing, a cross outside it."""
    canvas = np.ascontiguousarray(pixels).copy()
    size = max(pixels.shape[:2]) / 800
    radius, thin = max(3, round(5 * size)), max(1, round(1.5 * size))
    for name, click in clicks:
        centre = (round(click.x), round(click.y))
        for colour, width in (((0, 0, 0), thin + 2), ((255, 230, 0), thin)):
            if click.label:
                cv2.circle(canvas, centre, radius, colour, width, cv2.LINE_AA)
            else:
                cv2.drawMarker(canvas, centre, colour, cv2.MARKER_TILTED_CROSS, 2 * radius, width)
        if click.label:
            written(canvas, name, (centre[0] + radius + 2, centre[1] - radius), 0.45 * size)
    return canvas


def outlined(
    pixels: Image,
    masks: Mapping[str, NDArray[np.bool_]],
    colour: tuple[int, int, int] = (255, 230, 0),
) -> Image:
    """A copy with the outline of each mask (H, W) drawn over it, and its name where it begins."""
    canvas = np.ascontiguousarray(pixels).copy()
    size = max(pixels.shape[:2]) / 800
    thin = max(1, round(1.5 * size))
    for mask in masks.values():
        found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        for ink, width in (((0, 0, 0), thin + 2), (colour, thin)):
            cv2.drawContours(canvas, found, -1, ink, width, cv2.LINE_AA)
    for name, mask in masks.items():
        rows, columns = np.nonzero(mask)
        if rows.size:
            top = int(rows.argmin())
            place = (int(columns[top]), int(rows[top]) - round(4 * size))
            written(canvas, name.replace("_", " "), place, 0.5 * size)
    return canvas


def written(canvas: Image, text: str, at: tuple[int, int], scale: float) -> None:
    """White letters on a dark plate, moved inside the picture; `at` is where they begin."""
    scale = max(0.38, scale)
    (width, height), below = cv2.getTextSize(text, _FONT, scale, 1)
    rows, columns = canvas.shape[:2]
    x = max(1, min(at[0], columns - width - 2))
    y = max(height + 2, min(at[1], rows - below - 1))
    cv2.rectangle(canvas, (x - 1, y - height - 1), (x + width + 1, y + below - 1), (20, 20, 20), -1)
    cv2.putText(canvas, text, (x, y), _FONT, scale, (255, 255, 255), 1, cv2.LINE_AA)


def contact_sheet(
    frames: Sequence[Image],
    labels: Sequence[str],
    columns: int = SHEET_COLUMNS,
    width: int = CELL_WIDTH,
) -> Image:
    """All frames in rows of so many, left to right, each under its label."""
    cells = [
        labelled(fitted(frame, width), label) for frame, label in zip(frames, labels, strict=True)
    ]
    high, wide = cells[0].shape[:2]
    lines = math.ceil(len(cells) / columns)
    across = min(columns, len(cells))
    sheet = np.full((lines * (high + 4), across * (wide + 4), 3), 255, np.uint8)
    for index, cell in enumerate(cells):
        top, left = index // across * (high + 4), index % across * (wide + 4)
        sheet[top : top + high, left : left + wide] = cell
    return sheet


def labelled(picture: Image, label: str) -> Image:
    """A picture under its label."""
    bar = np.full((LABEL_ROWS, picture.shape[1], 3), 255, np.uint8)
    cv2.putText(bar, label, (4, LABEL_ROWS - 6), _FONT, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.concatenate([bar, picture], axis=0)
