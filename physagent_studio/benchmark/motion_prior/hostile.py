"""Hostile and broken files of every kind that peers exchange: refused, how soon, with how much."""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.benchmark.rows import Row, at_least, at_most
from physagent_studio.errors import StudioError
from physagent_studio.exchange.peers.handler import read_handler
from physagent_studio.exchange.peers.mjcf import load_mjcf
from physagent_studio.exchange.peers.reading import load_peer
from physagent_studio.jobs import Limits, shared
from physagent_studio.jobs.worker import import_all

Reader = Callable[[Path], object]
_TASKS = (
    "physagent_studio.exchange.peers.handler",
    "physagent_studio.exchange.peers.mjcf",
    "mujoco",
)
_ZEROS = b"\0" * 2**20
_CONFIG = b"all_object_points: [[[4, 4, 1]]]\nmaterial_type: [rigid]\n"
_CSV = b"image,angle,force,coordx,coordy,width,height,caption\n"
_SIM = b"gravity: 980\nobj_info: {3: {label: a, friction: .3}}\n"


def _files() -> Iterator[tuple[str, bytes, Reader]]:
    """A name, bytes and the reader that has to refuse them; None of them is read to its end."""

    def handler(path: Path) -> object:
        return read_handler(path, 2, 400, {}, ())

    loops = "".join(f"{' ' * n}for i{n} in range(1000):\n" for n in range(3, 8)) + f"{' ' * 8}x = 1"
    head = b"class A(B):\n def custom_simulation(self, s):\n"
    yield "handler.py", head + loops.encode(), handler
    yield "handler.py", head + b"  x = " + b"(" * 100_000, handler
    yield "handler.py", b"class A(B", handler
    for name, reader in (("handler.py", handler), ("a.xml", load_mjcf), ("a.csv", load_peer)):
        yield name, b"image,caption\n" * (name == "a.csv") + _ZEROS * 1024, reader
    many = "<replicate count='100000000'><geom size='1'/></replicate>"
    mesh = "<asset><mesh name='m' file='{}'/></asset>"
    inner = (
        "<include file='a.xml'/>", mesh.format("../../a.stl"), mesh.format("/etc/passwd.stl"),
        f"<worldbody>{many}</worldbody>", "<worldbody><geom size='nan'/></worldbody>",
        "<size memory='900G'/><worldbody>", "<size memory='900G'/>" + mesh.format("a.stl"),
    )  # fmt: skip
    for text in inner:
        yield "a.xml", f"<mujoco>{text}</mujoco>".encode(), load_mjcf
    yield "a.xml", b"<!DOCTYPE a [<!ENTITY b 'c'>]><mujoco/>", load_mjcf
    for row in (
        b"../a.png,0,1,4,4,64,48,a",
        b"a.png,nan,1,4,4,64,48,a",
        b"a.png,0,1,4e9,4,64,48,a",
    ):
        yield "a.csv", _CSV + row, load_peer
    yield "sim.yaml", _SIM.replace(b"980", b".nan"), load_peer
    yield "sim.yaml", _SIM.replace(b"{3:", b"{9:"), load_peer
    yield "config.yaml", _CONFIG + b"dt: .nan\n", load_peer
    yield "config.yaml", _CONFIG + b"dt: &a [*a]\n", load_peer
    yield "config.yaml", _CONFIG + b"gravity_direction: [0, 0]\n", load_peer


def hostile() -> list[Row]:
    """How many are refused, the longest time by the clock and the most memory of a decoder."""
    refused, slowest, count = 0, 0.0, 0
    for name, data, reader in _files():
        count += 1
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            for picture in ("input.png", "original.png", "mask.png", "a.png"):
                cv2.imwrite(str(place / picture), np.full((48, 64, 3), 3, np.uint8))
            (place / "a.stl").write_bytes(b"\0" * 80 + b"\xff" * 4)
            (place / name).write_bytes(data)
            # As in a studio that has been running: what reads is there before the file is.
            shared().submit(import_all, _TASKS, limits=Limits(60.0, 2**40))
            started = time.perf_counter()
            try:
                reader(place / name)
            except StudioError:
                refused += 1
            slowest = max(slowest, time.perf_counter() - started)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    return [
        at_least(f"hostile files refused, of {count}", refused, count),
        at_most("the longest that one takes", slowest, 1.0, "s"),
        at_most("the most memory of a process that reads one", memory, 300, "MB"),
    ]
