"""Hostile and broken files of every kind that peers exchange: refused, how soon, with how much."""

import io
import json
import resource
import struct
import subprocess
import sys
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.benchmark.rows import Row, at_least, at_most
from physagent_studio.errors import StudioError
from physagent_studio.exchange import Prior, load_case, load_peer_config, read_lessons
from physagent_studio.exchange.files import bytes_of, text_of
from physagent_studio.exchange.peers.handler import read_handler
from physagent_studio.exchange.peers.mjcf import load_mjcf
from physagent_studio.exchange.peers.reading import load_peer
from physagent_studio.exchange.plain_yaml import read_yaml
from physagent_studio.exchange.prior.export import FORMAT, MARK
from physagent_studio.jobs import Limits, shared
from physagent_studio.jobs.worker import import_all
from physagent_studio.program.text.document import load_program
from physagent_studio.reconstruction import read_photo
from physagent_studio.reconstruction.backends.mesh_files import MESH, textured_from
from physagent_studio.reconstruction.photo.header import Header
from physagent_studio.reconstruction.photo.reading import decoded_within
from physagent_studio.session import Store
from physagent_studio.workbench.mesh_edits import materials_beside
from physagent_studio.workbench.program_texts import read_program

Reader = Callable[[Path], object]
_TASKS = (
    "physagent_studio.exchange.peers.handler",
    "physagent_studio.exchange.peers.mjcf",
    "physagent_studio.reconstruction.backends.mesh_files",
    "physagent_studio.session.archive",
    "mujoco",
)
LONGEST = 300
"""Seconds after which the trial is given up."""
_MANY = 200
"""Megabytes of zeros that an archive holds."""
_CONFIG = b"all_object_points: [[[4, 4, 1]]]\nmaterial_type: [rigid]\n"
_CSV = b"image,angle,force,coordx,coordy,width,height,caption\n"
_SIM = b"gravity: 980\nobj_info: {3: {label: a, friction: .3}}\n"


@dataclass(frozen=True, slots=True)
class Zeros:
    """A gigabyte of zeros after some bytes, written as a hole."""

    head: bytes = b""


def _files() -> Iterator[tuple[str, bytes | Zeros, Reader]]:
    """A name, bytes and the reader that has to refuse them; None of them is read to its end."""

    def handler(path: Path) -> object:
        return read_handler(path, 2, 400, {}, ())

    loops = "".join(f"{' ' * n}for i{n} in range(1000):\n" for n in range(3, 8)) + f"{' ' * 8}x = 1"
    head = b"class A(B):\n def custom_simulation(self, s):\n"
    yield "handler.py", head + loops.encode(), handler
    yield "handler.py", head + b"  x = " + b"(" * 100_000, handler
    yield "handler.py", b"class A(B", handler
    for name, reader in (("handler.py", handler), ("a.xml", load_mjcf), ("a.csv", load_peer)):
        yield name, Zeros(b"image,caption\n" * (name == "a.csv")), reader
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
    yield from _of_our_own()
    yield from _pictures()
    yield from _texts()


def _of_our_own() -> Iterator[tuple[str, bytes | Zeros, Reader]]:
    """The same of programs, cases, pictures, meshes, sessions, rollouts and priors."""

    def mesh(path: Path) -> object:
        data = bytes_of(path, MESH.max_bytes)
        return textured_from(data, path.name, materials_beside(path))

    def program(path: Path) -> object:
        return load_program(text_of(path, 4_000_000))

    def session(path: Path) -> object:
        return Store(path.parent / "home").import_from(path)

    def prior(path: Path) -> object:
        return Prior.open(path.parent).flow(0)

    def rollout(path: Path) -> object:
        return Prior(path.parent, {}).rollout()

    readers: tuple[tuple[str, Reader], ...] = (
        ("p.yaml", program), ("case.yaml", load_case), ("i.png", read_photo),
        ("a.glb", mesh), ("a.obj", mesh), ("a.ply", mesh), ("a.stl", mesh),
        ("s.physagent", session), ("rollout.npz", rollout), ("meta.json", prior),
        ("sim.yaml", load_peer), ("config.yaml", load_peer_config), ("lessons.yaml", read_lessons),
    )  # fmt: skip
    for name, reader in readers:
        yield name, Zeros(), reader
        yield name, b"", reader
    yield "p.yaml", b"scene: {gravity: [0, 0, .nan]}", program
    yield "p.yaml", b"a: &a [*a, *a]", program
    yield "case.yaml", b"image: ../../i.png\nsize: [64, 48]\n", load_case
    yield "a.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", mesh
    yield "a.ply", b"ply\nformat ascii 1.0\nelement vertex 2000000000\nend_header\n", mesh
    yield "a.glb", _glb({"accessors": [{"count": 10**9}]}), mesh
    yield "a.glb", _glb({"buffers": [{"uri": "../../a.bin"}]}), mesh
    yield "a.glb", _glb({"images": [{"bufferView": 9}], "bufferViews": []}), mesh
    yield "a.glb", _glb({}, b"[" * 100_000), mesh
    yield "a.glb", _glb({}, b'{"accessors":[{"count":1' + b"0" * 10_000 + b"}]}"), mesh
    manifest: dict[str, bytes | int] = {
        "manifest.json": b'{"format": 1, "schema": 2}',
        "rows.json": b"{}",
    }
    yield "s.physagent", _zip(manifest | {"../../evil.png": b"x"}), session
    yield "s.physagent", _zip(manifest | {"/etc/evil": b"x"}), session
    yield "s.physagent", _zip(manifest | {"rows.json": _MANY}), session
    yield "s.physagent", _zip(manifest)[:-30], session
    yield "rollout.npz", _zip({"positions.npy": _MANY, "meta.npy": b"x"}), rollout
    made = {"kind": MARK, "made_from": {"format": FORMAT}, "frames": 2, "size": [64, 48]}
    yield "meta.json", json.dumps(made).encode(), prior
    yield "meta.json", json.dumps(made | {"made_from": {"format": 99}}).encode(), prior


