"""A recording for Rerun, read back with Rerun's own reader and compared with the rollout."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from physagent_studio.errors import BackendMissing
from physagent_studio.exchange import Prior, export_motion_prior, write_bundles
from physagent_studio.program.rotations import about_axis
from physagent_studio.records.rollout import CONTACT_DTYPE
from tests.exchange.prior.conftest import FRAMES, Parts

IMPULSE = 0.5


@pytest.fixture
def prior(parts: Parts, tmp_path: Path) -> Prior:
    """A ball that turns as it moves beside a soft, textured crate that swells; they touch once."""
    scene, rollout, program = parts
    turns = rollout.rotations.copy()
    turns[:, 0] = [about_axis((0, 0, 1), 0.4 * number) for number in range(FRAMES)]
    touch = np.zeros(1, CONTACT_DTYPE)
    touch["step"], touch["impulse"], touch["normal"] = 2, IMPULSE, (1, 0, 0)
    crate = scene.meshes["crate"]
    texture = np.random.default_rng(0).integers(0, 255, (12, 20, 3), np.uint8)
    uv = np.abs(crate.vertices[:, :2]) * (40, 20)
    scene = replace(scene, meshes={**scene.meshes, "crate": replace(crate, uv=uv, texture=texture)})
    swelling = crate.vertices * np.linspace(1, 1.3, FRAMES)[:, None, None] + rollout.positions[0, 1]
    soft = replace(rollout, rotations=turns, contacts=touch, vertices=(("crate", swelling),))
    return Prior.open(export_motion_prior(tmp_path / "prior", scene, soft, program, 16))


def test_without_its_package_there_is_one_sentence(
    parts: Parts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = export_motion_prior(tmp_path / "prior", *parts, 16)
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(BackendMissing, match=r"physagent-studio\[rerun\]"):
        write_bundles(folder, ["rerun"])
    assert not list((folder / "rerun").glob("*"))


class Recording:
    """Every value of a recording by entity, component and frame; None is the frame of statics."""

    def __init__(self, path: Path) -> None:
        chunk = pytest.importorskip("rerun.chunk", reason="Rerun's reader (0.41) is not installed")
        self.values: dict[tuple[str, str], dict[int | None, Any]] = {}
        self.seconds: dict[int, float] = {}
        for piece in chunk.RrdReader(path).stream():
            batch = piece.to_record_batch()
            told = [name for name in batch.schema.names if name != "log_time"]
            table = batch.select(told).to_pydict()
            count = piece.num_rows
            frames = [None] * count if piece.is_static else table["frame"]
            for frame, passed in zip(frames, table.get("seconds", ()), strict=False):
                self.seconds[frame] = passed.total_seconds()
            for column, rows in table.items():
                kept = self.values.setdefault((piece.entity_path, column), {})
                kept.update(
                    (frame, row) for frame, row in zip(frames, rows, strict=True) if row is not None
                )

    def of(self, entity: str, component: str) -> dict[int | None, Any]:
        return self.values[entity, component]


@pytest.mark.rerun
def test_the_recording_holds_the_clip(prior: Prior):
    pytest.importorskip("rerun", reason="the package rerun-sdk is not installed")
    assert "4 frames" in write_bundles(prior.folder, ["rerun"])[0]
    read, rollout = Recording(prior.folder / "rerun/clip.rrd"), prior.rollout()
    entities = {entity for entity, _ in read.values if not entity.startswith("/__")}
    assert entities == {
        "/world",
        "/world/camera",
        "/world/camera/picture",
        "/world/camera/picture/depth",
        "/world/contacts",
        "/world/paths/ball",
        "/world/paths/crate",
        "/world/things/ball",
        "/world/things/crate",
    }
    step = prior.meta["seconds_per_frame"]
    assert read.seconds == pytest.approx({number: number * step for number in range(FRAMES)})
    places = read.of("/world/things/ball", "Transform3D:translation")
    turns = read.of("/world/things/ball", "Transform3D:quaternion")
    assert list(places) == list(turns) == list(range(FRAMES))
    assert np.allclose(places[2], rollout.positions[2, 0], atol=1e-6)
    assert np.allclose(np.roll(turns[2], 1), rollout.rotations[2, 0], atol=1e-6)
    (deformed,) = (vertices for name, vertices in rollout.vertices if name == "crate")
    shapes = read.of("/world/things/crate", "Mesh3D:vertex_positions")
    assert None not in shapes
    assert np.allclose(shapes[3], deformed[3], atol=1e-6)
    arrows = read.of("/world/contacts", "Arrows3D:vectors")
    assert [len(arrows[number]) for number in range(FRAMES)] == [0, 0, 1, 0]
    assert np.allclose(arrows[2], [[IMPULSE, 0, 0]])


@pytest.mark.rerun
def test_the_camera_sees_the_pictures(prior: Prior):
    pytest.importorskip("rerun", reason="the package rerun-sdk is not installed")
    write_bundles(prior.folder, ["rerun"])
    read, camera = Recording(prior.folder / "rerun/clip.rrd"), prior.meta["camera"]
    columns = read.of("/world/camera/picture", "Pinhole:image_from_camera")[None]
    assert np.allclose(np.reshape(columns, (3, 3)).T, camera["intrinsics"])
    where = read.of("/world/camera", "Transform3D:translation")[None]
    assert np.allclose(where, [camera["position"]])
    pictures = read.of("/world/camera/picture", "EncodedImage:blob")
    assert list(pictures) == list(range(FRAMES))
    found = cv2.imdecode(np.array(pictures[1][0], np.uint8), cv2.IMREAD_COLOR)
    assert found is not None
    assert np.array_equal(found[..., ::-1], prior.picture(1))
    depths = read.of("/world/camera/picture/depth", "EncodedDepthImage:blob")
    assert bytes(depths[1][0][:4]) == b"\x89PNG"
    # Rerun counts v from above, as the texture's rows are.
    placed = np.array(read.of("/world/things/crate", "Mesh3D:vertex_texcoords")[0])
    vertices = np.array(read.of("/world/things/crate", "Mesh3D:vertex_positions")[0])
    home = vertices - prior.rollout().positions[0, 1]
    assert np.allclose(placed, np.abs(home[:, :2]) * (40, 20) / (20, 12), atol=1e-5)
