"""MJCF and URDF files as programs: MuJoCo reads them, from memory and in a limited process.

A file may name meshes and pictures in its own folder or below; it may not include others. Free
bodies of one form become objects, what is fixed to the world becomes supports; the rest is listed.
"""

import math
import xml.etree.ElementTree as ET
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_reader import slug
from physagent_studio.exchange.files import bytes_of
from physagent_studio.jobs import Limits, within
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.text.document import validate_data

MAX_BYTES, MAX_ASSETS = 4 * 2**20, 32 * 2**20
"""Bytes of the file, and of all that it names."""
LIMITS = Limits(seconds=0.7, memory=192 * 2**20)
"""What reading may take."""
_ASSETS = (".stl", ".obj", ".msh", ".png")
_FOLDERS = ("meshdir", "texturedir", "assetdir")
_LEVEL = 0.999
"""Cosine between up and a side of a box from which on it is level."""
_FORMS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
"""MuJoCo's forms of geoms by number (mjtGeom)."""


def load_mjcf(path: Path) -> tuple[PhysicalProgram, tuple[str, ...]]:
    """The program of a file, and what of it is not taken over.

    Raises:
        InputError: in one sentence: what is wrong and what is allowed.
    """
    text = bytes_of(path, MAX_BYTES)
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise InputError(f"{path} declares entities, which are not read")
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path} is no XML: {error}") from error
    if root.tag not in ("mujoco", "robot"):
        raise InputError(f"{path} is neither MJCF nor URDF (its root is <{root.tag[:40]}>)")
    assets = _assets(path, root)
    failed = f"{path} cannot be read"
    data, left_out = within(LIMITS, failed, read, ET.tostring(root), path.name, assets)
    return validate_data(data), tuple(left_out)


def _assets(path: Path, root: ET.Element) -> dict[str, bytes]:
    """What the file names, under names of ours that it has instead from now on."""
    folders = {
        key: node.attrib.pop(key) for node in root.iter() for key in _FOLDERS if key in node.attrib
    }
    found: dict[str, bytes] = {}
    room = MAX_ASSETS
    for node in root.iter():
        if node.tag in ("include", "plugin", "extension", "model", "attach"):
            raise InputError(
                f"{path}: <{node.tag}> is not read; give one file that holds everything"
            )
        for key in [key for key in node.attrib if key.startswith("file")]:
            folder = folders.get("texturedir" if node.tag == "texture" else "meshdir")
            said = PurePosixPath(folder or folders.get("assetdir") or "") / node.attrib[key]
            if said.is_absolute() or ".." in said.parts or "\\" in str(said) or ":" in str(said):
                raise InputError(f"{path}: {str(said)[:80]} is outside of its folder")
            place = path.parent / said
            inside = place.resolve().is_relative_to(path.parent.resolve())
            if said.suffix.lower() not in _ASSETS or not inside or not place.is_file():
                kinds = ", ".join(_ASSETS)
                raise InputError(f"{path}: there is no {str(said)[:80]} in its folder ({kinds})")
            data = bytes_of(place, room)
            room -= len(data)
            node.attrib[key] = f"asset_{len(found)}{said.suffix.lower()}"
            found[node.attrib[key]] = data
    return found


def read(text: bytes, name: str, assets: dict[str, bytes]) -> tuple[dict[str, Any], list[str]]:
    """The task behind `load_mjcf`: a program as plain data, and what is left out."""
    from physagent_studio.simulation.mj import mj

    try:
        model = mj.MjModel.from_xml_string(text.decode(), assets)
    except (ValueError, mj.FatalError) as error:
        raise InputError(f"{name} cannot be read: {' '.join(str(error).split())[:300]}") from error
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    arrays = (data.geom_xpos, data.geom_xmat, model.geom_size, model.body_mass, model.opt.gravity)
    if not all(np.isfinite(one).all() for one in arrays):
        raise InputError(f"{name} has a number that is not finite")
    reader = _Scene(mj, model, data)
    return reader.program(slug(Path(name).stem)), reader.left_out


