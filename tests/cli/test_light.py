"""Commands that answer at once load none of the rooms that they do not need."""

import subprocess
import sys

import pytest

HEAVY = ("mujoco", "viser", "scipy", "trimesh", "physagent_studio.reconstruction")


@pytest.mark.parametrize(
    "module",
    [
        "physagent_studio.cli.app",
        "physagent_studio.cli.studio",
        "physagent_studio.program",
    ],
)
def test_it_loads_no_heavy_room(module: str) -> None:
    code = f"import sys, {module}; print([m for m in {HEAVY!r} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
