"""A form from a mesh file becomes an object: how large it is, which way up, where it stands."""

import hashlib
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Literal

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.exchange.files import bytes_of
from physagent_studio.jobs import Limits, within
from physagent_studio.program import AddItem, Edit, PhysicalProgram
from physagent_studio.program.base import free_name
from physagent_studio.program.scene.state import Meshed, SceneObject
from physagent_studio.reconstruction.backends.frames import zup_from_yup
from physagent_studio.reconstruction.backends.mesh_files import (
    MESH,
    UNREADABLE,
    body_of,
    textured_from,
)
from physagent_studio.reconstruction.backends.mesh_skins import PICTURES
from physagent_studio.records import Mesh
from physagent_studio.session.arrays import unpack_mesh
from physagent_studio.session.session import MESH_SUFFIX

Up = Literal["y", "z"]
Y_UP = (".glb", ".obj")
"""Kinds of files whose up is y, by their standard or by what most programs write."""
MAX_NAMED = 64
"""Files that a file may name."""
FORM = Limits(seconds=0.8, memory=192 * 2**20)
"""What checking a stored form may take."""
BELIEVED = (0.05, 20.0)
"""Longest edges that are taken for metres, as multiples of the usual size in the scene."""


@dataclass(frozen=True, eq=False, slots=True)
class Form:
    """What a mesh file holds, in the file's own frame and units."""

    file: str
    mesh: Mesh

    @property
    def up(self) -> Up:
        """Which axis usually points up in such a file."""
        return "y" if self.file.lower().endswith(Y_UP) else "z"

    @property
    def extent(self) -> float:
        """Its longest edge in the file's units."""
        return float(np.ptp(self.mesh.vertices, axis=0).max())

    def believed(self, usual: float) -> float:
        """The longest edge in metres: the file's own if it fits things of size `usual`, m."""
        low, high = BELIEVED
        fits = low * usual <= self.extent <= high * usual
        return float(f"{self.extent if fits else usual:.3g}")

    def body(self, name: str, longest: float, up: Up) -> Mesh:
        """The form `longest` metres long, z up, about its centre of mass."""
        vertices = zup_from_yup(self.mesh.vertices) if up == "y" else self.mesh.vertices
        body, _ = body_of(vertices * (longest / self.extent), self.mesh.faces, name)
        return replace(self.mesh, vertices=body.vertices, faces=body.faces)


def read_form(data: bytes, file: str, beside: Mapping[str, bytes] | None = None) -> Form:
    """The form in the bytes of a mesh file, which can be set down as it is.

    beside: see `textured_from`. Raises InputError for what that refuses, and for what is flat.
    """
    mesh = textured_from(data, file, beside)
    body_of(mesh.vertices, mesh.faces, PurePosixPath(file).stem)
    return Form(file, mesh)


def materials_beside(path: Path) -> dict[str, bytes]:
    """The materials that an OBJ file names, and their pictures: those in its own folder."""
    found: dict[str, bytes] = {}
    if path.suffix.lower() != ".obj":
        return found
    for name in _named(bytes_of(path, MESH.max_bytes), b"mtllib", (".mtl",)):
        found |= _one(path, name)
    for data in tuple(found.values()):
        for name in _named(data, b"map_Kd", PICTURES):
            found |= _one(path, name)
    return found


def _named(data: bytes, word: bytes, endings: tuple[str, ...]) -> list[str]:
    lines = re.findall(rb"^[ \t]*" + word + rb"[ \t]+([^\r\n]{1,200})", data, re.M)[:MAX_NAMED]
    names = [line.decode("utf-8", "replace").strip() for line in lines]
    return [name for name in names if name.lower().endswith(endings)]


def _one(path: Path, name: str) -> dict[str, bytes]:
    """A file beside another; none where the name leads elsewhere or to nothing."""
    place = path.parent / name
    whole = place.name == name and not place.is_symlink() and place.is_file()
    return {name: bytes_of(place, MESH.max_bytes)} if whole else {}


def forms_beside(path: Path, program: PhysicalProgram) -> dict[str, bytes]:
    """The stored forms that a program names and that lie beside its file, by asset.

    Raises InputError for one that was changed or is damaged.
    """
    found: dict[str, bytes] = {}
    for item in program.scene.objects:
        if not isinstance(item.shape, Meshed):
            continue
        place = path.parent / f"{item.shape.asset}{MESH_SUFFIX}"
        if not place.is_file():
            continue
        data = bytes_of(place, MESH.max_bytes)
        if hashlib.sha256(data).hexdigest() != item.shape.asset:
            raise InputError(f"{place.name} was changed after it was written")
        within(FORM, f"{place.name} is no stored form", check_form, data)
        found[item.shape.asset] = data
    return found


def check_form(data: bytes) -> None:
    """A task: raises InputError for bytes that are no stored form."""
    try:
        mesh = unpack_mesh(data)
        sound = [mesh.vertices.shape[1:] == (3,), mesh.faces.shape[1:] == (3,)]
        sound += [np.isfinite(mesh.vertices).all(), mesh.faces.min() >= 0]
        sound += [mesh.faces.max() < len(mesh.vertices), len(mesh.faces) <= MESH.max_faces]
        sound += [mesh.uv is None or mesh.uv.shape == (len(mesh.vertices), 2)]
    except (*UNREADABLE, AssertionError, zipfile.BadZipFile) as error:
        raise InputError(f"it is damaged: {error}") from error
    if not all(sound):
        raise InputError("what it says contradicts itself")


def name_for(program: PhysicalProgram, wanted: str) -> str:
    """A name that a program does not have yet, made of what was wanted."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", wanted).strip("_-")[:56] or "mesh"
    return free_name(stem, program.scene.names)


def adding(
    name: str, body: Mesh, asset: str, foot: tuple[float, float, float], support: str | None
) -> tuple[Edit, ...]:
    """The edits that set a body down with its lowest point at the height of `foot`, world, m."""
    x, y, z = foot
    low = float(body.vertices[:, 2].min())
    wide, deep, high = (float(part) for part in np.ptp(body.vertices, axis=0))
    if min(wide, deep, high) <= 0:
        raise InputError(f"the mesh of '{name}' is flat")
    item = SceneObject(
        name=name,
        shape=Meshed(asset=asset, size=(wide, deep, high)),
        position=(x, y, z - low),
        support=support,
        source="person",
    )
    return (AddItem(path="scene.objects", item=item.model_dump(mode="json", exclude_none=True)),)
