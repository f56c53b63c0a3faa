"""Exports a rollout as a motion prior: what a video generator is conditioned on.

video.mp4  flow.mp4  depth.mp4  masks.mp4  program.yaml  rollout.npz  scene.glb  meta.json
frames/frame_0000.png   the rendered picture
ids/ids_0000.png        8 or 16 bit: 0 background, 1 + index of the object
depth/depth_0000.png    16 bit, millimetres, 0 none or beyond 65.5 m
depth/depth_0000.npz    `depth` (H, W) float32, m along the optical axis, inf background
depth/background.npz    the same of supports and ground, without the objects
normals/normals_0000.png  8 bit RGB, (n + 1) · 127.5: x right, y up, z to the camera; 0 background
flow/flow_0000.npz      `flow` (H, W, 2) float32, pixels, (x, y), to the next frame;
                        `visible` (H, W) bool, whether it is still seen there (not: occluded);
                        `backward`, `backward_visible`: from the next frame to this one
captions.json           what happens, per twenty frames
tracks.npz              `pixels` (T, N, 2), `world` (T, N, 3), `visible` (T, N), `object` (N,)
"""

import importlib.metadata
import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio import __version__
from physagent_studio.errors import InputError
from physagent_studio.exchange.animation import write_glb
from physagent_studio.exchange.files import written
from physagent_studio.exchange.prior.captions import captions
from physagent_studio.exchange.prior.stretches import Sink
from physagent_studio.exchange.video import VideoFile
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.text.document import dump_program
from physagent_studio.program.timing import timing_of
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.rollout_io import save_rollout
from physagent_studio.records.scene import Scene
from physagent_studio.rendering import (
    Compositor,
    Frame,
    Tracked,
    Tracks,
    flow_between,
    normals_of,
    render_clip,
)
from physagent_studio.rendering.backdrop import PALETTE

META = "meta.json"
MARK = "physagent motion prior"
FORMAT = 5
OPENING = ".started.json"
PARTS = ("frames", "ids", "depth", "flow", "normals")
FULL_COLOUR = 0.04
"""Motion from frame to frame that is shown in full colour, in the picture's width: the fastest that
a viewer follows."""
TRACK_SPACING = 12
"""Pixels between the points that are tracked."""
NEAREST = 0.8
"""Share of the first frame's least depth that is white in the depth video."""


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
    """Write a motion prior in one pass over its frames; returns its folder.

    The folder is new, empty or an earlier export: one that was broken off is written anew,
    one of the same scene, program and rate is left as it is.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        Cancelled: `cancelled` said so; what was written stays and is taken over next time.
    """
    folder = Path(folder)
    key = {"scene": scene.hash, "program": program.hash, "rollout": rollout.program_hash}
    key = {**key, "fps": fps, "format": FORMAT, "version": __version__}
    done = _read_json(folder / META) or {}
    if done.get("kind") == MARK and done.get("made_from") == key:
        return folder
    _open(folder, key)
    sink = Sink(folder)
    sink.text("program.yaml", dump_program(program))
    with written(folder / "rollout.npz") as path:
        save_rollout(path, rollout)
    write_glb(folder / "scene.glb", scene, rollout, fps)
    timing = timing_of(program.clip.model_copy(update={"playback_fps": fps}))
    compositor = Compositor(scene)
    with ExitStack() as stack:
        videos = {
            name: stack.enter_context(VideoFile(folder / f"{name}.mp4", fps, timing, fast=fast))
            for name, fast in (("video", False), ("flow", True), ("depth", True), ("masks", True))
        }
        writer = _Writer(sink, videos, compositor.background_depth)
        clip = render_clip(
            scene, rollout, cancelled=cancelled, progress=progress, compositor=compositor
        )
        tracked = list(_followed(scene, writer.passed(clip)))
    _write_tracks(sink, tracked)
    sink.json("captions.json", captions(rollout))
    for name in ("rollout.npz", "scene.glb", *(f"{name}.mp4" for name in videos)):
        if (folder / name).is_file():
            sink.adopt(name)
    meta = _meta(scene, rollout, program, fps, key, writer.fastest) | timing
    sink.json(META, meta | {"sha256": dict(sorted(sink.hashes.items()))})
    (folder / OPENING).unlink(missing_ok=True)
    return folder


