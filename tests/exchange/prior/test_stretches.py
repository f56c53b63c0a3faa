"""Files that take over what has not changed, read by Python's own zlib and zipfile."""

from __future__ import annotations

import io
import zipfile
import zlib

import cv2
import numpy as np
import pytest

from physagent_studio.exchange.prior.stretches import STRETCH, Stretches

SIZES = ((60, 900), (60, 900), (60, 900), (97, 513), (1, 7), (128, 256))
"""Of pictures one after the other; the last has stretches that are whole."""


@pytest.mark.parametrize("channels", [1, 3])
def test_pictures_come_back_with_their_checksums(channels: int) -> None:
    rng, stretches = np.random.default_rng(0), Stretches()
    picture = np.zeros((0, 0))
    for number, (height, width) in enumerate(SIZES):
        if number != 2:
            picture = rng.integers(0, 9, (height, width, channels), np.uint8)
        picture[:1] = number
        data = stretches.png("a", picture[..., 0] if channels == 1 else picture)
        at = data.index(b"IDAT")
        packed = data[at + 4 : at + 4 + int.from_bytes(data[at - 4 : at], "big")]
        # Raises where the sum at the end is wrong.
        assert len(zlib.decompress(packed)) == height * (1 + width * channels)
        read = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert read is not None
        assert np.array_equal(read.reshape(picture.shape), picture[..., ::-1])
        # What was there before decides how it is made, not what it is.
        assert data == Stretches().png("a", picture[..., 0] if channels == 1 else picture)


def test_arrays_come_back_with_their_checksums() -> None:
    rng, stretches = np.random.default_rng(1), Stretches()
    values = rng.integers(0, 5, 3 * STRETCH + 11).astype(np.float32)
    for changed in (0, 5, STRETCH, len(values) - 1):
        values[changed] = -1
        for kept in (values, values[: STRETCH // 2], values):
            data = stretches.npz("b", {"values": kept})
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                assert archive.testzip() is None
            assert np.array_equal(np.load(io.BytesIO(data))["values"], kept)
            assert data == Stretches().npz("b", {"values": kept})