class _Scene:
    def __init__(self, mj: Any, model: Any, data: Any) -> None:
        self.mj, self.model, self.data = mj, model, data
        self.left_out: list[str] = []

    def program(self, name: str) -> dict[str, Any]:
        model = self.model
        objects, supports = [], []
        for body in range(model.nbody):
            geoms = range(
                model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]
            )
            solid = [
                g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]
            ] or list(geoms)
            if model.body_weldid[body] == 0:
                supports += [one for g in solid if (one := self._support(g)) is not None]
            elif model.body_dofnum[body] == 6 and len(solid) == 1:
                objects.append(self._object(body, solid[0]))
            else:
                joints = (
                    "a body with joints" if model.body_dofnum[body] != 6 else "of several forms"
                )
                self.left_out.append(f"{self._name('body', body)}: {joints}")
        for count, what in (
            (model.nu, "actuators"),
            (model.neq, "equalities"),
            (model.ntendon, "tendons"),
        ):
            self.left_out += [f"{count} {what}"] if count else []
        scene = {"objects": objects, "supports": supports, "gravity": model.opt.gravity.tolist()}
        return {"scene": scene, "event": {"prompt": name.replace("_", " ")}}

    def _object(self, body: int, geom: int) -> dict[str, Any]:
        model = self.model
        shape, volume = self._shape(geom)
        density = float(model.body_mass[body]) / max(volume, 1e-12)
        pose = np.zeros(4)
        self.mj.mju_mat2Quat(pose, self.data.geom_xmat[geom])
        return {
            "name": self._name("body", body),
            "shape": shape,
            "position": self.data.geom_xpos[geom].tolist(),
            "rotation": pose.tolist(),
            "density": min(max(density, 0.1), 30000.0),
            "friction": min(float(model.geom_friction[geom][0]), 5.0),
        }

    def _shape(self, geom: int) -> tuple[dict[str, Any], float]:
        """The form of a geom, and its volume."""
        kind, (a, b, c) = _FORMS[self.model.geom_type[geom]], map(float, self.model.geom_size[geom])
        if kind == "sphere":
            return {"kind": kind, "radius": a}, 4 / 3 * math.pi * a**3
        if kind == "ellipsoid":
            return {"kind": kind, "radii": [a, b, c]}, 4 / 3 * math.pi * a * b * c
        if kind == "cylinder":
            return {"kind": kind, "radius": a, "height": 2 * b}, 2 * math.pi * a * a * b
        if kind == "capsule":
            volume = math.pi * a * a * (2 * b + 4 / 3 * a)
            return {"kind": kind, "radius": a, "height": 2 * (a + b)}, volume
        half = (a, b, c) if kind == "box" else tuple(map(float, self.model.geom_aabb[geom][3:]))
        if kind != "box":
            self.left_out.append(f"the {kind} of {self._name('geom', geom)}: a box of its size")
        return {"kind": "box", "size": [2 * side for side in half]}, 8 * math.prod(half)

    def _support(self, geom: int) -> dict[str, Any] | None:
        place, turn = self.data.geom_xpos[geom], self.data.geom_xmat[geom].reshape(3, 3)
        kind, name = _FORMS[self.model.geom_type[geom]], self._name("geom", geom)
        if kind == "plane" and turn[2, 2] > _LEVEL:
            shape: dict[str, Any] = {"kind": "floor", "height": float(place[2])}
        elif kind == "plane" and abs(turn[2, 2]) < 1 - _LEVEL:
            yaw = math.atan2(turn[1, 2], turn[0, 2])
            shape = {"kind": "wall", "point": place.tolist(), "yaw": yaw}
        elif kind == "box" and turn[2, 2] > _LEVEL:
            size = (2 * self.model.geom_size[geom]).tolist()
            yaw = math.atan2(turn[1, 0], turn[0, 0])
            shape = {"kind": "box", "position": place.tolist(), "size": size, "yaw": yaw}
        else:
            self.left_out.append(f"{name}: a {kind} that does not move")
            return None
        friction = min(float(self.model.geom_friction[geom][0]), 5.0)
        return {"name": name, "shape": shape, "friction": friction}

    def _name(self, kind: str, index: int) -> str:
        said = (self.model.body(index) if kind == "body" else self.model.geom(index)).name
        return slug(said) or f"{kind}_{index}"
