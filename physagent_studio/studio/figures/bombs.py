"""Files that are made to take the reader's time and memory, and what refusing them costs."""

from __future__ import annotations

import io
import json
import resource
import struct
import sys
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.errors import StudioError
from physagent_studio.exchange.plain_yaml import read_yaml
from physagent_studio.jobs import shared
from physagent_studio.reconstruction.backends.mesh_files import mesh_from
from physagent_studio.reconstruction.photo.header import Header
from physagent_studio.reconstruction.photo.reading import decoded_within, read_photo
from physagent_studio.session import Store, archive
from physagent_studio.studio.commands import read_letter
from physagent_studio.studio.figures.wire import Figure
from physagent_studio.workbench.program_texts import read_program

SLOWEST, LARGEST = 1000.0, 300.0
"""Milliseconds and MB within which a bomb has to be refused."""


def _jpeg(width: int, height: int, how: list[int] | None = None) -> bytes:
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    data = cv2.imencode(".jpg", cv2.resize(noise, (480, 480)), how or [])[1].tobytes()
    return _resized(data, width, height)


def _resized(data: bytes, width: int, height: int) -> bytes:
    """The same picture, its header saying another size."""
    at = next(i for i in range(len(data)) if data[i] == 0xFF and data[i + 1] in (0xC0, 0xC2))
    return data[: at + 5] + struct.pack(">HH", height, width) + data[at + 9 :]


def _scans(many: int) -> bytes:
    """A progressive picture whose last scan comes again and again."""
    data = _jpeg(4000, 4000, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])
    last = data.rindex(b"\xff\xda")
    return data[:last] + data[last:-2] * many + b"\xff\xd9"


def _hidden() -> bytes:
    """A marker without a length stands before what a careless reader takes for the header."""
    real, small = _jpeg(32767, 32767), _jpeg(64, 64)
    return b"\xff\xd8\xff\x01" + real[2:] + small[2:]


def _png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(bytes(min(width * height * 3, 2**26)), 9)
    parts = (chunk(b"IHDR", head), chunk(b"IDAT", body), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def _glb(document: object, raw: bytes | None = None) -> bytes:
    text = json.dumps(document).encode() if raw is None else raw
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


def _archive(names: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as made:
        for name, data in names.items():
            made.writestr(name, data)
    return stream.getvalue()


def _bombs() -> Iterator[tuple[str, bytes | str, Callable[[bytes | str, Path], object]]]:
    """Each bomb with what reads such a file."""

    def photo(data: bytes | str, folder: Path) -> object:
        assert isinstance(data, bytes)
        path = folder / "bomb.jpg"
        path.write_bytes(data)
        return read_photo(path)

    def decoder(data: bytes | str, _: Path) -> object:
        assert isinstance(data, bytes)
        # As if the check of the header had been led to another one.
        return decoded_within(data, Header("JPEG", 480, 480, 3, 8), "bomb.jpg")

    def session(data: bytes | str, folder: Path) -> object:
        assert isinstance(data, bytes)
        path = folder / "bomb.physagent"
        path.write_bytes(data)
        return Store(folder / "store").import_from(path)

    def mesh(data: bytes | str, folder: Path) -> object:
        assert isinstance(data, bytes)
        return mesh_from(data, "bomb.glb")

    progressive = [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]
    yield "JPEG of 32767 × 32767 as it says", _jpeg(32767, 32767), photo
    yield "desynchronised JPEG of 400 million pixels", _jpeg(20_000, 20_000), decoder
    yield "progressive JPEG of 30000 × 30000", _jpeg(30000, 30000, progressive), photo
    yield "progressive JPEG past the header's check", _jpeg(30000, 30000, progressive), decoder
    yield "JPEG with a hidden header", _hidden(), photo
    yield "JPEG of 600 scans", _scans(600), photo
    yield "JPEG of 60 scans", _scans(60), photo
    yield "PNG of 20000 × 20000", _png(20_000, 20_000), photo
    yield "PNG cut short within the bounds", _png(4900, 5000)[:-3000], photo
    yield (
        "zip of a gigabyte",
        _archive({"rows.json": bytes(2**28), "manifest.json": b"{}"}),
        session,
    )
    stored = {"manifest.json": b'{"format": 1, "schema": 2}', "rows.json": b"{}"}
    path = {"../../evil.png": b"x", **stored}
    yield "path traversal", _archive(path, zipfile.ZIP_STORED), session
    yield "GLB that promises a billion", _glb({"accessors": [{"count": 10**9}]}), mesh
    yield "GLB nested 100,000 deep", _glb(None, b"[" * 100_000), mesh
    long = b'{"accessors":[{"count":1' + b"0" * 10_000 + b"}]}"
    yield "GLB with a number of 10,000 digits", _glb(None, long), mesh
    aliases = "a0: &a0 [x, x]\n" + "".join(
        f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 30)
    )
    yield "YAML of aliases", aliases, lambda text, _: read_yaml(str(text), "bomb.yaml")
    yield "YAML of 300,000 values", "- a\n" * 300_000, lambda text, _: read_yaml(str(text), "b")
    yield "program of 100,000 values", "- a\n" * 62_000, lambda text, _: read_program(str(text))
    deep, digits = "[" * 100_000, '{"do": "scrub", "frame": 1' + "0" * 10_000 + "}"
    yield "JSON nested 100,000 deep", deep, lambda text, _: read_letter(str(text))
    yield "JSON number of 10,000 digits", digits, lambda text, _: read_letter(str(text))


def bombs() -> list[Figure]:
    """For each bomb how long refusing it took, and the most memory that any process took for it."""
    shared().warm("trimesh", mesh_from.__module__, archive.__name__).join()
    figures = []
    with tempfile.TemporaryDirectory() as folder:
        for name, data, reads in _bombs():
            began = time.perf_counter()
            try:
                reads(data, Path(folder))
                taken = float("inf")
            except StudioError:
                taken = (time.perf_counter() - began) * 1000
            figures.append(Figure(f"bomb refused: {name}", taken, "ms", SLOWEST))
    shared().close()
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    most /= 2**20 if sys.platform == "darwin" else 2**10
    return [*figures, Figure("memory of what decodes, most for any bomb", most, "MB", LARGEST)]
