"""A run asks about what is more likely wrong than right, and says so where it goes on."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest
from typer.testing import CliRunner, Result

from physagent_studio import reconstruction
from physagent_studio.assets import assets_dir
from physagent_studio.cli.app import app
from physagent_studio.reconstruction import pipeline
from physagent_studio.reconstruction.masks import sureness
from physagent_studio.records import Doubt
from physagent_studio.workbench import report as reports

pytestmark = pytest.mark.usefixtures("shared_scenes")

DEMO = str(assets_dir() / "demo")


def _run(home: Path, *words: str) -> Result:
    place = ("--no-frames", "--rounds", "1", "--workspace", str(home), "--json")
    return CliRunner().invoke(app, ["run", DEMO, "--event", "knocks_block_over", *place, *words])


@pytest.fixture
def doubtful(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every mask from clicks is taken for a poor one."""
    monkeypatch.setattr(sureness, "CLICK_WEIGHTS", {"constant": -2.0})
    monkeypatch.setattr(reconstruction, "reconstruct", pipeline.reconstruct)


@pytest.mark.usefixtures("doubtful")
def test_it_waits_with_a_picture_of_the_candidates(tmp_path: Path) -> None:
    result = _run(tmp_path)
    assert result.exit_code == 4
    report = json.loads(result.stdout)
    assert report["simulations"] == 0
    assert not report["realised"]
    masks = [one for one in report["doubts"] if one["kind"] == "mask"]
    assert masks
    for one, picture in zip(masks, report["pictures"], strict=True):
        assert one["probability"] == pytest.approx(0.119, abs=0.001)
        assert one["helps"] == f"draw a box around {one['name'].replace('_', ' ')}"
        assert cv2.imread(picture) is not None


@pytest.mark.usefixtures("doubtful")
def test_with_yes_it_goes_on_but_is_never_plainly_realised(tmp_path: Path) -> None:
    result = _run(tmp_path, "--yes")
    report = json.loads(result.stdout)
    assert report["simulations"] > 0
    assert [one["name"] for one in report["doubts"] if one["kind"] == "mask"]
    assert result.exit_code == 3


def test_nobody_is_asked_about_a_plain_ball(tmp_path: Path) -> None:
    report = json.loads(_run(tmp_path).stdout)
    assert report["simulations"] > 0
    assert "red_ball" not in [one["name"] for one in report["doubts"]]


def test_a_doubted_camera_says_how_the_horizon_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubt = Doubt("camera", "camera", 0.4, "click the ends of the horizon")
    monkeypatch.setattr(reports, "doubts_of", lambda *_: (doubt,))
    place = ("--event", "knocks_block_over", "--rounds", "1", "--workspace", str(tmp_path))
    said = " ".join(CliRunner().invoke(app, ["run", DEMO, *place]).output.split())
    assert "click the ends of the horizon (in the studio), or give its row" in said
    assert "--horizon ROW" in said
