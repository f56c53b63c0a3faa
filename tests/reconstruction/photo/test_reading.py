"""Pictures that bite are refused by their header; unusual ones are read."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import case_from_image
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.photo.reading import (
    PHOTO,
    photo_hash,
    read_photo,
    read_scaled,
    reduction_of,
)


def _png(path: Path, width: int, height: int, *, bits: int = 8, color: int = 2, extra: bytes = b""):
    """A PNG whose header promises what its data does not hold."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    head = struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0)
    body = chunk(b"IDAT", zlib.compress(b"\0" * 1000))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra + body + chunk(b"IEND", b"")
    )
    return path


def _picture(shape=(40, 60, 3), dtype: type = np.uint8):
    rng = np.random.default_rng(1)
    return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


def test_a_plain_picture_keeps_its_pixels(tmp_path):
    pixels = _picture()
    cv2.imwrite(str(tmp_path / "a.png"), pixels[..., ::-1])
    found, digest = read_photo(tmp_path / "a.png")
    assert np.array_equal(found, pixels)
    assert len(digest) == 64
    assert read_photo(tmp_path / "a.png")[1] == digest


def test_sixteen_bits_become_eight(tmp_path):
    pixels = _picture(dtype=np.uint16)
    cv2.imwrite(str(tmp_path / "a.png"), pixels[..., ::-1])
    found, _ = read_photo(tmp_path / "a.png")
    assert found.dtype == np.uint8
    assert np.abs(found.astype(int) - pixels // 257).max() <= 1


def test_transparency_is_laid_on_white(tmp_path):
    pixels = np.zeros((40, 60, 4), np.uint8)
    pixels[:, :30] = (10, 20, 30, 255)
    cv2.imwrite(str(tmp_path / "a.png"), pixels)
    found, _ = read_photo(tmp_path / "a.png")
    assert tuple(found[0, 0]) == (30, 20, 10)
    assert tuple(found[0, 59]) == (255, 255, 255)


def test_a_grey_picture_becomes_rgb(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), _picture((40, 60)))
    assert read_photo(tmp_path / "a.png")[0].shape == (40, 60, 3)


def test_a_turned_photo_is_upright(tmp_path):
    pixels = np.zeros((40, 80, 3), np.uint8)
    pixels[:, :20] = 255
    jpeg = cv2.imencode(".jpg", pixels)[1].tobytes()
    # Orientation 6: the camera was turned by 90° clockwise.
    tiff = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"
    exif = b"Exif\0\0" + tiff
    segment = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    (tmp_path / "a.jpg").write_bytes(jpeg[:2] + segment + jpeg[2:])
    found, _ = read_photo(tmp_path / "a.jpg")
    assert found.shape == (80, 40, 3)
    assert found[:15].mean() > 230
    assert found[30:].mean() < 25


def test_a_webp_is_read(tmp_path):
    cv2.imwrite(str(tmp_path / "a.webp"), _picture())
    assert read_photo(tmp_path / "a.webp")[0].shape == (40, 60, 3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: _png(p, 30000, 30000), "at most 24 million"),
        (lambda p: _png(p, 4950, 4950, bits=16, color=6), "too large at 16 bits"),
        (
            lambda p: _png(p, 64, 64, extra=b"\0\0\0\x08acTL\0\0\0\2" + b"\0" * 8),
            "animation",
        ),
        (lambda p: _png(p, 0, 10), "0 × 10"),
        (lambda p: p.write_bytes(b"GIF89a" + b"\0" * 60), "is a GIF"),
        (lambda p: p.write_bytes(b"PK\3\4" + b"\0" * 60), "zip archive"),
        (lambda p: p.write_bytes(b"hello, this is text"), "no picture"),
        (lambda p: p.write_bytes(b""), "no picture"),
        (lambda p: p.write_bytes(b"\x89PNG\r\n\x1a\n"), "cut off"),
        (lambda p: p.write_bytes(b"\xff\xd8\xff\xe0\0\x10"), "cut off"),
    ],
)
def test_refused_in_one_sentence(tmp_path, make, words):
    path = tmp_path / "picture"
    make(path)
    with pytest.raises(InputError, match=words) as caught:
        read_photo(path)
    assert "\n" not in str(caught.value)


def test_a_cut_off_jpeg_is_refused(tmp_path):
    data = cv2.imencode(".jpg", _picture((200, 200, 3)))[1].tobytes()
    (tmp_path / "a.jpg").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match="cut off"):
        read_photo(tmp_path / "a.jpg")


def test_cmyk_is_refused(tmp_path):
    data = bytearray(cv2.imencode(".jpg", _picture())[1].tobytes())
    at = data.index(b"\xff\xc0")
    data[at + 9] = 4
    (tmp_path / "a.jpg").write_bytes(bytes(data))
    with pytest.raises(InputError, match="CMYK"):
        read_photo(tmp_path / "a.jpg")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="there is no picture at"):
        read_photo(tmp_path / "nothing.png")


def test_a_jpeg_that_is_too_large_is_read_at_half_its_size(tmp_path):
    wide = np.zeros((4400, 6000, 3), np.uint8)
    wide[:, 3000:] = 200
    assert wide.shape[0] * wide.shape[1] > PHOTO.max_px
    cv2.imwrite(str(tmp_path / "a.jpg"), wide)
    found, digest, factor = read_scaled(tmp_path / "a.jpg")
    assert found.shape == (2200, 3000, 3)
    assert factor == 2
    assert found[1000, 1400].max() < 10
    assert found[1000, 1600].min() > 190
    assert digest == photo_hash(found)
    with pytest.raises(InputError, match="at most 24 million"):
        read_photo(tmp_path / "a.jpg")
    case = case_from_image(
        tmp_path / "a.jpg", "It moves.", {"bar": Grounding(points=(Click(x=4000, y=800),))}
    )
    (click,) = case.objects[0][1].points
    assert (click.x, click.y) == (2000, 400)


@pytest.mark.parametrize(("name", "sides"), [("a.png", (3001, 4501)), ("a.jpg", (3001, 4501))])
def test_a_large_picture_is_read_at_half_its_size_whatever_its_format(tmp_path, name, sides):
    assert PHOTO.kept_px < sides[0] * sides[1] < PHOTO.max_px
    wide = np.zeros((*sides, 3), np.uint8)
    wide[:, 3000:] = 200
    cv2.imwrite(str(tmp_path / name), wide)
    found, digest, factor = read_scaled(tmp_path / name)
    assert (found.shape, factor) == ((1501, 2251, 3), 2)
    assert (reduction_of(tmp_path / name), digest) == (2, photo_hash(found))
    assert found[1000, 1400].max() < 10
    assert found[1000, 1600].min() > 190
    assert not found.flags.writeable
    # Asked for as it is, it is.
    assert read_photo(tmp_path / name)[0].shape == wide.shape


def test_a_picture_of_usual_size_is_read_as_it_is(tmp_path):
    pixels = _picture()
    cv2.imwrite(str(tmp_path / "a.png"), pixels[..., ::-1])
    found, digest, factor = read_scaled(tmp_path / "a.png")
    assert (digest, factor) == (read_photo(tmp_path / "a.png")[1], 1)
    assert np.array_equal(found, pixels)
