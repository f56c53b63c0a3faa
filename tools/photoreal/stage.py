"""What stands before the camera, and its translation for the path tracer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from photoreal.meshes import Mesh, box
from photoreal.textures import Surface

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Lens:
    """A level camera at `position` pitched down; `focal` in pixels, principal point central.

    aperture: radius in metres, 0 is a pinhole. focus: distance along the axis, metres.
    """

    size: tuple[int, int]
    focal: float
    position: tuple[float, float, float]
    pitch: float
    aperture: float = 0.0
    focus: float = 1.0

    @property
    def rotation(self) -> Array:
        """`R_world_camera` (3, 3), camera x right, y down, z forward."""
        down, ahead = math.sin(self.pitch), math.cos(self.pitch)
        return np.array([[1, 0, 0], [0, -down, ahead], [0, -ahead, -down]], float)

    def project(self, points: Array) -> Array:
        """World points (N, 3) → pixels (N, 2)."""
        local = (np.atleast_2d(points) - self.position) @ self.rotation
        return self.focal * local[:, :2] / local[:, 2:] + np.asarray(self.size) / 2


@dataclass(frozen=True)
class Item:
    """A body in the scene. `truth` is its entry in the truth file, None for the surroundings.

    gloss: further parameters of Mitsuba's `principled` material.
    """

    mesh: Mesh
    surface: Surface
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: Array = field(default_factory=lambda: np.eye(3))
    truth: dict[str, Any] | None = None
    gloss: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Room:
    """A closed room, lit by one window of 2 × 3 panes in its left wall.

    low, high: inner corners, metres. window: its centre (y, z) and size. radiance: linear RGB.
    walls: albedo of everything but the back wall, which is an `Item`.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    window: tuple[float, float]
    window_size: tuple[float, float]
    radiance: tuple[float, float, float] = (11.0, 12.2, 13.6)
    walls: tuple[float, float, float] = (0.52, 0.49, 0.44)
    floor: tuple[float, float, float] = (0.30, 0.24, 0.19)


def turn(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Array:
    """Rotation matrix Rz(yaw) Ry(pitch) Rx(roll), radians."""
    cz, sz, cy, sy = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    cx, sx = math.cos(roll), math.sin(roll)
    rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    return rz @ ry @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])


def _bitmap(values: NDArray[np.floating]) -> dict[str, Any]:
    data = np.ascontiguousarray(values if values.ndim == 3 else values[..., None], np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(data), "raw": True, "wrap_mode": "repeat"}


def material(item: Item) -> dict[str, Any]:
    """Mitsuba's principled material with the item's colour, roughness and relief."""
    surface = item.surface
    inner = {
        "type": "principled",
        "base_color": _bitmap(surface.colour),
        "roughness": _bitmap(surface.roughness),
        "specular": 0.5,
        **item.gloss,
    }
    if float(np.ptp(surface.height)) == 0.0:
        return inner
    return {"type": "bumpmap", "relief": _bitmap(surface.height), "scale": 1.0, "bsdf": inner}


def _wall(corner: Sequence[float], a: Sequence[float], b: Sequence[float]) -> Mesh:
    """A parallelogram whose normal is a × b."""
    start, u, v = (np.asarray(p, float) for p in (corner, a, b))
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    points = np.stack([start, start + u, start + u + v, start + v])
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(points, np.tile(normal, (4, 1)), uv, faces)


def panel(corner: Sequence[float], along: Sequence[float], up: Sequence[float]) -> Mesh:
    """A flat rectangle with texture u `along` and v `up`; visible from the side along × up."""
    return _wall(corner, along, up)


def _shell(room: Room) -> list[tuple[Mesh, tuple[float, float, float]]]:
    """Every inner face but the back wall, with its albedo."""
    (x0, y0, z0), (x1, y1, z1) = room.low, room.high
    dx, dy, dz = (x1 - x0, 0, 0), (0, y1 - y0, 0), (0, 0, z1 - z0)
    return [
        (_wall((x0, y0, z0), dx, dy), room.floor),
        (_wall((x0, y0, z1), dy, dx), (0.72, 0.71, 0.69)),
        (_wall((x0, y0, z0), dy, dz), room.walls),
        (_wall((x1, y0, z0), dz, dy), room.walls),
        (_wall((x0, y0, z0), dz, dx), room.walls),
    ]


def _window(room: Room) -> tuple[list[Mesh], list[Mesh]]:
    """Panes that shine and bars that do not, just inside the left wall."""
    x = room.low[0] + 0.02
    (cy, cz), (wy, wz) = room.window, room.window_size
    columns, rows, bar = 2, 3, 0.045
    dy, dz = wy / columns, wz / rows
    panes = []
    for i in range(columns):
        for j in range(rows):
            corner = (x, cy - wy / 2 + i * dy + bar / 2, cz - wz / 2 + j * dz + bar / 2)
            panes.append(_wall(corner, (0, dy - bar, 0), (0, 0, dz - bar)))
    frame = box((0.05, wy + 0.16, wz + 0.16), 0.004)
    return panes, [frame.posed(np.eye(3), np.array([x - 0.03, cy, cz]))]


