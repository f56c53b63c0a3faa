"""The exported folder: complete, consistent with itself, and careful with other folders."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange import export_motion_prior
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Rollout, Scene
from physagent_studio.records.rollout_io import load_rollout
from physagent_studio.rendering import Compositor, flow_between, frame_of
from physagent_studio.rendering.compositor import initial_poses
from tests.rendering.scenes import FLOOR, ball, crate, rollout_of, scene_of

FRAMES = 4
Parts = tuple[Scene, Rollout, PhysicalProgram]


@pytest.fixture
def parts() -> Parts:
    first, first_mesh = ball()
    second, second_mesh = crate()
    scene = scene_of([first, second], {"ball": first_mesh, "crate": second_mesh}, [FLOOR])
    positions, rotations = initial_poses(scene)
    moved = np.repeat(positions[None], FRAMES, 0)
    moved[:, 0, 0] += np.linspace(0, 0.4, FRAMES)
    rollout = rollout_of(("ball", "crate"), moved, np.repeat(rotations[None], FRAMES, 0))
    return scene, rollout, PhysicalProgram(scene=scene.state)


def test_everything_is_there_and_agrees(parts: Parts, tmp_path: Path):
    scene, rollout, program = parts
    told: list[float] = []
    folder = export_motion_prior(tmp_path / "a" / "prior", *parts, 25, progress=told.append)
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    wanted = ["flow.mp4", "meta.json", "program.yaml", "rollout.npz", "scene.glb", "video.mp4"]
    for t in range(FRAMES):
        wanted += [f"frames/frame_{t:04d}.png", f"ids/ids_{t:04d}.png"]
        wanted += [f"depth/depth_{t:04d}.png", f"depth/depth_{t:04d}.npz"]
    wanted += [f"flow/flow_{t:04d}.npz" for t in range(FRAMES - 1)]
    assert names == sorted(wanted)
    assert told[-1] == 1

    compositor = Compositor(scene)
    first, second = (frame_of(compositor, rollout, t) for t in (1, 2))
    picture = cv2.imread(str(folder / "frames/frame_0001.png"))
    assert picture is not None
    assert np.array_equal(picture[..., ::-1], first.rgb)
    ids = cv2.imread(str(folder / "ids/ids_0001.png"), cv2.IMREAD_UNCHANGED)
    assert ids is not None
    assert np.array_equal(ids.astype(int) - 1, first.ids)
    depth = np.load(folder / "depth/depth_0001.npz")["depth"]
    assert np.array_equal(depth, first.depth)
    millimetres = cv2.imread(str(folder / "depth/depth_0001.png"), cv2.IMREAD_UNCHANGED)
    assert millimetres is not None
    seen = first.ids >= 0
    assert np.abs(millimetres[seen] - depth[seen] * 1000).max() <= 0.51
    assert (millimetres[~seen] == 0).all()
    saved = np.load(folder / "flow/flow_0001.npz")
    flow = flow_between(first, second)
    assert np.array_equal(saved["flow"], flow.vectors)
    assert np.array_equal(saved["visible"], flow.visible)

    meta = json.loads((folder / "meta.json").read_text())
    assert meta["objects"] == ["ball", "crate"]
    assert meta["made_from"]["program"] == program.hash
    timing = {"simulated_seconds": program.clip.seconds, "playback_fps": meta["fps"]}
    timing["time_factor"] = meta["seconds_per_frame"] * meta["fps"]
    assert {name: meta[name] for name in timing} == pytest.approx(timing)
    assert load_program((folder / "program.yaml").read_text()).hash == program.hash
    assert np.array_equal(load_rollout(folder / "rollout.npz").positions, rollout.positions)


def test_finished_export_is_left_and_a_broken_one_written_anew(parts: Parts, tmp_path: Path):
    folder = tmp_path / "prior"
    seen: list[float] = []
    with pytest.raises(Cancelled):
        export_motion_prior(
            folder, *parts, 25, cancelled=lambda: len(seen) == 2, progress=seen.append
        )
    assert not (folder / "meta.json").exists()
    assert not (folder / "video.mp4").exists()
    export_motion_prior(folder, *parts, 25)
    before = (folder / "video.mp4").stat().st_mtime_ns
    export_motion_prior(folder, *parts, 25)
    assert (folder / "video.mp4").stat().st_mtime_ns == before
    export_motion_prior(folder, *parts, 10)
    assert json.loads((folder / "meta.json").read_text())["fps"] == 10


def test_other_folders_are_left_alone(parts: Parts, tmp_path: Path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("keep")
    with pytest.raises(InputError, match="is not empty"):
        export_motion_prior(tmp_path / "mine", *parts, 25)
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    with pytest.raises(InputError, match="cannot be written"):
        export_motion_prior(tmp_path / "mine" / "notes.txt" / "deep", *parts, 25)
