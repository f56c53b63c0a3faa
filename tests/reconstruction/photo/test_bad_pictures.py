"""Pictures that bite: each is read or refused in a sentence, in little memory."""

from __future__ import annotations

import struct
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from subprocess import PIPE

import cv2
import numpy as np
import pytest

SCRIPT = """
import os, pathlib, resource, sys, time
from physagent_studio.errors import InputError
from physagent_studio.reconstruction import read_scaled

def read(path):
    start = time.perf_counter()
    try:
        said = "read " + "x".join(map(str, read_scaled(path)[0].shape))
    except InputError as error:
        said = f"refused: {error}"
    seconds = time.perf_counter() - start
    status = pathlib.Path("/proc/self/status")
    if status.exists():
        # ru_maxrss would count what the parent held when it forked.
        rows = dict(line.split(":", 1) for line in status.read_text().splitlines())
        peak = int(rows["VmHWM"].split()[0]) / 2**10
    else:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(seconds, peak, said, flush=True)

for line in sys.stdin:
    if os.fork() == 0:
        read(line.strip())
        os._exit(0)
    _, status = os.wait()
    if status:
        print(0, 0, "died of", status, flush=True)
"""
"""Reads each picture in a process of its own, in which everything is loaded already."""


@dataclass(frozen=True, slots=True)
class Cost:
    """seconds of reading; peak: memory of the whole process, MB; said: what came of it."""

    seconds: float
    peak: float
    said: str


@pytest.fixture(scope="module")
def cost_of() -> Iterator[Callable[[Path], Cost]]:
    """What reading a picture costs, measured in a fresh process."""
    command = [sys.executable, "-c", SCRIPT]
    with subprocess.Popen(command, stdin=PIPE, stdout=PIPE, text=True) as reader:
        assert reader.stdin is not None
        assert reader.stdout is not None
        asked, answers = reader.stdin, reader.stdout

        def cost(path: Path) -> Cost:
            print(path, file=asked, flush=True)
            seconds, peak, said = answers.readline().strip().split(" ", 2)
            return Cost(float(seconds), float(peak), said)

        yield cost
        asked.close()


def _chunk(kind: bytes, data: bytes) -> bytes:
    check = struct.pack(">I", zlib.crc32(kind + data))
    return struct.pack(">I", len(data)) + kind + data + check


def _png(path: Path, side: int, rows: int, *extra: bytes, bits: int = 8, color: int = 2) -> None:
    """A valid PNG header; the pixels are zeros, `rows` of them."""
    head = struct.pack(">IIBBBBB", side, side, bits, color, 0, 0, 0)
    channels = {0: 1, 2: 3, 6: 4}[color]
    packer, data = zlib.compressobj(9), b""
    row = bytes(1 + side * channels * bits // 8)
    for _ in range(rows):
        data += packer.compress(row)
    data += packer.flush()
    body = _chunk(b"IHDR", head) + b"".join(extra) + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def _huge_text(path: Path) -> None:
    text = b"Comment\0\0" + zlib.compress(bytes(200_000_000), 9)
    _png(path, 64, 64, _chunk(b"zTXt", text))


def _huge_profile(path: Path) -> None:
    profile = b"p\0\0" + zlib.compress(bytes(200_000_000), 9)
    _png(path, 64, 64, _chunk(b"iCCP", profile))


def _animated(path: Path) -> None:
    _png(path, 64, 64, _chunk(b"acTL", struct.pack(">II", 5000, 0)))


def _huge_jpeg(path: Path) -> None:
    coded = cv2.imencode(".jpg", np.zeros((64, 64, 3), np.uint8))[1].tobytes()
    at = coded.index(b"\xff\xc0") + 5
    path.write_bytes(coded[:at] + struct.pack(">HH", 65500, 65500) + coded[at + 4 :])


def _large_jpeg(path: Path) -> None:
    grain = np.random.default_rng(0).integers(0, 255, (720, 960, 3), np.uint8)
    coded = cv2.imencode(".jpg", cv2.resize(grain, (8640, 5760)))[1]
    path.write_bytes(coded.tobytes())


def _zip(path: Path) -> None:
    path.write_bytes(b"PK\3\4" + zlib.compress(bytes(300_000_000), 9))


KINDS: dict[str, Callable[[Path], None]] = {
    "30000 x 30000 PNG": lambda path: _png(path, 30000, 1000),
    "65500 x 65500 JPEG": _huge_jpeg,
    "16 bits, 4950 x 4950": lambda path: _png(path, 4950, 10, bits=16, color=6),
    "animated": _animated,
    "text chunk of 200 MB": _huge_text,
    "colour profile of 200 MB": _huge_profile,
    "more rows than it says": lambda path: _png(path, 64, 400_000),
    "archive": _zip,
    "largest that is read": lambda path: _png(path, 4950, 4950),
    "JPEG of a telephone, 50 million pixels": _large_jpeg,
}

MOST_MB = 300
"""Of the whole process."""
READ = {
    "largest that is read": "read 2475x2475x3",
    "JPEG of a telephone, 50 million pixels": "read 2880x4320x3",
}
REFUSED = {
    "30000 x 30000 PNG": "at most 24 million",
    "65500 x 65500 JPEG": "at most 24 million",
    "16 bits, 4950 x 4950": "save it at 8 bits",
    "animated": "animation",
    "archive": "zip archive",
}


@pytest.mark.parametrize("name", KINDS)
def test_little_memory_and_one_sentence(
    name: str, tmp_path: Path, cost_of: Callable[[Path], Cost]
) -> None:
    path = tmp_path / "picture.png"
    KINDS[name](path)
    cost = cost_of(path)
    assert cost.peak < MOST_MB, cost
    assert REFUSED.get(name, "") in cost.said
    assert cost.said.startswith("refused" if name in REFUSED else READ.get(name, "read 64x64x3"))
