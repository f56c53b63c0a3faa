"""launch.py as a person starts it, on a project so small that its install needs no network."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TINY = Path(__file__).parent / "tiny_project"


class Started:
    """One finished start: its exit code, its process number and its output."""

    def __init__(self, checkout: Path, *words: str) -> None:
        alike = {name: value for name, value in os.environ.items() if not name.startswith("SSH_")}
        offline = {"PIP_NO_INDEX": "1", "PIP_CONFIG_FILE": os.devnull}
        with subprocess.Popen(
            [sys.executable, "launch.py", *words],
            cwd=checkout,
            env={**alike, **offline},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process:
            self.output, _ = process.communicate()
        self.code, self.pid = process.returncode, process.pid
        self.last = self.output.splitlines()[-1]
        self.installed = "Setting up in" in self.output


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory, repository: Path) -> Path:
    """A copy of launch.py with a project to install, cold, in a folder with a space."""
    folder = tmp_path_factory.mktemp("check out")
    shutil.copy(repository / "launch.py", folder)
    for file in TINY.iterdir():
        if file.is_file():
            shutil.copy(file, folder)
    return folder


def test_cold_warm_changed_and_broken(checkout: Path) -> None:
    cold = Started(checkout, "run", "a case")
    assert cold.installed, cold.output
    assert cold.output.index("Installed.") > cold.output.index("Successfully installed")
    assert (cold.code, cold.last) == (7, f"{cold.pid} run a case"), "same process, same exit code"

    offered = Started(checkout, "--no-browser")
    assert offered.output.count("models fetch") == 1, "the learned models are named, once"

    warm = Started(checkout, "--no-browser")
    assert warm.output == f"{warm.pid} studio --no-browser\n", "nothing but the program's own words"

    with (checkout / "pyproject.toml").open("a") as file:
        file.write("# changed\n")
    changed = Started(checkout, "run")
    assert changed.installed
    assert "Making the virtual environment" not in changed.output
    assert not Started(checkout, "run").installed

    (checkout / ".venv" / "launch-stamp.txt").unlink()  # as after a kill between two packages
    resumed = Started(checkout, "run")
    assert resumed.installed
    assert "Making the virtual environment" not in resumed.output
    assert resumed.code == 7

    (checkout / ".venv" / "launch-stamp.txt").unlink()  # as after a kill within a package
    next(checkout.glob(".venv/lib/python3*/site-packages/tiny.py")).unlink()
    rebuilt = Started(checkout, "run")
    assert "Making the virtual environment" in rebuilt.output
    assert (rebuilt.code, rebuilt.last) == (7, f"{rebuilt.pid} run")


def test_help_needs_no_install(tmp_path: Path, repository: Path) -> None:
    shutil.copy(repository / "launch.py", tmp_path)
    shown = Started(tmp_path, "--help")
    assert shown.code == 0
    assert "python3 launch.py test" in shown.output
    assert not (tmp_path / ".venv").exists()


def test_a_wheel_that_cannot_be_had_is_one_sentence(checkout: Path, tmp_path: Path) -> None:
    shutil.copy(checkout / "launch.py", tmp_path)
    (tmp_path / "pyproject.toml").write_text(
        '[build-system]\nrequires = ["no-such-thing"]\nbuild-backend = "x"\n'
    )
    failed = Started(tmp_path, "run")
    assert failed.code == 1
    assert failed.last.startswith("launch.py: There is no ready-made package (wheel)")
    assert "Traceback" not in failed.output
