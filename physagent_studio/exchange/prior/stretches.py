"""Files of a clip, compressed in stretches: what is as it was in the last file costs nothing.

A still camera shows mostly what it showed before. Each stretch of a file is a deflate block of its
own (RFC 1951, joined by full flushes), so that one whose bytes are those of the last file of its
kind is taken over; the bytes of a file depend on its content alone.
"""

import hashlib
import io
import json
import struct
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.exchange.files import written

STRETCH = 2**15
"""Bytes that are compressed together: the window in which deflate looks for repetitions."""
_LEVEL = 1
"""Level of zlib: level 6 takes three times as long and saves a seventh."""
_END = b"\x03\x00"
"""An empty last block."""
_DATE = (1 << 5) | 1
"""The first day of 1980, so that the same arrays give the same bytes whenever they are written."""
_PNG = b"\x89PNG\r\n\x1a\n"
_COLOURS = {1: 0, 3: 2}
"""PNG's colour types by the number of channels: grey, RGB."""

Bytes = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class Stretches:
    """Remembers the last file of each kind: its stretches, what each became, and its checksum."""

    last: dict[str, tuple[Bytes, list[bytes], list[int]]] = field(default_factory=dict)

    def deflated(
        self,
        kind: str,
        data: Bytes,
        checksum: Callable[[memoryview], int],
        strategy: int = zlib.Z_DEFAULT_STRATEGY,
    ) -> tuple[bytes, list[int]]:
        """Raw deflate of flat bytes, and the checksum of each stretch."""
        before, packed, sums = self.last.get(kind, (data[:0], [], []))
        if len(before) != len(data):
            count = -(-len(data) // STRETCH)
            before, packed, sums = np.zeros_like(data), [b""] * count, [0] * count
            same = np.zeros(count, bool)
        else:
            same = _same(data, before)
        for number, start in enumerate(range(0, len(data), STRETCH)):
            if number < len(same) and same[number]:
                continue
            part = data[start : start + STRETCH]
            before[start : start + STRETCH] = part
            packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, -15, 8, strategy)
            packed[number] = packer.compress(part.data) + packer.flush(zlib.Z_FULL_FLUSH)
            sums[number] = checksum(part.data)
        self.last[kind] = before, packed, sums
        return b"".join([*packed, _END]), sums

    def png(self, kind: str, picture: NDArray[Any]) -> bytes:
        """A PNG of (H, W) or (H, W, 3) RGB, 8 or 16 bit."""
        channels = picture.shape[2] if picture.ndim == 3 else 1
        height, width = picture.shape[:2]
        step = channels * picture.dtype.itemsize
        whole = picture.astype(picture.dtype.newbyteorder(">"), copy=False)
        rows = np.ascontiguousarray(whole).reshape(height, -1).view(np.uint8)
        # Each byte less that of the pixel to the left: PNG's filter "Sub".
        filtered = np.empty((height, 1 + rows.shape[1]), np.uint8)
        filtered[:, 0] = 1
        filtered[:, 1 : 1 + step] = rows[:, :step]
        np.subtract(rows[:, step:], rows[:, :-step], out=filtered[:, 1 + step :])
        # What is left of a photograph repeats nothing but single values.
        way = zlib.Z_RLE if channels == 3 else zlib.Z_DEFAULT_STRATEGY
        packed, sums = self.deflated(kind, filtered.reshape(-1), zlib.adler32, way)
        packed = b"\x78\x01" + packed + _adler(sums, filtered.size).to_bytes(4, "big")
        depth = 8 * picture.dtype.itemsize
        head = struct.pack(">IIBBBBB", width, height, depth, _COLOURS[channels], 0, 0, 0)
        chunks = ((b"IHDR", head), (b"IDAT", packed), (b"IEND", b""))
        return _PNG + b"".join(_chunk(name, data) for name, data in chunks)

    def npz(self, kind: str, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """Arrays as `numpy.load` reads them: a zip archive, APPNOTE.TXT 6.3, sections 4.3.7, 12."""
        body, directory = [], []
        at = 0
        for name, array in arrays.items():
            flat = np.ascontiguousarray(array)
            head = np.frombuffer(_npy_head(flat), np.uint8)
            values = flat.reshape(-1).view(np.uint8)
            # The last block of the head is no end: what follows belongs to the same stream.
            packed, first = self.deflated(f"{kind}/{name}/head", head, zlib.crc32)
            rest, sums = self.deflated(f"{kind}/{name}", values, zlib.crc32)
            packed = packed[: -len(_END)] + rest
            crc, size = _crc(first[0], sums, values), len(head) + len(values)
            path = f"{name}.npy".encode()
            sizes = (20, 0, 8, 0, _DATE, crc, len(packed), size, len(path), 0)
            body += [struct.pack("<IHHHHHIIIHH", 0x04034B50, *sizes), path, packed]
            directory += [
                struct.pack("<IHHHHHHIIIHH", 0x02014B50, 20, *sizes),
                struct.pack("<HHHII", 0, 0, 0, 0, at),
                path,
            ]
            at += 30 + len(path) + len(packed)
        listing = b"".join(directory)
        count = len(arrays)
        end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, count, count, len(listing), at, 0)
        return b"".join([*body, listing, end])


