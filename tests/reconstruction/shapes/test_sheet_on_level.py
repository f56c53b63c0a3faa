"""What is drawn of a thing that lies stays between the levels between which it lies."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.shapes.inflation import sheet_on_level
from physagent_studio.reconstruction.shapes.silhouettes import silhouette

CAMERA = Camera.from_horizon((320, 240), -90.0, 0.6, focal=300.0)


@pytest.mark.parametrize("high", [0.002, 0.006])
def test_a_ring_with_a_handle_lies_flat_and_covers_its_mask(high: float) -> None:
    mask = np.zeros((240, 320), np.uint8)
    cv2.circle(mask, (110, 130), 34, 1, 9)
    cv2.line(mask, (142, 130), (260, 150), 1, 11)
    vertices, faces = sheet_on_level(mask.astype(bool), CAMERA, 0.0, high)
    assert vertices[:, 2].min() >= -1e-9
    assert vertices[:, 2].max() <= high + 1e-9
    drawn = silhouette(CAMERA, vertices, faces.astype(np.int32))
    assert iou(drawn, mask.astype(bool)) > 0.9
