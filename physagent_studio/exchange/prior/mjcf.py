"""The scene as MJCF with one keyframe for each frame, so that MuJoCo shows the clip as it was."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from trimesh.exchange.stl import export_stl

from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.prior.folder import MAX_PROGRAM, Prior
from physagent_studio.exchange.prior.sink import Sink
from physagent_studio.program.text.document import load_program


def mjcf(prior: Prior, out: Path) -> str:
    """`scene.xml` and a mesh for each rigid object; soft ones have no keyframes and are left out.

    Keyframe t holds the poses of frame t. Forces and schedule are in program.yaml.
    """
    rollout = prior.rollout()
    soft = {name for name, _ in rollout.vertices}
    rigid = [index for index, name in enumerate(rollout.objects) if name not in soft]
    sink = Sink(out)
    root = ET.Element("mujoco", model="physagent")
    ET.SubElement(root, "compiler", angle="radian", meshdir=".", inertiafromgeom="true")
    program = load_program(text_of(prior.folder / "program.yaml", MAX_PROGRAM))
    pull = _row(np.asarray(program.scene.gravity))
    ET.SubElement(root, "option", timestep=f"{rollout.step_seconds:.6g}", gravity=pull)
    asset, world = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody")
    _camera(world, prior)
    found = trimesh.load(prior.folder / "scene.glb", force="scene")
    assert isinstance(found, trimesh.Scene)
    for index in rigid:
        name = rollout.objects[index]
        mesh = found.geometry[name]
        assert isinstance(mesh, trimesh.Trimesh)
        sink.data(f"{name}.stl", export_stl(mesh))
        ET.SubElement(asset, "mesh", name=name, file=f"{name}.stl", inertia="shell")
        place, turn = rollout.positions[0, index], rollout.rotations[0, index]
        body = ET.SubElement(world, "body", name=name, pos=_row(place), quat=_row(turn))
        ET.SubElement(body, "freejoint", name=name)
        mass = f"{float(rollout.masses[index]):.9g}"
        ET.SubElement(body, "geom", type="mesh", mesh=name, mass=mass)
    keys = ET.SubElement(root, "keyframe")
    for number, step in enumerate(rollout.frame_steps()):
        poses = [
            np.concatenate([rollout.positions[step, i], rollout.rotations[step, i]]) for i in rigid
        ]
        time = f"{step * rollout.step_seconds:.9g}"
        values = _row(np.concatenate(poses)) if poses else ""
        ET.SubElement(keys, "key", name=f"frame_{number:04d}", time=time, qpos=values)
    ET.indent(root)
    sink.text("scene.xml", ET.tostring(root, encoding="unicode") + "\n")
    left = f"; left out, being soft: {', '.join(sorted(soft))}" if soft else ""
    return f"the objects as MJCF with {rollout.frames} keyframes{left}"


def _camera(world: ET.Element, prior: Prior) -> None:
    """MuJoCo's cameras look along −z with y up."""
    camera = prior.meta["camera"]
    w, x, y, z = camera["rotation_world_camera_wxyz"]
    # Half a turn about x: (w, x, y, z) · (0, 1, 0, 0).
    turned = np.array([-x, w, z, -y])
    rows = prior.size[1]
    fovy = np.degrees(2 * np.arctan2(rows / 2, camera["intrinsics"][1][1]))
    ET.SubElement(
        world,
        "camera",
        name="photo",
        pos=_row(np.asarray(camera["position"])),
        quat=_row(turned),
        fovy=f"{float(fovy):.9g}",
    )


def _row(values: np.ndarray) -> str:
    return " ".join(f"{float(value):.17g}" for value in values)