def _same(data: Bytes, before: Bytes) -> NDArray[np.bool_]:
    """Which of the whole stretches of the first are those of the second."""
    count = min(len(data), len(before)) // STRETCH
    one, other = (part[: count * STRETCH].view(np.uint64) for part in (data, before))
    return (one == other).reshape(count, STRETCH // 8).all(1)


def _adler(sums: list[int], size: int) -> int:
    """Adler-32 (RFC 1950) of stretches one after the other, from those of each."""
    low, high = 1, 0
    for number, one in enumerate(sums):
        length = min(STRETCH, size - number * STRETCH)
        high = (high + (one >> 16) + length * (low - 1)) % 65521
        low = (low + (one & 0xFFFF) - 1) % 65521
    return high << 16 | low


def _crc(crc: int, sums: list[int], data: Bytes) -> int:
    """CRC-32 of what has this one and then stretches, from those of each.

    It is linear over the bits: that of zeros behind it tells what a stretch makes of it.
    """
    a, b, c, d = _behind_it()
    whole = len(data) // STRETCH
    for one in sums[:whole]:
        crc = a[crc & 255] ^ b[crc >> 8 & 255] ^ c[crc >> 16 & 255] ^ d[crc >> 24] ^ one
    return zlib.crc32(data[whole * STRETCH :].data, crc)


@lru_cache(maxsize=1)
def _behind_it() -> tuple[list[int], ...]:
    """What each byte of a CRC-32 becomes by a stretch behind it, from the lowest on."""
    zeros = bytes(STRETCH)
    none = zlib.crc32(zeros)
    return tuple(
        [zlib.crc32(zeros, byte << 8 * place) ^ none for byte in range(256)] for place in range(4)
    )


def _chunk(name: bytes, data: bytes) -> bytes:
    crc = zlib.crc32(data, zlib.crc32(name))
    return len(data).to_bytes(4, "big") + name + data + crc.to_bytes(4, "big")


def _npy_head(array: NDArray[Any]) -> bytes:
    """What NumPy writes before the values (NEP 1), of the same length whatever the shape."""
    shape = f"({', '.join(map(str, array.shape))}{',' if array.ndim == 1 else ''})"
    text = f"{{'descr': '{array.dtype.str}', 'fortran_order': False, 'shape': {shape}, }}"
    length = -(-(len(text) + 11) // 64) * 64 - 10
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", length) + f"{text:<{length - 1}}\n".encode()


@dataclass(frozen=True, eq=False, slots=True)
class Sink:
    """A folder that is written into. hashes: SHA-256 by path within it."""

    folder: Path
    hashes: dict[str, str] = field(default_factory=dict)
    stretches: Stretches = field(default_factory=Stretches)

    def data(self, name: str, data: bytes) -> None:
        """Writes bytes. Raises InputError where the place cannot be written."""
        with written(self.folder / name) as partial:
            partial.write_bytes(data)
        self.hashes[name] = hashlib.sha256(data).hexdigest()

    def text(self, name: str, text: str) -> None:
        """Writes UTF-8."""
        self.data(name, text.encode("utf-8"))

    def json(self, name: str, value: Any) -> None:
        """Writes JSON that a person can read."""
        self.text(name, json.dumps(value, indent=2) + "\n")

    def png(self, name: str, picture: NDArray[Any]) -> None:
        """Writes a PNG of (H, W) or of (H, W, 3) RGB, 8 or 16 bit, as it is."""
        self.data(name, self.stretches.png(_kind(name), picture))

    def npz(self, name: str, **arrays: NDArray[Any]) -> None:
        """Writes arrays as `numpy.load` reads them."""
        self.data(name, self.stretches.npz(_kind(name), arrays))

    def npy(self, name: str, array: NDArray[Any]) -> None:
        """Writes one array, not compressed, as generators map it into memory."""
        out = io.BytesIO()
        np.lib.format.write_array(out, np.ascontiguousarray(array))
        self.data(name, out.getvalue())

    def adopt(self, name: str) -> None:
        """Takes down the hash of a file that another writer has made there."""
        with open(self.folder / name, "rb") as file:
            self.hashes[name] = hashlib.file_digest(file, "sha256").hexdigest()


def _kind(name: str) -> str:
    """What files of a clip have in common: folder, ending, and name but for digits."""
    return name.rstrip("0123456789.npgz") + name[-3:]
