"""The exported folder: complete, consistent with itself, and careful with other folders."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange import export_motion_prior
from physagent_studio.program.text.document import load_program
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.rendering import Compositor, flow_between, frame_of, normals_of
from physagent_studio.rendering.backdrop import PALETTE
from tests.exchange.prior.conftest import Parts

FRAMES = 4


def test_everything_is_there_and_agrees(parts: Parts, tmp_path: Path):
    scene, rollout, program = parts
    told: list[float] = []
    folder = export_motion_prior(tmp_path / "a" / "prior", *parts, 25, progress=told.append)
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    wanted = [
        "captions.json",
        "meta.json",
        "program.yaml",
        "rollout.npz",
        "scene.glb",
        "tracks.npz",
    ]
    wanted += [f"{kind}.mp4" for kind in ("depth", "flow", "masks", "video")]
    wanted += ["depth/background.npz"]
    for t in range(FRAMES):
        wanted += [f"frames/frame_{t:04d}.png", f"ids/ids_{t:04d}.png"]
        wanted += [f"depth/depth_{t:04d}.png", f"depth/depth_{t:04d}.npz"]
        wanted += [f"normals/normals_{t:04d}.png"]
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
    back = flow_between(second, first)
    assert np.array_equal(saved["backward"], back.vectors)
    assert np.array_equal(saved["backward_visible"], back.visible)

    meta = json.loads((folder / "meta.json").read_text())
    assert meta["objects"] == ["ball", "crate"]
    assert meta["made_from"]["program"] == program.hash
    assert set(meta["sha256"]) == set(names) - {"meta.json"}
    for name, found in meta["sha256"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == found, name
    timing = {"simulated_seconds": program.clip.seconds, "playback_fps": meta["fps"]}
    timing["time_factor"] = meta["seconds_per_frame"] * meta["fps"]
    assert {name: meta[name] for name in timing} == pytest.approx(timing)
    assert load_program((folder / "program.yaml").read_text()).hash == program.hash
    assert np.array_equal(
        rollout_from_bytes((folder / "rollout.npz").read_bytes()).positions, rollout.positions
    )


def test_the_videos_show_what_the_files_say(parts: Parts, tmp_path: Path):
    folder = export_motion_prior(tmp_path / "prior", *parts, 25)
    videos = {}
    for name in ("video", "masks", "depth", "flow"):
        with av.open(str(folder / f"{name}.mp4")) as container:
            videos[name] = [f.to_ndarray(format="rgb24") for f in container.decode(video=0)]
    assert [len(one) for one in videos.values()] == [FRAMES, FRAMES, FRAMES, FRAMES - 1]
    for number in range(FRAMES):
        rgb, ids = (
            cv2.imread(str(folder / f"{stem}_{number:04d}.png"), cv2.IMREAD_UNCHANGED)
            for stem in ("frames/frame", "ids/ids")
        )
        assert rgb is not None
        assert ids is not None
        assert np.abs(videos["video"][number].astype(int) - rgb[..., ::-1]).mean() < 4
        # Away from outlines, where half as many colours as pixels are kept.
        for index in range(3):
            inner = cv2.erode((ids == index).astype(np.uint8), np.ones((5, 5))) > 0
            wanted = (0, 0, 0) if index == 0 else PALETTE[index - 1]
            assert np.abs(videos["masks"][number][inner] - np.array(wanted)).mean() < 12
        depth = np.load(folder / f"depth/depth_{number:04d}.npz")["depth"]
        inner = cv2.erode((ids > 0).astype(np.uint8), np.ones((5, 5))) > 0
        grey = videos["depth"][number][..., 1][inner].astype(float)
        product = grey * depth[inner]
        assert product.std() / product.mean() < 0.05
    for number, picture in enumerate(videos["flow"]):
        moving = np.load(folder / f"flow/flow_{number:04d}.npz")["flow"].any(-1)
        still = cv2.dilate(moving.astype(np.uint8), np.ones((9, 9))) == 0
        assert picture[still].min() > 245
        assert picture[cv2.erode(moving.astype(np.uint8), np.ones((9, 9))) > 0].min(-1).max() < 230


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


def test_normals_depth_of_the_ground_and_tracks(parts: Parts, tmp_path: Path):
    scene, rollout, _ = parts
    folder = export_motion_prior(tmp_path / "prior", *parts, 25)
    camera = scene.state.camera
    assert camera is not None
    frame = frame_of(Compositor(scene), rollout, 2)
    # Of a ball, the normal is the way from its middle to what is seen.
    y, x = np.nonzero(frame.ids == 0)
    pixels = np.stack([x + 0.5, y + 0.5], 1).astype(np.float64)
    points = np.asarray(camera.position) + camera.rays(pixels) * frame.depth[y, x, None]
    outward = (points - rollout.positions[rollout.frame_steps()[2], 0]) / 0.25
    hits = frame.surface.hits
    own = hits.face[frame.ids.ravel()[hits.pixel] == 0]
    found = normals_of(frame)[own] @ camera.matrix.T
    assert (found * outward).sum(1).min() > 0.99
    picture = cv2.imread(str(folder / "normals/normals_0002.png"))
    assert picture is not None
    shown = picture[y, x, ::-1] / 127.5 - 1
    assert np.abs(shown * (1, -1, -1) @ camera.matrix.T - found).max() < 0.01
    ground = np.load(folder / "depth/background.npz")["depth"]
    row, column = 100, 30
    ray = camera.rays(np.array([[column + 0.5, row + 0.5]]))[0]
    assert ground[row, column] == pytest.approx(-camera.position[2] / ray[2], rel=1e-5)

    tracks = np.load(folder / "tracks.npz")
    assert set(tracks["object"]) == {0, 1}
    moved = tracks["world"][-1] - tracks["world"][0]
    assert np.allclose(moved[tracks["object"] == 0], (0.4, 0, 0), atol=1e-5)
    assert np.allclose(moved[tracks["object"] == 1], 0, atol=1e-6)
    for t in range(FRAMES):
        told = camera.project(tracks["world"][t].astype(float))[0]
        assert np.abs(told - tracks["pixels"][t]).max() < 1e-3
    assert tracks["visible"][0].all()


def test_a_motionless_program_gives_the_same_frame_81_times(parts: Parts, tmp_path: Path):
    scene, rollout, program = parts
    still = replace(
        rollout,
        frames=81,
        positions=np.repeat(rollout.positions[:1], 80 * rollout.steps_per_frame + 1, 0),
        rotations=np.repeat(rollout.rotations[:1], 80 * rollout.steps_per_frame + 1, 0),
        velocities=np.zeros((80 * rollout.steps_per_frame + 1, *rollout.velocities.shape[1:])),
        vertices=(),
    )
    folder = export_motion_prior(tmp_path / "prior", scene, still, program, 25)
    assert len({one.read_bytes() for one in (folder / "frames").iterdir()}) == 1
    assert len(list((folder / "frames").iterdir())) == 81
    assert not any(np.load(one)["flow"].any() for one in (folder / "flow").iterdir())
