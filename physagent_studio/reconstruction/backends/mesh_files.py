"""Mesh files read safely: bounded before they are parsed."""

import io
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.resolvers import ZipResolver

from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, within
from physagent_studio.reconstruction.backends.mesh_skins import (
    check_pictures,
    glb_document,
    sewn,
    skin_of,
)
from physagent_studio.reconstruction.shapes.meshes import one_surface, volume_and_centre
from physagent_studio.records.scene import Mesh

KINDS = (".glb", ".obj", ".ply", ".stl")


@dataclass(frozen=True, slots=True)
class MeshSettings:
    """What a mesh file may ask for."""

    max_bytes: int = 64 * 1024 * 1024  # 1e6..1e9: people's meshes are smaller
    max_elements: int = 2_000_000  # count, 1e5..1e7: vertices or indices that a file may promise
    base_s: float = 0.7  # 0.1..5: processor time to parse any mesh
    time_per_byte_s: float = 2e-7  # 1e-8..1e-5: 10 MB of text has 3 s, five times its need
    base_bytes: int = 128 * 2**20  # 1e7..1e9: memory to parse any mesh
    memory_per_byte: int = 24  # bytes, 4..100: for each of the file's: numbers in text grow
    max_coordinate: float = 1e6  # the file's unit, 1e3..1e9: farther from the origin is a mistake
    max_faces: int = 20_000  # count, 1000..200000: finer meshes are clustered, to collide in time


MESH = MeshSettings()

UNREADABLE = (
    ArithmeticError, AttributeError, EOFError, LookupError, NameError,
    NotImplementedError, OSError, RecursionError, SyntaxError, TypeError, ValueError, struct.error,
)  # fmt: skip
"""What the parsers behind trimesh raise on bytes that are not what they promise."""


