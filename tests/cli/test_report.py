"""What `run --json` says of a run: the contract, the physics, the view, the pacing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.early import RunRequest
from physagent_studio.cli.run import run_loop

pytestmark = pytest.mark.usefixtures("shared_scenes")


def report_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """One round of an event of the demo."""
    request = RunRequest(
        target=str(assets_dir() / "demo"),
        event="knocks_block_over",
        prompt="",
        objects=(),
        rounds=1,
        policy="auto",
        by_hand=(),
        frames=False,
        agent="rules",
    )
    run_loop(request, folder, as_json=True)
    return json.loads(capsys.readouterr().out)


def test_the_view_is_told_like_the_contract(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = report_of(tmp_path, capsys)
    assert report["contract"]
    assert report["view"]
    fields = set(report["contract"][0])
    assert {"check", "statement", "measured", "threshold", "margin", "ok"} <= fields
    for row in report["view"]:
        assert set(row) == fields
        assert row["check"].startswith("view.")
        assert row["ok"] == (row["margin"] >= 0)
    checks = [row["check"] for row in report["view"]]
    assert sorted(set(checks)) == sorted(checks)
    assert "view.inside.red_ball" in checks
    assert all(not row["statement"].startswith("view") for row in report["physics"])
    # What the photograph shows is held against what is drawn.
    assert {"view.begins.red_ball", "view.begins.wooden_block"} <= set(checks)

    holds = all(row["ok"] for kind in ("contract", "physics", "view") for row in report[kind])
    assert report["realised"] == holds

    pacing = report["pacing"]
    assert set(pacing) == {"moving", "first", "last", "crossings", "fastest", "time_factor"}
    assert 0 <= pacing["first"] < pacing["last"] <= 80
    assert 0 < pacing["moving"] <= pacing["last"] - pacing["first"]
    assert pacing["fastest"] > 0
    assert isinstance(pacing["crossings"], dict)
    assert 0.25 <= pacing["time_factor"] <= 4.0