def _pictures() -> Iterator[tuple[str, bytes | Zeros, Reader]]:
    """Pictures that promise more than they hold, or hold more than they promise."""

    def decoder(path: Path) -> object:
        # As if the check of the header had been led to another one.
        return decoded_within(path.read_bytes(), Header("JPEG", 480, 480, 3, 8), path.name)

    progressive = [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]
    large, small = _jpeg(32767, 32767), _jpeg(64, 64)
    yield "i.jpg", large, read_photo
    yield "i.jpg", _jpeg(20_000, 20_000), decoder
    yield "i.jpg", _jpeg(30_000, 30_000, progressive), read_photo
    yield "i.jpg", _jpeg(30_000, 30_000, progressive), decoder
    # A marker without a length stands before what a careless reader takes for the header.
    yield "i.jpg", b"\xff\xd8\xff\x01" + large[2:] + small[2:], read_photo
    scans = _jpeg(4000, 4000, progressive)
    last = scans.rindex(b"\xff\xda")
    for many in (600, 60):
        yield "i.jpg", scans[:last] + scans[last:-2] * many + b"\xff\xd9", read_photo
    yield "i.png", _png(20_000, 20_000), read_photo
    yield "i.png", _png(4900, 5000)[:-3000], read_photo


def _jpeg(width: int, height: int, how: list[int] | None = None) -> bytes:
    """Noise of 480 × 480 pixels, its header saying another size."""
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    data = cv2.imencode(".jpg", cv2.resize(noise, (480, 480)), how or [])[1].tobytes()
    at = next(i for i in range(len(data)) if data[i] == 0xFF and data[i + 1] in (0xC0, 0xC2))
    return data[: at + 5] + struct.pack(">HH", height, width) + data[at + 9 :]


def _png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + check

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(bytes(min(width * height * 3, 2**26)), 9)
    parts = (chunk(b"IHDR", head), chunk(b"IDAT", body), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def _texts() -> Iterator[tuple[str, bytes | Zeros, Reader]]:
    """Texts that are nested, repeated or long beyond reason."""

    def yaml(path: Path) -> object:
        return read_yaml(path.read_text(encoding="utf-8"), path.name)

    def program(path: Path) -> object:
        return read_program(path.read_text(encoding="utf-8"))

    aliases = "a0: &a0 [x, x]\n" + "".join(
        f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 30)
    )
    yield "b.yaml", aliases.encode(), yaml
    yield "b.yaml", b"- a\n" * 300_000, yaml
    yield "p.yaml", b"- a\n" * 62_000, program


def _glb(document: dict[str, object], raw: bytes = b"") -> bytes:
    text = raw or json.dumps({"asset": {"version": "2.0"}} | document).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunk)) + chunk


def _zip(files: dict[str, bytes | int]) -> bytes:
    """An archive of bytes, or of so many megabytes of zeros."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            with archive.open(name, "w") as file:
                for part in [data] if isinstance(data, bytes) else [bytes(2**20)] * data:
                    file.write(part)
    return out.getvalue()


def hostile() -> list[Row]:
    """How many are refused, the longest time by the clock, and the most memory one takes.

    In a process of its own, so that the memory is of nothing else.
    """
    command = [sys.executable, "-m", __name__]
    run = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    try:
        count, refused, slowest, memory = json.loads(run.stdout.splitlines()[-1])
    except (ValueError, IndexError):
        return [Row("hostile files", f"not measured: {run.stderr[-300:]}", "", "", False)]
    return [
        at_least(f"hostile files refused, of {count}", refused, count),
        at_most("the longest that one takes", slowest, 1.0, "s"),
        at_most("the most memory that a process takes for one", memory, 300, "MB"),
    ]


def _tried() -> tuple[int, int, float, float]:
    """How many files, how many of them refused, the longest, s, and the most memory, MB."""
    refused, slowest, count, grown = 0, 0.0, 0, 0
    for name, data, reader in _files():
        # As in a studio that has been running: what reads is there before the file is.
        shared().submit(import_all, _TASKS, limits=Limits(60.0, 2**40))
        before, started = _peak(), time.perf_counter()
        refused += refusal(name, data, reader) is not None
        slowest = max(slowest, time.perf_counter() - started)
        grown, count = max(grown, _peak() - before), count + 1
    shared().close()
    child = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return count, refused, slowest, max(child, grown) / 1024


def refusal(name: str, data: bytes | Zeros, reader: Reader) -> str | None:
    """What a reader says of a file; None where it takes it."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for picture in ("input.png", "original.png", "mask.png", "a.png"):
            cv2.imwrite(str(place / picture), np.full((48, 64, 3), 3, np.uint8))
        (place / "a.stl").write_bytes(b"\0" * 80 + b"\xff" * 4)
        _write(place / name, data)
        try:
            reader(place / name)
        except StudioError as error:
            return str(error)
    return None


def _write(path: Path, data: bytes | Zeros) -> None:
    with path.open("wb") as file:
        if isinstance(data, Zeros):
            file.write(data.head)
            file.truncate(len(data.head) + 2**30)
        else:
            file.write(data)


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    print(json.dumps(_tried()))