def read_mesh(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices (V, 3) and faces (F, 3) of a GLB, OBJ, PLY or STL file, in the file's frame.

    Raises InputError for what is missing, too large, compressed, empty or not finite.
    """
    if path.suffix.lower() not in KINDS:
        raise _unknown(path.name)
    if not path.is_file():
        raise InputError(f"there is no mesh file at {path}")
    if path.stat().st_size > MESH.max_bytes:
        raise _too_large(path.name)
    return mesh_from(path.read_bytes(), path.name)


def mesh_from(data: bytes, name: str) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The same from the bytes of a file of that name, which says by its end what they are.

    Nothing outside of the bytes is read: a file that refers to others is refused.
    """
    found = _read(data, name, None)
    return found.vertices, found.faces


def textured_from(data: bytes, name: str, beside: Mapping[str, bytes] | None = None) -> Mesh:
    """The same with its texture, where it has one, in the file's frame and units.

    beside: what an OBJ file may name, by file name: its materials and their pictures.
    """
    return _read(data, name, dict(beside or {}))


def _read(data: bytes, name: str, beside: dict[str, bytes] | None) -> Mesh:
    if not name.lower().endswith(KINDS):
        raise _unknown(name)
    size = len(data) + sum(len(one) for one in (beside or {}).values())
    if size > MESH.max_bytes:
        raise _too_large(name)
    if data[:2] in (b"PK", b"\x1f\x8b"):
        raise InputError(f"{name} is a compressed archive, not a mesh")
    limits = Limits(
        MESH.base_s + MESH.time_per_byte_s * size, MESH.base_bytes + MESH.memory_per_byte * size
    )
    return within(limits, f"{name} cannot be read as a mesh", parsed, data, name, beside)


def parsed(data: bytes, name: str, beside: dict[str, bytes] | None = None) -> Mesh:
    """The task behind `mesh_from`: trusts the bytes with time and memory.

    beside: None to leave textures out.
    """
    _check_promise(data, name)
    parts = [part for part in _loaded(data, name, beside) if len(part.faces)]
    if not parts:
        raise InputError(f"{name} has no faces")
    if any(p.vertices.shape[1:] != (3,) or p.faces.shape[1:] != (3,) for p in parts):
        raise InputError(f"{name} is not made of triangles in space")
    vertices, faces = one_surface(
        [(np.asarray(part.vertices, float), np.asarray(part.faces)) for part in parts]
    )
    if not np.isfinite(vertices).all():
        raise InputError(f"{name} has a vertex that is not finite")
    if np.abs(vertices).max() > MESH.max_coordinate:
        raise InputError(
            f"{name} has a vertex farther than {MESH.max_coordinate:g} from its origin"
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{name} has a face with a corner that does not exist")
    places, corners, kept = _coarse(vertices, faces)
    skin = None if beside is None else skin_of(parts, name)
    if skin is None:
        return Mesh(places, corners)
    return sewn(places, corners, skin[0][kept], skin[1])


def _unknown(name: str) -> InputError:
    return InputError(f"{name} is no mesh file; give {', '.join(KINDS)}")


def _too_large(name: str) -> InputError:
    return InputError(f"{name} is larger than {MESH.max_bytes // 2**20} MB")


def _check_promise(data: bytes, name: str) -> None:
    """Refuse a file whose header promises more than it can hold or than we want."""
    kind = name[-4:].lower()
    promised = 0
    if kind == ".glb":
        promised = _glb_elements(data, name)
    elif kind == ".ply":
        head = data[: data.find(b"end_header") + 1 or 4096][:65536]
        counts = [line.split()[-1] for line in head.splitlines() if line.startswith(b"element")]
        promised = sum(int(count) for count in counts if count.isdigit())
    elif kind == ".stl" and len(data) >= 84 and not data.lstrip().startswith(b"solid"):
        (promised,) = struct.unpack("<I", data[80:84])
        if len(data) < 84 + 50 * promised:
            raise InputError(f"{name} is cut off")
    if promised > MESH.max_elements:
        raise InputError(f"{name} has {promised} elements; at most {MESH.max_elements} are read")


def _glb_elements(data: bytes, name: str) -> int:
    """Number of elements in a GLB's accessors; nothing outside of the file is referred to."""
    if data[:4] != b"glTF" or len(data) < 20:
        raise InputError(f"{name} is no GLB file")
    try:
        document = glb_document(data)
        accessors = document.get("accessors", [])
        outside = [
            b for b in document.get("buffers", []) + document.get("images", []) if "uri" in b
        ]
        count = sum(int(item["count"]) for item in accessors)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{name} is a damaged GLB file") from error
    if outside:
        raise InputError(f"{name} refers to other files; give one that holds everything")
    if any("sparse" in item for item in accessors):
        raise InputError(f"{name} uses sparse accessors, which are not read")
    return count


def _loaded(data: bytes, name: str, beside: dict[str, bytes] | None) -> list[trimesh.Trimesh]:
    try:
        if beside is not None:
            check_pictures(data, name, beside)
        loaded = trimesh.load(
            io.BytesIO(data),
            file_type=name[-3:].lower(),
            force="scene",
            process=False,
            skip_materials=beside is None,
            # What it may name: these files and no others.
            resolver=ZipResolver({name: io.BytesIO(one) for name, one in (beside or {}).items()}),
        )
        assert isinstance(loaded, trimesh.Scene)
        return [part for part in loaded.dump() if isinstance(part, trimesh.Trimesh)]
    except IndexError as error:
        # The parsers look vertices up by the numbers that faces give.
        missing = "something is missing in it, or a face has a corner that does not exist"
        raise InputError(f"{name} cannot be read as a mesh: {missing}") from error
    except UNREADABLE as error:
        raise InputError(f"{name} cannot be read as a mesh: {error}") from error


def _coarse(
    vertices: NDArray[np.float64], faces: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.bool_]]:
    """The mesh with its doubled vertices merged, and clustered if it is too fine; (F,) the faces

    that are left.
    """
    size = max(float(np.ptp(vertices, axis=0).max()), 1e-12)
    cell = size * 1e-7
    while True:
        grid = np.round((vertices - vertices.min(0)) / cell).astype(np.int64)
        _, first, index = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        merged = index.reshape(-1)[faces].astype(np.int32)
        a, b, c = merged.T
        kept = (a != b) & (b != c) & (a != c)
        if np.count_nonzero(kept) <= MESH.max_faces:
            return vertices[first], merged[kept], kept
        cell = max(cell * 1.5, size / 400)


def body_of(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], name: str
) -> tuple[Mesh, NDArray[np.float64]]:
    """The mesh about its centre of mass, facing outward, and that centre in the given frame."""
    volume, centre = volume_and_centre(vertices, faces)
    if volume < 0:
        faces = faces[:, ::-1].copy()
    low, high = vertices.min(0), vertices.max(0)
    if (high - low).min() <= 0:
        raise InputError(f"the mesh of '{name}' is flat")
    if (
        abs(volume) < 1e-4 * float(np.prod(high - low))
        or not ((centre > low) & (centre < high)).all()
    ):
        # An open surface encloses nothing; the middle of its box has to do.
        centre = (low + high) / 2
    return Mesh(vertices - centre, faces), centre
