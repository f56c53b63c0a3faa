"""What a picture file says of itself, read without decoding a pixel."""

import re
import struct
from dataclasses import dataclass

from physagent_studio.errors import InputError

_PNG = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_JPEG_FRAMES = frozenset({*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC})
_WITHOUT_LENGTH = frozenset({0x01, *range(0xD0, 0xD8)})
"""JPEG markers that stand alone; whoever reads a length behind them looks at another header."""
_SCAN = re.compile(rb"\xff\xda")


@dataclass(frozen=True, slots=True)
class Header:
    """format: PNG, JPEG, WebP or BMP. channels as stored. bits: per channel. frames: ≥ 1."""

    format: str
    width: int
    height: int
    channels: int
    bits: int
    alpha: bool = False
    animated: bool = False


def read_header(data: bytes, name: str) -> Header:
    """The header of a whole file's bytes; `name` is for messages.

    Raises InputError for a format that is not read, a file that is cut off or not a picture.
    """
    if data.startswith(_PNG):
        return _png(data, name)
    if data.startswith(b"\xff\xd8"):
        return _jpeg(data, name)
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _webp(data, name)
    if data.startswith(b"BM") and len(data) > 30:
        width, height, _, bits = struct.unpack("<iiHH", data[18:30])
        return Header("BMP", abs(width), abs(height), max(bits // 8, 1), 8, bits == 32)
    kind = _foreign(data)
    said = f"is a {kind}" if kind else "is no picture"
    raise InputError(f"{name} {said}; give a PNG, JPEG, WebP or BMP picture")


def _foreign(data: bytes) -> str:
    known = {
        b"GIF8": "GIF",
        b"II*\0": "TIFF",
        b"MM\0*": "TIFF",
        b"%PDF": "PDF",
        b"PK\3\4": "zip archive",
        b"<svg": "SVG drawing",
        b"8BPS": "Photoshop file",
    }
    if data[4:8] == b"ftyp":
        return "HEIC, AVIF or video file"
    return next((kind for magic, kind in known.items() if data.startswith(magic)), "")


def _cut_off(name: str, kind: str) -> InputError:
    return InputError(f"{name} is a {kind} file that is cut off or damaged")


def _png(data: bytes, name: str) -> Header:
    """Walks all chunks, so that a truncated file and an animation are seen."""
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise _cut_off(name, "PNG")
    width, height, bits, color = struct.unpack(">IIBB", data[16:26])
    if color not in _CHANNELS:
        raise _cut_off(name, "PNG")
    alpha = color in (4, 6)
    animated = False
    at, ended = 8, False
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        kind = data[at + 4 : at + 8]
        animated |= kind == b"acTL" and int.from_bytes(data[at + 8 : at + 12], "big") > 1
        alpha |= kind == b"tRNS"
        at += 12 + length
        if kind == b"IEND":
            ended = True
            break
    if not ended:
        raise _cut_off(name, "PNG")
    return Header("PNG", width, height, _CHANNELS[color], bits, alpha, animated)


def _jpeg(data: bytes, name: str) -> Header:
    at = 2
    max_scanned_px = 320_000_000  # 1e8..1e9: times scans: each goes over all pixels again
    max_scans = 64  # count, 12..200: encoders write up to twelve
    while at + 9 < len(data):
        if data[at] != 0xFF:
            break
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        if marker in _WITHOUT_LENGTH:
            at += 2
            continue
        length = int.from_bytes(data[at + 2 : at + 4], "big")
        if marker in _JPEG_FRAMES:
            if b"\xff\xd9" not in data[-65536:]:
                raise _cut_off(name, "JPEG")
            bits, height, width, channels = struct.unpack(">BHHB", data[at + 4 : at + 10])
            scans = sum(1 for _ in _SCAN.finditer(data, at + 2 + length))
            # One scan too large is a picture too large, which says so itself.
            if scans > max_scans or (scans > 1 and scans * width * height > max_scanned_px):
                raise InputError(f"{name} is a JPEG picture of {scans} scans; save it again")
            return Header("JPEG", width, height, channels, bits)
        at += 2 + length
    raise _cut_off(name, "JPEG")


def _webp(data: bytes, name: str) -> Header:
    if len(data) < 30 or int.from_bytes(data[4:8], "little") + 8 > len(data) + 1:
        raise _cut_off(name, "WebP")
    kind = data[12:16]
    if kind == b"VP8X":
        flags = data[20]
        width = 1 + int.from_bytes(data[24:27], "little")
        height = 1 + int.from_bytes(data[27:30], "little")
        return Header("WebP", width, height, 4, 8, bool(flags & 16), bool(flags & 2))
    if kind == b"VP8L":
        packed = int.from_bytes(data[21:25], "little")
        size = 1 + (packed & 0x3FFF), 1 + (packed >> 14 & 0x3FFF)
        return Header("WebP", *size, 4, 8, bool(packed >> 28 & 1))
    if kind == b"VP8 ":
        width, height = struct.unpack("<HH", data[26:30])
        return Header("WebP", width & 0x3FFF, height & 0x3FFF, 3, 8)
    raise _cut_off(name, "WebP")
