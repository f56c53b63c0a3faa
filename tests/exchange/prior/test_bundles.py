"""What a prior is rewritten as, read by others' readers and compared."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import av
import cv2
import numpy as np
import pyarrow.parquet
import pytest
import yaml

from physagent_studio.errors import BackendMissing, Cancelled, InputError
from physagent_studio.exchange import (
    BUNDLES,
    Prior,
    export_motion_prior,
    load_peer_config,
    write_bundles,
)
from physagent_studio.exchange.prior.export import nearest_shown
from physagent_studio.exchange.prior.generators import _masks
from physagent_studio.simulation.mj import mj
from tests.exchange.prior.conftest import FRAMES, Parts


@pytest.fixture
def prior(parts: Parts, tmp_path: Path) -> Prior:
    return Prior.open(export_motion_prior(tmp_path / "prior", *parts, 16))


def test_flow_files(prior: Prior):
    write_bundles(prior.folder, ["flo", "kitti"])
    for number in range(FRAMES - 1):
        for way, flow in (("forward", prior.flow(number)), ("backward", prior.backward(number))):
            found = cv2.readOpticalFlow(str(prior.folder / f"flo/{way}_{number:04d}.flo"))
            assert np.array_equal(found, flow.vectors)
            # As KITTI's development kit decodes it.
            coded = cv2.imread(
                str(prior.folder / f"kitti/{way}_{number:04d}.png"), cv2.IMREAD_UNCHANGED
            )
            assert coded is not None
            valid = coded[..., 0] > 0
            told = (coded[..., [2, 1]].astype(float) - 2**15) / 64
            assert np.array_equal(valid, flow.visible)
            assert np.abs(told - flow.vectors)[valid].max() <= 1 / 128 + 1e-4


def test_tables(prior: Prior):
    write_bundles(prior.folder, ["csv", "parquet"])
    rollout = prior.rollout()
    with open(prior.folder / "csv/trajectories.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    table = pyarrow.parquet.read_table(prior.folder / "parquet/trajectories.parquet").to_pylist()
    assert len(rows) == len(table) == rollout.positions[..., 0].size
    for row, same in zip(rows, table, strict=True):
        step, index = int(row["step"]), rollout.objects.index(row["object"])
        place = [float(row[axis]) for axis in "xyz"]
        assert place == list(rollout.positions[step, index])
        assert place == [same[axis] for axis in "xyz"]
        assert float(row["time"]) == step * rollout.step_seconds


def test_parquet_without_its_package(prior: Prior, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(BackendMissing, match="tables"):
        write_bundles(prior.folder, ["parquet"])


def test_mujoco_shows_every_frame_as_it_was(prior: Prior):
    write_bundles(prior.folder, ["mjcf"])
    model = mj.MjModel.from_xml_path(str(prior.folder / "mjcf/scene.xml"))
    rollout = prior.rollout()
    assert model.nkey == FRAMES
    assert model.opt.gravity.tolist() == [0, 0, -9.81]
    data = mj.MjData(model)
    for number, step in enumerate(rollout.frame_steps()):
        mj.mj_resetDataKeyframe(model, data, number)
        mj.mj_forward(model, data)
        for index, name in enumerate(rollout.objects):
            body = data.body(name)
            assert np.allclose(body.xpos, rollout.positions[step, index], atol=1e-12)
            assert model.body(name).mass[0] == pytest.approx(rollout.masses[index])
    # Its camera sees the first object where the photo shows it.
    camera = data.camera("photo")
    seen = camera.xmat.reshape(3, 3).T @ (rollout.positions[-1, 0] - camera.xpos)
    half = np.tan(np.radians(model.camera("photo").fovy[0]) / 2)
    right, up = seen[:2] / -seen[2] * prior.size[1] / 2 / half
    x, y = prior.size[0] / 2 + right, prior.size[1] / 2 - up
    own = np.argwhere(prior.ids(FRAMES - 1) == 0)
    assert np.hypot(*(own.mean(0)[::-1] + 0.5 - (x, y))) < 4


def frames_of(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_a_configuration_that_is_read_back(prior: Prior):
    write_bundles(prior.folder, ["peer-config"])
    setup = load_peer_config(prior.folder / "peer-config/config.yaml", names=["ball", "crate"])
    assert setup.left_out == ()
    assert setup.case.image is not None
    assert np.array_equal(setup.case.image, prior.picture(0))
    assert setup.clip == {"frames": 81, "step_seconds": 0.01, "steps_per_frame": 4, "substeps": 10}
    for index, (_, grounding) in enumerate(setup.case.objects):
        (point,) = grounding.points
        # Nobody has clicked: it lies on the thing as the first picture shows it.
        assert prior.ids(0)[int(point.y), int(point.x)] == index


def test_what_realwonder_reads(prior: Prior):
    (said,) = write_bundles(prior.folder, ["final-sim"])
    out = prior.folder / "final-sim"
    frames = sorted((out / "frames").glob("frame_*.png"))
    assert [path.name for path in frames] == [f"frame_{n:04d}.png" for n in range(81)]
    first = cv2.imread(str(frames[0]))
    assert first is not None
    assert first.shape == (480, 832, 3)
    shown = cv2.imread(str(out / "resized_input_image.png"))
    assert shown is not None
    assert np.array_equal(first, shown)
    noise = np.load(out / "noises.npy")
    assert noise.shape == (81, 60, 104, 32)
    assert noise.dtype == np.float16
    # Their mesh masks are of a robot's arm: none is here, and theirs skips what is empty.
    assert not np.load(out / "mesh_masks_downsampled.npz")["masks"].any()
    masks = np.load(out / "points_masks_downsampled.npz")["masks"]
    assert masks.shape == (21, 60, 104)
    assert masks.dtype == bool
    assert ".pt" in said
    # The ball that moves is in the masks, the crate that stands is not.
    seen = masks.any(0)
    crate = np.argwhere(prior.ids(0) == 1) * 4 // 8
    middle = crate.mean(0).astype(int)
    assert seen.any()
    assert not masks[0][middle[0], middle[1]]
    # The last is of the last frame alone; a cell counts where half of it is covered.
    last = np.where(prior.ids(FRAMES - 1) == 0, 255, 0).astype(np.uint8)
    shown = cv2.resize(last, (104, 60), interpolation=cv2.INTER_AREA) > 127
    assert np.count_nonzero(shown & masks[-1]) > 0.8 * np.count_nonzero(shown | masks[-1])
    config = yaml.safe_load((out / "config.yaml").read_text())
    assert config["num_output_frames"] == 21
    assert config["denoising_step_list"][0] < 1000
    assert config["mask_dropin_step"] == -1
    assert len(frames_of(out / "simulation.mp4")) == 81


def test_masks_are_torch_files_where_torch_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    torch = SimpleNamespace(from_numpy=np.array, save=lambda one, path: np.save(f"{path}.npy", one))
    monkeypatch.setitem(sys.modules, "torch", torch)
    masks = np.arange(24).reshape(2, 3, 4) % 3 == 0
    assert "npz" not in _masks(tmp_path, "points", masks)
    assert np.array_equal(np.load(tmp_path / "points.pt.npy"), masks)


def test_control_inputs(prior: Prior):
    write_bundles(prior.folder, ["wan-vace", "wan-fun", "go-with-the-flow"])
    vace = prior.folder / "wan-vace"
    masks = [cv2.imread(str(p), cv2.IMREAD_UNCHANGED) for p in sorted((vace / "mask").iterdir())]
    assert len(masks) == len(list((vace / "video").iterdir())) == 81
    assert all(mask is not None and set(np.unique(mask)) <= {0, 255} for mask in masks)
    assert not np.any(masks[0])
    assert np.any(masks[-1])
    assert json.loads((vace / "manifest.json").read_text())["fps"] == 16
    control = frames_of(prior.folder / "wan-fun/control_depth.mp4")
    assert len(control) == 81
    assert control[0].shape == (480, 832, 3)
    # White is near, by the reciprocal of depth: 208 × 120 is four times as large there.
    depth = np.minimum(prior.depth(0), np.load(prior.folder / "depth/background.npz")["depth"])
    wanted = np.clip(255 * nearest_shown(prior.depth(0), depth) / depth, 0, 255)
    shown = cv2.resize(control[0][..., 0], (208, 120), interpolation=cv2.INTER_AREA)
    assert np.abs(shown - wanted).mean() < 3
    for index, video in ((0, "input.mp4"), (48, "input.mp4")):
        own = frames_of(prior.folder / "go-with-the-flow" / video)[index].astype(float)
        # 720 × 480 is a crop of the 832 × 480 that 208 × 120 becomes.
        large = cv2.resize(prior.picture(index * 3 // 48), (832, 480))[:, 56:776]
        assert np.abs(own - large).mean() < 4
    gwtf = prior.folder / "go-with-the-flow"
    assert np.load(gwtf / "noises.npy").shape == (49, 60, 90, 16)
    assert len(frames_of(gwtf / "input.mp4")) == 49
    for name, rate in (("go-with-the-flow/input.mp4", 12), ("wan-fun/control_depth.mp4", 16)):
        with av.open(str(prior.folder / name)) as container:
            assert container.streams.video[0].average_rate == rate


def test_a_bundle_tells_what_it_does_and_is_whole_or_not_there(prior: Prior):
    told: list[str] = []
    write_bundles(prior.folder, ["flo"], progress=told.append)
    assert told[0] == f"flo: flow 1 of {FRAMES}"
    before = {path.name: path.read_bytes() for path in (prior.folder / "flo").iterdir()}
    reads = iter(range(9))
    with pytest.raises(Cancelled):
        write_bundles(prior.folder, ["flo", "final-sim"], cancelled=lambda: next(reads) == 8)
    assert {p.name: p.read_bytes() for p in (prior.folder / "flo").iterdir()} == before
    kept = {path.name for path in prior.folder.iterdir()}
    assert "final-sim" not in kept
    assert not [name for name in kept if name.startswith(".")]

    def interrupted(what: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_bundles(prior.folder, ["flo"], progress=interrupted)
    assert {path.name for path in prior.folder.iterdir()} == kept


def test_a_damaged_prior_is_said(prior: Prior):
    path = prior.folder / "flow/flow_0001.npz"
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(InputError, match=r"flow_0001\.npz is missing or damaged"):
        write_bundles(prior.folder, ["flo"])
    (prior.folder / "frames/frame_0002.png").write_bytes(b"")
    with pytest.raises(InputError, match=r"frame_0002\.png is damaged"):
        write_bundles(prior.folder, ["wan-vace"])


def test_what_is_no_prior_or_no_bundle_is_said(prior: Prior, tmp_path: Path):
    with pytest.raises(InputError, match="known: flo"):
        write_bundles(prior.folder, ["floo"])
    with pytest.raises(InputError, match="no finished motion prior"):
        write_bundles(tmp_path, ["flo"])
    meta = json.loads((prior.folder / "meta.json").read_text())
    for number, opens in ((4, True), (3, False), (99, False)):
        meta["made_from"]["format"] = number
        (prior.folder / "meta.json").write_text(json.dumps(meta))
        if opens:
            assert Prior.open(prior.folder).frames == FRAMES
            continue
        with pytest.raises(InputError, match=f"of format {number}; .* export its session again"):
            Prior.open(prior.folder)
    assert set(BUNDLES) >= {"flo", "kitti", "csv", "parquet", "mjcf", "final-sim"}
