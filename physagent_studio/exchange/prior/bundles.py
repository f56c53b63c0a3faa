"""A motion prior rewritten as others read it; each bundle is a folder beside its frames."""

import secrets
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import trimesh
from trimesh.exchange.stl import export_stl

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange.files import text_of, written
from physagent_studio.exchange.prior import generators
from physagent_studio.exchange.prior.folder import MAX_PROGRAM, Prior
from physagent_studio.exchange.prior.peer_config import peer_config
from physagent_studio.exchange.prior.rerun import rerun, rerun_package
from physagent_studio.exchange.prior.stretches import Sink
from physagent_studio.exchange.tables import parquet_packages, write_csv, write_parquet
from physagent_studio.program.text.document import load_program
from physagent_studio.rendering import Flow


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


Bundle = Callable[[Prior, Path], str]
KITTI_SCALE, KITTI_ZERO = 64.0, 2**15
"""KITTI's flow PNG: 64 a pixel, 0 at 2¹⁵ (Geiger et al., development kit of the flow benchmark)."""


def write_bundles(
    folder: Path | str,
    names: Sequence[str],
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[str], None] | None = None,
) -> list[str]:
    """Writes those bundles into a finished prior, each whole or not at all; a line on each.

    progress: told which bundle reads what of which frame.

    Raises:
        InputError: the folder is no prior, or a name is not known.
        BackendMissing: a bundle needs a package that is not installed.
        Cancelled: `cancelled` said so; bundles before the one at work stay.
    """
    check_bundles(names)
    prior, said = Prior.open(folder), []
    for name in names:

        def reading(what: str, name: str = name) -> None:
            if cancelled is not None and cancelled():
                raise Cancelled("cancelled")
            if progress is not None:
                progress(f"{name}: {what}")

        said.append(f"{name}: {_whole(name, replace(prior, reading=reading))}")
    return said


def check_bundles(names: Sequence[str]) -> None:
    """Raises what `write_bundles` would for a name or a package, before anything is done."""
    unknown = [name for name in names if name not in BUNDLES]
    if unknown:
        raise InputError(f"there is no bundle '{unknown[0]}' (known: {', '.join(BUNDLES)})")
    for name in names:
        if name in _PACKAGES:
            _PACKAGES[name]()


def _whole(name: str, prior: Prior) -> str:
    """Writes a bundle beside its place and moves it there when it is done; what to know of it."""
    place = prior.folder / name
    # What an end of the process has left there is half a bundle.
    for old in prior.folder.glob(f".{name}.*"):
        shutil.rmtree(old, ignore_errors=True)
    partial = prior.folder / f".{name}.{secrets.token_hex(4)}"
    try:
        partial.mkdir()
        said = BUNDLES[name](prior, partial)
        shutil.rmtree(place, ignore_errors=True)
        partial.replace(place)
    except OSError as error:
        raise InputError(f"{place} cannot be written ({error.strerror or error})") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return said


def flo(prior: Prior, out: Path) -> str:
    """Middlebury's .flo, forward and backward."""
    for number in range(prior.frames - 1):
        for way, flow in (("forward", prior.flow(number)), ("backward", prior.backward(number))):
            with written(out / f"{way}_{number:04d}.flo") as path:
                if not cv2.writeOpticalFlow(str(path), flow.vectors):
                    raise InputError(f"{path.name} cannot be written")
    return "flow as Middlebury .flo, forward and backward"


def kitti(prior: Prior, out: Path) -> str:
    """KITTI's 16-bit PNG; invalid where the pixel is hidden in the other frame."""
    sink = Sink(out)
    for number in range(prior.frames - 1):
        for way, flow in (("forward", prior.flow(number)), ("backward", prior.backward(number))):
            sink.png(f"{way}_{number:04d}.png", _kitti_picture(flow))
    return "flow as 16-bit PNG as KITTI has it, to a 64th of a pixel; what gets hidden is invalid"


def _kitti_picture(flow: Flow) -> np.ndarray:
    """(H, W, 3) uint16: x, y, valid."""
    coded = np.round(flow.vectors * KITTI_SCALE + KITTI_ZERO)
    told = flow.visible & (coded >= 0).all(-1) & (coded <= 65535).all(-1)
    picture = np.zeros((*told.shape, 3), np.uint16)
    picture[..., 0], picture[..., 1] = np.moveaxis(np.clip(coded, 0, 65535), -1, 0)
    picture[..., 2] = told
    return picture


def trajectories(prior: Prior) -> Mapping[str, np.ndarray]:
    """Columns of one row for each control step and object: time s, m, quaternion wxyz, m/s."""
    rollout = prior.rollout()
    steps, count = len(rollout.positions), len(rollout.objects)
    step = np.repeat(np.arange(steps), count)
    columns: dict[str, np.ndarray] = {
        "step": step,
        "time": step * rollout.step_seconds,
        "object": np.tile(np.array(rollout.objects), steps),
    }
    for names, values in (
        ("x y z", rollout.positions),
        ("qw qx qy qz", rollout.rotations),
        ("vx vy vz", rollout.velocities),
        ("wx wy wz", rollout.angular),
    ):
        flat = values.reshape(-1, values.shape[-1])
        columns |= {name: flat[:, k] for k, name in enumerate(names.split())}
    return columns


def tables(prior: Prior, out: Path) -> str:
    """Trajectories as CSV."""
    columns = {name: column.tolist() for name, column in trajectories(prior).items()}
    write_csv(columns, out / "trajectories.csv")
    return "where every object is at every step, as CSV"


def parquet(prior: Prior, out: Path) -> str:
    """Trajectories as Parquet. Raises BackendMissing without pyarrow."""
    write_parquet(trajectories(prior), out / "trajectories.parquet")
    return "where every object is at every step, as Parquet"


BUNDLES: Mapping[str, Bundle] = {
    "flo": flo,
    "kitti": kitti,
    "csv": tables,
    "parquet": parquet,
    "mjcf": mjcf,
    "rerun": rerun,
    "peer-config": peer_config,
    "final-sim": generators.final_sim,
    "wan-vace": generators.wan_vace,
    "wan-fun": generators.wan_fun,
    "go-with-the-flow": generators.go_with_the_flow,
}
"""What a prior can be rewritten as, by name."""
_PACKAGES: Mapping[str, Callable[[], object]] = {
    "parquet": parquet_packages,
    "rerun": rerun_package,
}
"""What some of them need that may not be installed."""
