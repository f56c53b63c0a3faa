"""A form from a mesh file becomes an object: how large it is, which way up, where it stands."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.program import AddItem, Edit, PhysicalProgram
from physagent_studio.program.scene.state import Meshed, SceneObject
from physagent_studio.reconstruction.backends.frames import zup_from_yup
from physagent_studio.reconstruction.backends.mesh_files import body_of, mesh_from
from physagent_studio.records import Mesh

Up = Literal["y", "z"]
Y_UP = (".glb", ".obj")
"""Kinds of files whose up is y, by their standard or by what most programs write."""
BELIEVED = (0.05, 20.0)
"""Longest edges that are taken for metres, as multiples of the usual size in the scene."""


@dataclass(frozen=True, eq=False, slots=True)
class Form:
    """What a mesh file holds, in the file's own frame and units: (V, 3) and (F, 3)."""

    file: str
    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]

    @property
    def up(self) -> Up:
        """Which axis usually points up in such a file."""
        return "y" if self.file.lower().endswith(Y_UP) else "z"

    @property
    def extent(self) -> float:
        """Its longest edge in the file's units."""
        return float(np.ptp(self.vertices, axis=0).max())

    def believed(self, usual: float) -> float:
        """The longest edge in metres: the file's own if it fits things of size `usual`, m."""
        low, high = BELIEVED
        fits = low * usual <= self.extent <= high * usual
        return float(f"{self.extent if fits else usual:.3g}")

    def body(self, name: str, longest: float, up: Up) -> Mesh:
        """The form `longest` metres long, z up, about its centre of mass."""
        vertices = zup_from_yup(self.vertices) if up == "y" else self.vertices
        return body_of(vertices * (longest / self.extent), self.faces, name)[0]


def read_form(data: bytes, file: str) -> Form:
    """The form in the bytes of a mesh file, which can be set down as it is.

    Raises InputError for what `mesh_from` refuses, and for what is flat.
    """
    vertices, faces = mesh_from(data, file)
    body_of(vertices, faces, PurePosixPath(file).stem)
    return Form(file, vertices, faces)


def name_for(program: PhysicalProgram, wanted: str) -> str:
    """A name that a program does not have yet, made of what was wanted."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", wanted).strip("_-")[:56] or "mesh"
    scene = program.scene
    taken = {one.name for one in (*scene.objects, *scene.supports, *scene.landmarks)}
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem}_{number}", number + 1
    return name


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