@dataclass(eq=False, slots=True)
class _Writer:
    """Writes frames as they come; of the clip it keeps one frame, and how fast anything was."""

    sink: Sink
    videos: dict[str, VideoFile]
    background: NDArray[np.float32]
    fastest: float = 0.0
    nearest: float = 1.0
    behind: NDArray[np.uint8] | None = None

    def passed(self, clip: Iterator[Frame]) -> Iterator[Frame]:
        """The frames, each once its files are written."""
        self.sink.npz("depth/background.npz", depth=self.background)
        previous: Frame | None = None
        for number, frame in enumerate(clip):
            if previous is not None:
                self._flow(number - 1, previous, frame)
            self._frame(number, frame)
            previous = frame
            yield frame

    def _flow(self, number: int, frame: Frame, following: Frame) -> None:
        ahead, back = flow_between(frame, following), flow_between(following, frame)
        self.sink.npz(
            f"flow/flow_{number:04d}.npz",
            flow=ahead.vectors,
            visible=ahead.visible,
            backward=back.vectors,
            backward_visible=back.visible,
        )
        # Both numbers of a vector are looked at as one.
        moving = np.flatnonzero(np.ascontiguousarray(ahead.vectors).view(np.int64))
        x, y = ahead.vectors.reshape(-1, 2).take(moving, 0).T
        self.fastest = max(self.fastest, float(np.sqrt((x * x + y * y).max(initial=0))))
        full = FULL_COLOUR * frame.ids.shape[1]
        self.videos["flow"].add(flow_picture(ahead.vectors, full, moving))

    def _frame(self, number: int, frame: Frame) -> None:
        sink, hits = self.sink, frame.surface.hits
        sink.png(f"frames/frame_{number:04d}.png", frame.rgb)
        kind = np.uint8 if frame.ids.max(initial=0) < 255 else np.uint16
        sink.png(f"ids/ids_{number:04d}.png", (frame.ids + 1).astype(kind))
        millimetres = np.zeros(frame.ids.shape, np.uint16)
        near = np.round(hits.depth * 1000)
        millimetres.ravel()[hits.pixel] = np.where(near < 65535.5, near, 0)
        sink.png(f"depth/depth_{number:04d}.png", millimetres)
        sink.npz(f"depth/depth_{number:04d}.npz", depth=frame.depth)
        sink.png(f"normals/normals_{number:04d}.png", _normal_picture(frame))
        self.videos["video"].add(frame.rgb)
        self.videos["masks"].add(_mask_picture(frame))
        self.videos["depth"].add(self._depth_picture(frame))

    def _depth_picture(self, frame: Frame) -> NDArray[np.uint8]:
        """(H, W) of depths: white is near, by its reciprocal, black is far away."""
        if self.behind is None:
            self.nearest = nearest_shown(frame.depth, self.background)
            self.behind = nearness(self.nearest, self.background)
        picture, hits = self.behind.copy(), frame.surface.hits
        picture.ravel()[hits.pixel] = nearness(self.nearest, hits.depth)
        return picture


def nearest_shown(depth: NDArray[np.float32], background: NDArray[np.float32]) -> float:
    """The depth that is white in a clip's depth video, m; both are of its first frame."""
    near = float(np.minimum(depth, background).min())
    return NEAREST * near if np.isfinite(near) else 1.0


def nearness(nearest: float, depth: NDArray[Any]) -> NDArray[np.uint8]:
    """Grey levels of depths, by their reciprocal: white is near, black is far away."""
    return (255 * np.clip(nearest / np.maximum(depth, 1e-6), 0, 1)).astype(np.uint8)


def _followed(scene: Scene, clip: Iterator[Frame]) -> Iterator[tuple[Tracks, Tracked]]:
    """The points chosen in the first frame, and where they are in each."""
    camera = scene.state.camera
    assert camera is not None
    tracks: Tracks | None = None
    for frame in clip:
        tracks = Tracks.seeded(frame, TRACK_SPACING) if tracks is None else tracks
        yield tracks, tracks.at(frame, camera)


