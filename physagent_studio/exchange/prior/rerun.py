"""The clip as a recording for Rerun's viewer: things that move, what they touch, the pictures."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from trimesh.visual.texture import TextureVisuals

from physagent_studio.errors import BackendMissing
from physagent_studio.exchange.files import written
from physagent_studio.exchange.prior.folder import Prior
from physagent_studio.records.rollout import Rollout

FRAME, SECONDS = "frame", "seconds"
"""Timelines: the number of the picture, and the time of the event, s."""
_PNG = "image/png"


def rerun_package() -> Any:
    """Rerun's package, else BackendMissing."""
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        raise BackendMissing(
            "a recording for Rerun needs its package: pip install 'physagent-studio[rerun]'"
        ) from error


def rerun(prior: Prior, out: Path) -> str:
    """`clip.rrd`, in metres, z up, with the timelines `frame` and `seconds`.

    world/things/NAME, world/supports/NAME: meshes. world/paths/NAME: ways of the centres of mass.
    world/contacts: an arrow of a metre for each N·s of a frame. world/camera/picture: the frames,
    with their depth below. Raises BackendMissing without Rerun's package.
    """
    rr = rerun_package()
    rollout = prior.rollout()
    # The same clip is the same recording, so that a viewer does not show it twice.
    stream = rr.RecordingStream("physagent", recording_id=str(prior.meta["made_from"]["rollout"]))
    with written(out / "clip.rrd") as partial:
        stream.save(partial)
        try:
            stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True, strict=True)
            _camera(rr, stream, prior)
            _things(rr, stream, prior, rollout)
            for number in range(rollout.frames):
                _frame(rr, stream, prior, rollout, number)
        finally:
            stream.disconnect()
    return f"{rollout.frames} frames as a recording for Rerun's viewer"


def _camera(rr: Any, stream: Any, prior: Prior) -> None:
    """The photo's camera looks along z with x right and y down, as Rerun's pinhole does."""
    camera = prior.meta["camera"]
    w, x, y, z = camera["rotation_world_camera_wxyz"]
    pose = rr.Transform3D(
        translation=camera["position"], quaternion=rr.Quaternion(xyzw=[x, y, z, w])
    )
    stream.log("world/camera", pose, static=True, strict=True)
    lens = rr.Pinhole(image_from_camera=camera["intrinsics"], resolution=prior.size)
    stream.log("world/camera/picture", lens, static=True, strict=True)


def _things(rr: Any, stream: Any, prior: Prior, rollout: Rollout) -> None:
    """Meshes once, and of things their ways and, where they are rigid, their poses."""
    found = trimesh.load(prior.folder / "scene.glb", force="scene")
    assert isinstance(found, trimesh.Scene)
    soft, steps = {name for name, _ in rollout.vertices}, rollout.frame_steps()
    numbers = np.arange(rollout.frames)
    times = [
        rr.TimeColumn(FRAME, sequence=numbers),
        rr.TimeColumn(SECONDS, duration=numbers * float(prior.meta["seconds_per_frame"])),
    ]
    for name, mesh in found.geometry.items():
        assert isinstance(mesh, trimesh.Trimesh)
        room = "things" if name in rollout.objects else "supports"
        path = rr.new_entity_path(["world", room, name])
        # What is static hides what comes later, so what deforms begins with the first frame.
        stream.set_time(FRAME, sequence=0)
        stream.set_time(SECONDS, duration=0.0)
        rigid = name not in soft
        stream.log(path, _mesh(rr, mesh, rigid), static=rigid, strict=True)
        if room == "supports":
            continue
        index = rollout.objects.index(name)
        places, turns = rollout.positions[steps, index], rollout.rotations[steps, index]
        way = rr.new_entity_path(["world", "paths", name])
        stream.log(way, rr.LineStrips3D([places]), static=True, strict=True)
        if rigid:
            # Rerun writes quaternions xyzw.
            poses = rr.Transform3D.columns(translation=places, quaternion=turns[:, [1, 2, 3, 0]])
            stream.send_columns(path, indexes=times, columns=poses, strict=True)


def _mesh(rr: Any, mesh: trimesh.Trimesh, rigid: bool) -> Any:
    """With its texture, or in its colour; what deforms is without normals."""
    visual = mesh.visual
    assert isinstance(visual, TextureVisuals)
    material: Any = visual.material
    if visual.uv is None:
        shown = {"albedo_factor": material.main_color}
    else:
        # trimesh counts v from below, Rerun from above.
        places = visual.uv * (1, -1) + (0, 1)
        picture = np.asarray(material.baseColorTexture)
        shown = {"albedo_texture": picture, "vertex_texcoords": places}
    return rr.Mesh3D(
        vertex_positions=mesh.vertices,
        triangle_indices=mesh.faces,
        vertex_normals=mesh.vertex_normals if rigid else None,
        **shown,
    )


def _frame(rr: Any, stream: Any, prior: Prior, rollout: Rollout, number: int) -> None:
    """The picture, its depth, what touches since the frame before, and soft things' vertices."""
    stream.set_time(FRAME, sequence=number)
    stream.set_time(SECONDS, duration=number * float(prior.meta["seconds_per_frame"]))
    picture, depth = (prior.png(name, number) for name in ("frames/frame", "depth/depth"))
    image = rr.EncodedImage(contents=picture, media_type=_PNG)
    stream.log("world/camera/picture", image, strict=True)
    far = rr.EncodedDepthImage(depth, media_type=_PNG, meter=1000.0)
    stream.log("world/camera/picture/depth", far, strict=True)
    steps = rollout.frame_steps()
    first, rows = steps[max(number - 1, 0)], rollout.contacts
    now = rows[(rows["step"] > first) & (rows["step"] <= steps[number])]
    pushes = now["normal"] * now["impulse"][:, None]
    stream.log("world/contacts", rr.Arrows3D(vectors=pushes, origins=now["point"]), strict=True)
    for name, vertices in rollout.vertices:
        path = rr.new_entity_path(["world", "things", name])
        deformed = rr.Mesh3D.from_fields(vertex_positions=vertices[min(number, len(vertices) - 1)])
        stream.log(path, deformed, strict=True)
