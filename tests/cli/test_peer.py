"""A configuration of the peers' releases as the target of `physagent run`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.early import RunRequest
from physagent_studio.cli.run import run_loop
from physagent_studio.errors import InputError
from physagent_studio.session import Store

CONFIG = """\
example_name: a ball and a cube
all_object_points: [[[180, 354, 1]], [[639, 272, 1]]]
material_type: [rigid, rigid]
rigid_rho: 640.0
rigid_friction: 0.35
dt: 0.01
frame_steps: 5
simulated_frames_num: 81
mesh_resize_factor: 1.0
"""


def request_of(target: Path, prompt: str) -> RunRequest:
    names = ("red ball", "green cube")
    return RunRequest(str(target), None, prompt, names, 6, "auto", (), False, "rules", yes=True)


@pytest.mark.usefixtures("unfilled_here")
def test_it_runs_with_its_numbers_and_says_what_it_leaves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(assets_dir() / "demo" / "input.png", tmp_path / "input.png")
    (tmp_path / "config.yaml").write_text(CONFIG)
    request = request_of(tmp_path / "config.yaml", "The red ball rolls to the right.")
    code = run_loop(request, tmp_path / "sessions", True)
    report = json.loads(capsys.readouterr().out)
    assert code == 0, report["diagnosis"]
    assert report["left_out"] == ["mesh_resize_factor"]
    session = Store(tmp_path / "sessions").open(report["session"], writing=False)
    best = session.load().best
    session.close()
    assert best is not None
    ball = best.program.scene.object("red_ball")
    assert ball is not None
    assert (ball.density, ball.friction) == (640.0, 0.35)
    assert best.program.event.prompt == "The red ball rolls to the right."


def test_as_many_names_as_objects_are_needed(tmp_path: Path) -> None:
    shutil.copy(assets_dir() / "demo" / "input.png", tmp_path / "input.png")
    (tmp_path / "config.yaml").write_text(CONFIG.replace(", [[639, 272, 1]]", ""))
    with pytest.raises(InputError, match="1 objects"):
        run_loop(request_of(tmp_path / "config.yaml", "It rolls."), tmp_path / "s", True)
