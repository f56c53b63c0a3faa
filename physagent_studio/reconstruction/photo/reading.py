"""Photos read safely: bounded by their header before a pixel is decoded."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, within
from physagent_studio.jobs.decoders import REDUCED, decoded
from physagent_studio.reconstruction.photo.header import Header, read_header
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class PhotoSettings:
    """What a picture file may ask for."""

    max_bytes: int = 64 * 1024 * 1024  # 1e6..1e9: cameras write smaller files
    max_px: int = 24_600_000  # 1e6..1e8: 6048 × 4032 is read in a second and in 300 MB
    # 1e7..1e9: of a JPEG picture, which is decoded at a half or a quarter of its size
    max_reduced_px: int = 100_000_000
    kept_px: int = 12_600_000  # 2e6..2e7: larger ones take minutes and gigabytes, and show no more
    max_decoded_bytes: int = 160 * 1024 * 1024  # 1e7..1e9: that the pixels may take
    min_side_px: int = 16  # 4..64: smaller pictures show nothing to reconstruct
    base_s: float = 0.3  # 0.1..5: processor time to decode any picture
    time_per_pixel_s: float = 6e-8  # 1e-8..1e-6: three times the need of the dearest format
    base_bytes: int = 48 * 2**20  # 1e7..1e9: memory to decode any picture
    pixel_bytes: int = 10  # 3..40: a progressive picture keeps coefficients
    max_work_bytes: int = 640 * 2**20  # 1e8..4e9: to decode, however large it says it is


PHOTO = PhotoSettings()


def read_photo(path: Path | str) -> tuple[Image, str]:
    """The picture as (H, W, 3) uint8 RGB, and the SHA-256 of its decoded pixels.

    Turned as its EXIF says, 16 bits brought to 8, transparency laid on white.
    Raises InputError, in one sentence, for what is missing, too large, animated, CMYK, damaged or
    no picture.
    """
    path = Path(path)
    data = _bytes(path)
    header = read_header(data, path.name)
    _check(header, path.name)
    pixels = _whole(decoded_within(data, header, path.name), header, path.name)
    return pixels, photo_hash(pixels)


def read_scaled(path: Path | str) -> tuple[Image, str, int]:
    """As `read_photo`, but a picture of more than `kept_px` is read smaller.

    The third is how many pixels of the file make one that is read: 1, 2 or, of a JPEG picture, 4.
    """
    path = Path(path)
    data = _bytes(path)
    header = read_header(data, path.name)
    factor = _factor(header)
    if factor == 1:
        return (*read_photo(path), 1)
    if header.format != "JPEG":
        pixels = _shrunk(read_photo(path)[0], factor)
        return pixels, photo_hash(pixels), factor
    small = replace(header, width=header.width // factor, height=header.height // factor)
    _check(small, path.name)
    pixels = _whole(decoded_within(data, header, path.name, factor), header, path.name, factor)
    return pixels, photo_hash(pixels), factor


def reduction_of(path: Path | str) -> int:
    """How many pixels of a picture's file make one that `read_scaled` reads, along each side."""
    path = Path(path)
    return _factor(read_header(_bytes(path), path.name))


def _factor(header: Header) -> int:
    many = header.width * header.height
    if many > (PHOTO.max_reduced_px if header.format == "JPEG" else PHOTO.max_px):
        return 1
    return next((k for k in REDUCED if many <= PHOTO.kept_px * k * k), 1)


def _shrunk(pixels: Image, factor: int) -> Image:
    """A picture at a part of its size, as large as a JPEG picture is decoded at it."""
    height, width = (-(-side // factor) for side in pixels.shape[:2])
    small = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8)
    small.setflags(write=False)
    return small


def _whole(pixels: Image | None, header: Header, name: str, factor: int = 1) -> Image:
    """Decoded pixels, made sure of and not to be written to."""
    if pixels is None or pixels.ndim != 3:
        raise InputError(f"{name} is a {header.format} file that is cut off or damaged")
    sides = sorted((-(-header.width // factor), -(-header.height // factor)))
    if sorted(pixels.shape[:2]) != sides:
        raise InputError(f"{name} is not of the size that its header says; save it again")
    if min(pixels.shape[:2]) < PHOTO.min_side_px:
        size = f"{header.width} × {header.height} pixels"
        raise InputError(f"{name} is {size}; each side needs {PHOTO.min_side_px} at least")
    pixels = np.ascontiguousarray(pixels)
    pixels.setflags(write=False)
    return pixels


def photo_hash(pixels: Image) -> str:
    """SHA-256 of a picture's size and pixels."""
    digest = hashlib.sha256(f"{pixels.shape[1]}x{pixels.shape[0]}\n".encode())
    digest.update(np.ascontiguousarray(pixels).data)
    return digest.hexdigest()


def _bytes(path: Path) -> bytes:
    try:
        if not path.is_file():
            raise InputError(f"there is no picture at {path}")
        size = path.stat().st_size
        if size > PHOTO.max_bytes:
            raise InputError(
                f"{path.name} has {size / 2**20:.0f} MB;"
                f" at most {PHOTO.max_bytes // 2**20} MB are read"
            )
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error


def _check(header: Header, name: str) -> None:
    width, height = header.width, header.height
    if width < 1 or height < 1:
        raise InputError(f"{name} says it is {width} × {height} pixels")
    if width * height > PHOTO.max_px:
        raise InputError(
            f"{name} is {width} × {height} pixels;"
            f" at most {PHOTO.max_px // 10**6} million are read, save it smaller"
        )
    if header.animated:
        raise InputError(f"{name} is an animation; give a single picture")
    if header.format == "JPEG" and header.channels == 4:
        raise InputError(f"{name} is a CMYK picture; save it as RGB")
    depth = 2 if header.bits > 8 else 1
    channels = 4 if header.alpha else 3
    if width * height * channels * depth > PHOTO.max_decoded_bytes:
        raise InputError(f"{name} is too large at {header.bits} bits a channel; save it at 8 bits")


def decoded_within(data: bytes, header: Header, name: str, factor: int = 1) -> Image | None:
    """The pixels, decoded in a process that may use as much as a picture of that header needs."""
    many, depth = header.width * header.height, 2 if header.bits > 8 else 1
    limits = Limits(
        PHOTO.base_s + PHOTO.time_per_pixel_s * many,
        PHOTO.base_bytes
        + min(PHOTO.max_work_bytes, len(data) + many * (PHOTO.pixel_bytes + 8 * (depth - 1))),
    )
    return within(limits, f"{name} cannot be read", decoded, data, header.alpha, factor)
