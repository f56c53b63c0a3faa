"""A clip leaves in the photo's size or another; what cannot be is said and leaves nothing."""

from __future__ import annotations

from pathlib import Path

import av
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.clips import render_session
from physagent_studio.program import SetField
from physagent_studio.records.clip_look import ClipLook
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands

PATIENCE = 120.0


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory, shared_scenes: None):
    """The beginning of the demo's easiest event, run once."""
    workbench = Workbench(Store(tmp_path_factory.mktemp("sessions")), evidence=False)
    workbench.post(commands.OpenCase(assets_dir() / "demo", "knocks_block_over"))
    # Each of its frames costs as much as the last.
    workbench.post(commands.ApplyEdits((SetField(path="clip.frames", value=9),)))
    workbench.post(commands.Step())
    workbench.post(commands.Step())
    assert workbench.wait(PATIENCE)
    yield workbench
    workbench.close()


@pytest.mark.parametrize("way", ["crop", "letterbox"])
def test_it_is_made_in_the_size_that_is_asked_for(ran: Workbench, tmp_path: Path, way) -> None:
    path = tmp_path / "clip.mp4"
    ran.post(commands.Render(path, ClipLook((320, 480), way)))
    assert ran.wait(PATIENCE)
    with av.open(str(path)) as container:
        first = next(container.decode(video=0)).to_ndarray(format="rgb24")
    assert first.shape == (480, 320, 3)
    bars = first[:40].max() < 24
    assert bars == (way == "letterbox")


def test_the_command_says_in_which_size_it_wrote(ran: Workbench, tmp_path: Path) -> None:
    name, root = ran.snapshot().session_id, ran.store.root
    assert name is not None
    said = render_session(name, None, tmp_path / "clip.mp4", root)
    assert said == f"wrote {tmp_path / 'clip.mp4'}, 832 × 480 pixels"
    said = render_session(name, None, tmp_path / "small.mp4", root, ClipLook((416, 240)))
    assert said.endswith("small.mp4, 416 × 240 pixels")


def test_a_size_that_no_clip_has_is_refused_with_the_reason(ran: Workbench, tmp_path: Path) -> None:
    path = tmp_path / "odd.mp4"
    ran.post(commands.Render(path, ClipLook((321, 480))))
    assert ran.wait(PATIENCE)
    assert any("321×480 is no size for a clip" in one.text for one in ran.snapshot().notices)
    assert list(tmp_path.iterdir()) == []
