"""The focal length that a picture file states of itself, in pixels of the picture.

Exif 2.3 (CIPA DC-008): the 35 mm equivalent if it is given, else the lens's focal length with the
pitch of the sensor's pixels. A picture that was cut since says something of another picture.
"""

import math
import struct
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path


class _Tag(IntEnum):
    """Numbers that Exif gives to what is read here."""

    IN_35MM = 0xA405
    FOCAL = 0x920A
    EXIF = 0x8769
    PITCH = 0xA20E
    PITCH_UNIT = 0xA210
    WIDTH = 0xA002
    HEIGHT = 0xA003


@dataclass(frozen=True, slots=True)
class FocalSettings:
    """When a stated focal length is believed."""

    film_diagonal_mm: float = math.hypot(36.0, 24.0)  # 43..44: of the film of 35 mm equivalents
    max_shape_ratio: float = 0.02  # 0..0.1: by how much a picture that was not cut may differ
    plausible_ratios: tuple[float, float] = (0.3, 30.0)  # 0.1..50: over the longer side; else noise
    read_bytes: int = 1 << 20  # 65536..1e7: of the file: what it says of itself comes first


FOCAL = FocalSettings()

_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 9: 4, 10: 8}
_UNITS = {2: 25.4, 3: 10.0, 4: 1.0}
"""Millimetres of the unit of a sensor's resolution."""


def stated_focal(path: Path | str, size: tuple[int, int]) -> float | None:
    """The focal length in pixels that a JPEG, PNG or WebP file states; None where it does not.

    size: (width, height) of the picture as it is used, after any turn.
    """
    try:
        with Path(path).open("rb") as stream:
            data = stream.read(FOCAL.read_bytes)
    except OSError:
        return None
    block = _block(data)
    if block is None:
        return None
    try:
        tags = _tags(block)
    except (struct.error, IndexError):
        return None
    focal = _focal(tags, size)
    low, high = (share * max(size) for share in FOCAL.plausible_ratios)
    return focal if focal is not None and low < focal < high else None


def _focal(tags: dict[int, float], size: tuple[int, int]) -> float | None:
    stored = (tags.get(_Tag.WIDTH, 0.0), tags.get(_Tag.HEIGHT, 0.0))
    if min(stored) > 0:
        now, then = max(size) / min(size), max(stored) / min(stored)
        if abs(now / then - 1) > FOCAL.max_shape_ratio:
            return None
    if tags.get(_Tag.IN_35MM, 0) > 0:
        return tags[_Tag.IN_35MM] / FOCAL.film_diagonal_mm * math.hypot(*size)
    unit = _UNITS.get(int(tags.get(_Tag.PITCH_UNIT, 2)))
    if tags.get(_Tag.FOCAL, 0) > 0 and tags.get(_Tag.PITCH, 0) > 0 and unit and max(stored) > 0:
        return tags[_Tag.FOCAL] * tags[_Tag.PITCH] / unit * max(size) / max(stored)
    return None


def _block(data: bytes) -> bytes | None:
    """The TIFF structure in a picture file, from its byte order mark."""
    if data.startswith(b"\xff\xd8"):
        at = 2
        while at + 4 < len(data) and data[at] == 0xFF:
            length = int.from_bytes(data[at + 2 : at + 4], "big")
            if data[at + 1] == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0":
                return data[at + 10 : at + 2 + length]
            if data[at + 1] == 0xDA:
                return None
            at += 2 + length
        return None
    if data.startswith(b"\x89PNG"):
        return _png_chunk(data)
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _webp_chunk(data)
    return None


def _png_chunk(data: bytes) -> bytes | None:
    at = 8
    while at + 8 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        if data[at + 4 : at + 8] == b"eXIf":
            return data[at + 8 : at + 8 + length]
        at += 12 + length
    return None


def _webp_chunk(data: bytes) -> bytes | None:
    at = 12
    while at + 8 <= len(data):
        length = int.from_bytes(data[at + 4 : at + 8], "little")
        if data[at : at + 4] == b"EXIF":
            block = data[at + 8 : at + 8 + length]
            return block[6:] if block.startswith(b"Exif\0\0") else block
        at += 8 + length + (length & 1)
    return None


def _tags(block: bytes) -> dict[int, float]:
    """Numeric tags of the first directory and of the Exif directory that it points to."""
    order = {b"II": "<", b"MM": ">"}.get(block[:2])
    if order is None:
        return {}
    (first,) = struct.unpack_from(order + "I", block, 4)
    tags = _directory(block, first, order)
    if _Tag.EXIF in tags:
        tags |= _directory(block, int(tags[_Tag.EXIF]), order)
    return tags


def _directory(block: bytes, at: int, order: str) -> dict[int, float]:
    (count,) = struct.unpack_from(order + "H", block, at)
    out: dict[int, float] = {}
    for k in range(min(count, 500)):
        tag, kind, number = struct.unpack_from(order + "HHI", block, at + 2 + 12 * k)
        if kind not in _BYTES or number != 1:
            continue
        place = at + 2 + 12 * k + 8
        if _BYTES[kind] > 4:
            (place,) = struct.unpack_from(order + "I", block, place)
        out[tag] = _value(block, place, kind, order)
    return out


def _value(block: bytes, at: int, kind: int, order: str) -> float:
    if kind in (5, 10):
        over, under = struct.unpack_from(order + ("II" if kind == 5 else "ii"), block, at)
        return over / under if under else 0.0
    form = {1: "B", 2: "B", 7: "B", 3: "H", 4: "I", 9: "i"}[kind]
    return float(struct.unpack_from(order + form, block, at)[0])
