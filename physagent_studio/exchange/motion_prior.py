"""Exports a rollout as a motion prior: what a video generator is conditioned on.

video.mp4  flow.mp4  program.yaml  rollout.npz  scene.glb  meta.json
frames/frame_0000.png   the rendered picture
ids/ids_0000.png        8 or 16 bit: 0 background, 1 + index of the object
depth/depth_0000.png    16 bit, millimetres, 0 none or beyond 65.5 m
depth/depth_0000.npz    `depth` (H, W) float32, m along the optical axis, inf background
flow/flow_0000.npz      `flow` (H, W, 2) float32, pixels, (x, y), to the next frame;
                        `visible` (H, W) bool, whether it is still seen there
"""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio import __version__
from physagent_studio.errors import InputError
from physagent_studio.exchange.animation import write_glb
from physagent_studio.exchange.files import written
from physagent_studio.exchange.flow_colors import flow_picture
from physagent_studio.exchange.video import write_video
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.text.document import dump_program
from physagent_studio.program.timing import timing_of
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import save_rollout
from physagent_studio.records.scene import Scene
from physagent_studio.rendering import Flow, Frame, flow_between, render_clip

META = "meta.json"
_MARK = "physagent motion prior"
_FORMAT = 3
_OPENING = ".started.json"


def export_motion_prior(
    folder: Path | str,
    scene: Scene,
    rollout: Rollout,
    program: PhysicalProgram,
    fps: float,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write a motion prior; returns its folder.

    The folder is new, empty or an earlier export: one that was broken off is written anew,
    one of the same scene, program and rate is left as it is.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        Cancelled: `cancelled` said so; what was written stays and is taken over next time.
    """
    folder = Path(folder)
    key = {"scene": scene.hash, "program": program.hash, "rollout": rollout.program_hash}
    key = {**key, "fps": fps, "format": _FORMAT, "version": __version__}
    if _finished(folder, key):
        return folder
    _open(folder, key)
    with written(folder / "program.yaml") as path:
        path.write_text(dump_program(program), encoding="utf-8")
    with written(folder / "rollout.npz") as path:
        save_rollout(path, rollout)
    write_glb(folder / "scene.glb", scene, rollout, fps)
    clip = render_clip(scene, rollout, cancelled=cancelled, progress=progress)
    flows: list[NDArray[np.float32]] = []
    timing = timing_of(program.clip.model_copy(update={"playback_fps": fps}))
    write_video(folder / "video.mp4", _pictures(folder, clip, flows), fps, timing)
    fastest = max((float(np.linalg.norm(f, axis=-1).max()) for f in flows), default=0.0)
    if flows:
        pictures = (flow_picture(f, fastest) for f in flows)
        write_video(folder / "flow.mp4", pictures, fps, timing)
    meta = _meta(scene, rollout, program, fps, key, fastest)
    _write_json(folder / META, meta | timing)
    (folder / _OPENING).unlink(missing_ok=True)
    return folder


def _finished(folder: Path, key: dict[str, Any]) -> bool:
    meta = _read_json(folder / META)
    return meta is not None and meta.get("kind") == _MARK and meta.get("made_from") == key


def _open(folder: Path, key: dict[str, Any]) -> None:
    """Make the folder, or take over an earlier export; anything else is left alone."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        ours = any((_read_json(folder / n) or {}).get("kind") == _MARK for n in (META, _OPENING))
        if not ours and any(folder.iterdir()):
            raise InputError(f"{folder} is not empty and is no earlier export; name a new folder")
        _write_json(folder / _OPENING, {"kind": _MARK, "made_from": key})
        (folder / META).unlink(missing_ok=True)
        for part in ("frames", "ids", "depth", "flow"):
            (folder / part).mkdir(exist_ok=True)
            for old in (folder / part).iterdir():
                old.unlink()
    except OSError as error:
        raise InputError(f"{folder} cannot be written ({error.strerror})") from error


def _pictures(
    folder: Path, clip: Iterator[Frame], flows: list[NDArray[np.float32]]
) -> Iterator[NDArray[np.uint8]]:
    """Each frame's picture, once its files are written."""
    previous: Frame | None = None
    for number, frame in enumerate(clip):
        if previous is not None:
            flow = flow_between(previous, frame)
            flows.append(flow.vectors)
            _write_flow(folder / "flow" / f"flow_{number - 1:04d}.npz", flow)
        _write_frame(folder, number, frame)
        previous = frame
        yield frame.rgb


def _write_frame(folder: Path, number: int, frame: Frame) -> None:
    _write_png(folder / "frames" / f"frame_{number:04d}.png", frame.rgb[..., ::-1])
    marks = (frame.ids.astype(np.int32) + 1).astype(np.uint8 if frame.ids.max() < 255 else "uint16")
    _write_png(folder / "ids" / f"ids_{number:04d}.png", marks)
    millimetres = np.where(np.isfinite(frame.depth), frame.depth * 1000, 0)
    near = np.where(millimetres < 65535.5, millimetres, 0).round().astype(np.uint16)
    _write_png(folder / "depth" / f"depth_{number:04d}.png", near)
    with written(folder / "depth" / f"depth_{number:04d}.npz") as path:
        np.savez_compressed(path, depth=frame.depth)


def _write_flow(path: Path, flow: Flow) -> None:
    with written(path) as partial:
        np.savez_compressed(partial, flow=flow.vectors, visible=flow.visible)


def _write_png(path: Path, picture: NDArray[Any]) -> None:
    done, data = cv2.imencode(".png", picture)
    if not done:
        raise InputError(f"{path.name} cannot be encoded as a PNG")
    with written(path) as partial:
        partial.write_bytes(data.tobytes())


def _write_json(path: Path, data: dict[str, Any]) -> None:
    with written(path) as partial:
        partial.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


def _read_json(path: Path) -> dict[str, Any] | None:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return data if isinstance(data, dict) else None


def _meta(
    scene: Scene,
    rollout: Rollout,
    program: PhysicalProgram,
    fps: float,
    key: dict[str, Any],
    fastest: float,
) -> dict[str, Any]:
    camera = scene.state.camera
    assert camera is not None
    packages = ("numpy", "opencv-python-headless", "av")
    return {
        "kind": _MARK,
        "made_from": key,
        "prompt": program.event.prompt,
        "objects": list(rollout.objects),
        "frames": rollout.frames,
        "size": list(camera.size),
        "fps": fps,
        "seconds_per_frame": rollout.step_seconds * rollout.steps_per_frame,
        "camera": {
            "intrinsics": camera.intrinsics.tolist(),
            "position": list(camera.position),
            "rotation_world_camera_wxyz": list(camera.rotation),
        },
        "units": {
            "flow": "pixels (x, y), frame t to t + 1",
            "depth": "metres along the optical axis (png: millimetres)",
            "ids": "0 background, 1 + index into objects",
            "world": "metres, x right, y away from the camera, z up",
        },
        "fastest_flow": fastest,
        "versions": {
            **dict(rollout.versions),
            **{name: importlib.metadata.version(name) for name in packages},
            "physagent-studio": __version__,
        },
    }