def _write_tracks(sink: Sink, tracked: list[tuple[Tracks, Tracked]]) -> None:
    if not tracked:
        return
    sink.npz(
        "tracks.npz",
        pixels=np.stack([one.pixels for _, one in tracked]),
        world=np.stack([one.world for _, one in tracked]),
        visible=np.stack([one.visible for _, one in tracked]),
        object=tracked[0][0].owner,
    )


def _normal_picture(frame: Frame) -> NDArray[np.uint8]:
    """(H, W, 3) of unit normals, x right, y up, z to the camera; 0 on the background."""
    hits, picture = frame.surface.hits, np.zeros((frame.ids.size, 3), np.uint8)
    normals = normals_of(frame) * np.array([1.0, -1.0, -1.0], np.float32)
    colours = np.clip((normals + 1) * 127.5 + 0.5, 0, 255).astype(np.uint8)
    picture[hits.pixel] = colours[hits.face]
    return picture.reshape(*frame.ids.shape, 3)


def _mask_picture(frame: Frame) -> NDArray[np.uint8]:
    """(H, W, 3) each object in its colour on black."""
    hits, picture = frame.surface.hits, np.zeros((frame.ids.size, 3), np.uint8)
    owner = frame.ids.ravel()[hits.pixel]
    picture[hits.pixel] = np.array(PALETTE, np.uint8)[owner % len(PALETTE)]
    return picture.reshape(*frame.ids.shape, 3)


def made_from(folder: Path) -> dict[str, Any] | None:
    """What the export in a folder was made of, finished or not; None where there is none."""
    said = [_read_json(folder / name) or {} for name in (META, OPENING)]
    return next((one.get("made_from", {}) for one in said if one.get("kind") == MARK), None)


def _open(folder: Path, key: dict[str, Any]) -> None:
    """Make the folder, or take over an earlier export; anything else is left alone."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if made_from(folder) is None and any(folder.iterdir()):
            raise InputError(f"{folder} is not empty and is no earlier export; name a new folder")
        Sink(folder).json(OPENING, {"kind": MARK, "made_from": key})
        (folder / META).unlink(missing_ok=True)
        for part in PARTS:
            (folder / part).mkdir(exist_ok=True)
            for old in (folder / part).iterdir():
                old.unlink()
    except OSError as error:
        raise InputError(f"{folder} cannot be written ({error.strerror})") from error


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
        "kind": MARK,
        "convention": (
            "Pixel (i, j) has its centre at (i + .5, j + .5); the camera looks along z with x "
            "right and y down; the world is in metres with x right, y away and z up."
        ),
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
            "flow": "pixels (x, y), frame t to t + 1; backward from t + 1 to t",
            "visible": "whether what the pixel shows is seen in the other frame (else occluded)",
            "depth": "metres along the optical axis (png: millimetres)",
            "ids": "0 background, 1 + index into objects",
            "normals": "8 bit RGB, (n + 1) * 127.5: x right, y up, z to the camera",
        },
        "fastest_flow": fastest,
        "flow_in_full_colour": FULL_COLOUR * camera.size[0],
        "versions": {
            **dict(rollout.versions),
            **{name: importlib.metadata.version(name) for name in packages},
            "physagent-studio": __version__,
        },
    }


def flow_picture(
    vectors: NDArray[np.float32], fastest: float, moving: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB of vectors (H, W, 2), pixels; white stands still.

    fastest: length in pixels that is shown in full colour. moving: (K,) rows of vectors that are
    not zero.
    """
    height, width = vectors.shape[:2]
    picture = np.full((height * width, 3), 255, np.uint8)
    if len(moving):
        x, y = vectors.reshape(-1, 2).take(moving, 0).T
        length, angle = cv2.cartToPolar(x, y)
        # The square root keeps slow motion visible beside fast.
        share = np.clip(np.sqrt(length / max(fastest, 1e-6)), 0, 1)
        hue = (angle * (90 / np.pi)).astype(np.int64) % 180
        hsv = np.column_stack([hue, 255 * share, 255 - np.floor(55 * share)]).astype(np.uint8)
        picture[moving] = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB)[0]
    return picture.reshape(height, width, 3)