def build(items: Sequence[Item], room: Room, lens: Lens, folder: Path) -> mi.Scene:
    """The Mitsuba scene; meshes pass through PLY files in `folder`."""
    scene: dict[str, Any] = {"type": "scene", "sensor": _sensor(lens)}

    def add(name: str, mesh: Mesh, bsdf: dict[str, Any], **more: Any) -> None:
        path = folder / f"{name}.ply"
        mesh.write_ply(path)
        scene[name] = {"type": "ply", "filename": str(path), "bsdf": bsdf, **more}

    def matt(albedo: Sequence[float]) -> dict[str, Any]:
        colour = {"type": "rgb", "value": list(albedo)}
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}

    for k, item in enumerate(items):
        add(
            f"item_{k:03d}", item.mesh.posed(item.rotation, np.array(item.position)), material(item)
        )
    for k, (mesh, albedo) in enumerate(_shell(room)):
        add(f"shell_{k}", mesh, matt(albedo))
    panes, bars = _window(room)
    light = {"type": "rgb", "value": list(room.radiance)}
    for k, mesh in enumerate(panes):
        add(f"pane_{k}", mesh, matt((0.1, 0.1, 0.1)), light={"type": "area", "radiance": light})
    for k, mesh in enumerate(bars):
        add(f"bar_{k}", mesh, matt((0.8, 0.8, 0.78)))
    # Unoptimised: merging shapes would lose their names.
    return mi.load_dict(scene, optimize=False)


def _sensor(lens: Lens) -> dict[str, Any]:
    rotation = lens.rotation
    eye = np.asarray(lens.position)
    look = mi.ScalarTransform4f().look_at(
        origin=eye.tolist(),
        target=(eye + rotation[:, 2]).tolist(),
        up=(-rotation[:, 1]).tolist(),
    )
    sensor: dict[str, Any] = {
        "type": "thinlens" if lens.aperture > 0 else "perspective",
        "to_world": look,
        "fov": math.degrees(2 * math.atan(lens.size[1] / 2 / lens.focal)),
        "fov_axis": "y",
        "near_clip": 0.01,
        "far_clip": 50.0,
        "film": {
            "type": "hdrfilm",
            "width": lens.size[0],
            "height": lens.size[1],
            "pixel_format": "rgb",
            "component_format": "float32",
            # One pixel depends on its own samples alone, so that a seed gives the same bits.
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "multijitter"},
    }
    if lens.aperture > 0:
        sensor |= {"aperture_radius": lens.aperture, "focus_distance": lens.focus}
    return sensor


def radiance(
    items: Sequence[Item], room: Room, lens: Lens, *, samples: int, seed: int
) -> NDArray[np.floating]:
    """Path-traced linear RGB (H, W, 3)."""
    with TemporaryDirectory() as folder:
        scene = build(items, room, lens, Path(folder))
        integrator = mi.load_dict({"type": "path", "max_depth": 9, "rr_depth": 5})
        image = mi.render(scene, integrator=integrator, spp=samples, seed=mi.UInt32(seed))
    return np.array(image, np.float32)[..., :3]


def identities(items: Sequence[Item], lens: Lens, fine: int = 4) -> NDArray[np.uint8]:
    """(H, W) uint8: `truth["id"]` of what most of each pixel shows through a pinhole, else 0."""
    width, height = lens.size
    sharp = Lens((width * fine, height * fine), lens.focal * fine, lens.position, lens.pitch)
    scene: dict[str, Any] = {"type": "scene", "sensor": _sensor(sharp)}
    with TemporaryDirectory() as folder:
        for k, item in enumerate(items):
            path = Path(folder) / f"{k}.ply"
            item.mesh.posed(item.rotation, np.array(item.position)).write_ply(path)
            # Every body glows with its own number, and nothing else is lit.
            number = float(item.truth["id"]) if item.truth else 0.0
            glow = {"type": "area", "radiance": {"type": "rgb", "value": [number] * 3}}
            scene[f"item_{k}"] = {"type": "ply", "filename": str(path), "emitter": glow}
        integrator = mi.load_dict({"type": "path", "max_depth": 1})
        image = mi.render(mi.load_dict(scene), integrator=integrator, spp=1, seed=mi.UInt32(0))
    ids = np.rint(np.array(image)[..., 0]).astype(np.uint8)
    blocks = ids.reshape(height, fine, width, fine).transpose(0, 2, 1, 3).reshape(height, width, -1)
    votes = [(blocks == value).sum(-1) for value in range(int(ids.max()) + 1)]
    return np.argmax(votes, axis=0).astype(np.uint8)
