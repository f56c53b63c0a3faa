"""Pictures for the model: fitted, encoded, marked with clicks, laid out as a labelled sheet."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence

import cv2
import numpy as np

from physagent_studio.errors import StudioError
from physagent_studio.program import Click
from physagent_studio.records import Image

JPEG_QUALITY = 88
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


def data_url(pixels: Image) -> str:
    """The picture as a JPEG in a data URL."""
    bgr = cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_RGB2BGR)
    ok, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not ok:
        raise StudioError(f"a picture of shape {pixels.shape} cannot be encoded")
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode()


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
            _write(canvas, name, (centre[0] + radius + 2, centre[1] - radius), 0.45 * size)
    return canvas


def with_rulers(pixels: Image, step: int = 100) -> Image:
    """A copy with tick marks and pixel numbers along the top and left edges."""
    canvas = np.ascontiguousarray(pixels).copy()
    rows, columns = canvas.shape[:2]
    size = max(rows, columns) / 800
    length = max(4, round(8 * size))
    for x in range(step, columns, step):
        cv2.line(canvas, (x, 0), (x, length), (255, 230, 0), max(1, round(size)))
        _write(canvas, str(x), (x + 2, length + round(6 * size)), 0.38 * size)
    for y in range(step, rows, step):
        cv2.line(canvas, (0, y), (length, y), (255, 230, 0), max(1, round(size)))
        _write(canvas, str(y), (length + 2, y + round(4 * size)), 0.38 * size)
    return canvas


def _write(canvas: Image, text: str, at: tuple[int, int], scale: float) -> None:
    """White letters on a dark plate, moved inside the picture; `at` is where they begin."""
    scale = max(0.38, scale)
    (width, height), below = cv2.getTextSize(text, _FONT, scale, 1)
    rows, columns = canvas.shape[:2]
    x = max(1, min(at[0], columns - width - 2))
    y = max(height + 2, min(at[1], rows - below - 1))
    cv2.rectangle(canvas, (x - 1, y - height - 1), (x + width + 1, y + below - 1), (20, 20, 20), -1)
    cv2.putText(canvas, text, (x, y), _FONT, scale, (255, 255, 255), 1, cv2.LINE_AA)


def side_by_side(left: Image, right: Image, labels: tuple[str, str]) -> Image:
    """Two pictures of one height beside each other, each under its label."""
    rows = left.shape[0]
    if right.shape[0] != rows:
        width = max(1, round(right.shape[1] * rows / right.shape[0]))
        right = np.asarray(cv2.resize(right, (width, rows), interpolation=cv2.INTER_AREA), np.uint8)
    cells = [_labelled(left, labels[0]), _labelled(right, labels[1])]
    gap = np.full((cells[0].shape[0], 6, 3), 255, np.uint8)
    return np.concatenate([cells[0], gap, cells[1]], axis=1)


def contact_sheet(
    frames: Sequence[Image],
    labels: Sequence[str],
    columns: int = SHEET_COLUMNS,
    width: int = CELL_WIDTH,
) -> Image:
    """All frames in rows of so many, left to right, each under its label."""
    cells = [
        _labelled(fitted(frame, width), label) for frame, label in zip(frames, labels, strict=True)
    ]
    high, wide = cells[0].shape[:2]
    lines = math.ceil(len(cells) / columns)
    across = min(columns, len(cells))
    sheet = np.full((lines * (high + 4), across * (wide + 4), 3), 255, np.uint8)
    for index, cell in enumerate(cells):
        top, left = index // across * (high + 4), index % across * (wide + 4)
        sheet[top : top + high, left : left + wide] = cell
    return sheet


def _labelled(picture: Image, label: str) -> Image:
    bar = np.full((LABEL_ROWS, picture.shape[1], 3), 255, np.uint8)
    cv2.putText(bar, label, (4, LABEL_ROWS - 6), _FONT, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.concatenate([bar, picture], axis=0)
