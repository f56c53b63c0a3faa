"""The built wheel, in an environment that knows nothing of the checkout."""

import os
import site
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from physagent_studio import __version__


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory, repository: Path) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*command, "--wheel-dir", folder, repository], check=True)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Path:
    """A virtual environment with the wheel, on the dependencies of this one.

    They come through a .pth line, whose own .pth files (the checkout's among them) are not read.
    """
    folder = tmp_path_factory.mktemp("clean") / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    (packages,) = folder.glob("lib/python3*/site-packages")
    (packages / "dependencies.pth").write_text("\n".join(site.getsitepackages()) + "\n")
    pip = [sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install"]
    subprocess.run(
        [*pip, "--quiet", "--no-deps", "--force-reinstall", "--no-index", wheel], check=True
    )
    return folder


def physagent(environment: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """The installed program, started from a folder outside the checkout."""
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [environment / "bin" / "physagent", *words],
        cwd=environment,
        env=clean,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_wheel_carries_the_package_whole(wheel: Path, repository: Path) -> None:
    inside = set(zipfile.ZipFile(wheel).namelist())
    listed = subprocess.run(
        ["git", "ls-files", "physagent_studio", "assets"],
        cwd=repository,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    files = [f for f in listed.stdout.splitlines() if (repository / f).exists()]
    expected = {f if f.startswith("physagent_studio/") else f"physagent_studio/{f}" for f in files}
    assert expected <= inside
    assert {"physagent_studio/py.typed", "physagent_studio/assets/README.md"} <= inside
    assert not [name for name in inside if name.startswith(("tests/", "launch"))]


def test_the_environment_uses_the_wheel(environment: Path) -> None:
    code = "import physagent_studio.assets as a; print(a.__file__, a.assets_dir(), sep='\\n')"
    done = subprocess.run(
        [environment / "bin" / "python", "-c", code],
        cwd=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    module, assets = (Path(line) for line in done.stdout.splitlines())
    assert environment in module.parents
    assert environment in assets.parents


def test_version(environment: Path) -> None:
    done = physagent(environment, "--version")
    assert done.returncode == 0, done.stderr
    assert __version__ in done.stdout


@pytest.mark.parametrize(
    "command", ["studio", "run", "validate", "simulate", "render", "export", "bench"]
)
def test_help_lists_every_command(environment: Path, command: str) -> None:
    done = physagent(environment, "--help")
    assert done.returncode == 0, done.stderr
    assert command in done.stdout


def test_a_bundled_program_is_valid(environment: Path) -> None:
    (packages,) = environment.glob("lib/python3*/site-packages/physagent_studio")
    programs = sorted((packages / "assets").rglob("*program*.yaml"))
    assert programs, "the wheel bundles at least one program"
    for program in programs:
        done = physagent(environment, "validate", str(program))
        assert done.returncode == 0, done.stdout + done.stderr


def test_a_broken_program_is_refused(environment: Path, tmp_path: Path) -> None:
    broken = tmp_path / "program.yaml"
    broken.write_text("nothing: here\n")
    done = physagent(environment, "validate", str(broken))
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
