"""Pictures for the model: encoded, with rulers, side by side."""

import base64

import cv2
import numpy as np

from physagent_studio.errors import StudioError
from physagent_studio.records import Image
from physagent_studio.rendering.sheets import labelled, written

JPEG_QUALITY = 88


def data_url(pixels: Image) -> str:
    """The picture as a JPEG in a data URL."""
    bgr = cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_RGB2BGR)
    ok, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not ok:
        raise StudioError(f"a picture of shape {pixels.shape} cannot be encoded")
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode()


def with_rulers(pixels: Image, step: int = 100) -> Image:
    """A copy with tick marks and pixel numbers along the top and left edges."""
    canvas = np.ascontiguousarray(pixels).copy()
    rows, columns = canvas.shape[:2]
    size = max(rows, columns) / 800
    length = max(4, round(8 * size))
    for x in range(step, columns, step):
        cv2.line(canvas, (x, 0), (x, length), (255, 230, 0), max(1, round(size)))
        written(canvas, str(x), (x + 2, length + round(6 * size)), 0.38 * size)
    for y in range(step, rows, step):
        cv2.line(canvas, (0, y), (length, y), (255, 230, 0), max(1, round(size)))
        written(canvas, str(y), (length + 2, y + round(4 * size)), 0.38 * size)
    return canvas


def side_by_side(left: Image, right: Image, labels: tuple[str, str]) -> Image:
    """Two pictures of one height beside each other, each under its label."""
    rows = left.shape[0]
    if right.shape[0] != rows:
        width = max(1, round(right.shape[1] * rows / right.shape[0]))
        right = np.asarray(cv2.resize(right, (width, rows), interpolation=cv2.INTER_AREA), np.uint8)
    cells = [labelled(left, labels[0]), labelled(right, labels[1])]
    gap = np.full((cells[0].shape[0], 6, 3), 255, np.uint8)
    return np.concatenate([cells[0], gap, cells[1]], axis=1)
