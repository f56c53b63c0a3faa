"""What launch.py decides, one function at a time."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import launch


def program(path: Path, text: str) -> str:
    """An executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


def test_old_interpreters_can_read_it(repository: Path) -> None:
    source = (repository / "launch.py").read_text(encoding="utf-8")
    ast.parse(source, feature_version=(3, 8))


def test_it_needs_the_standard_library_alone(repository: Path) -> None:
    tree = ast.parse((repository / "launch.py").read_text(encoding="utf-8"))
    imported = {
        name.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in ([node.module or ""] if isinstance(node, ast.ImportFrom) else names(node))
    }
    assert imported <= set(sys.stdlib_module_names)


def names(node: ast.Import) -> list[str]:
    return [alias.name for alias in node.names]


# ---- which Python


def test_candidates_come_in_the_order_of_preference(tmp_path: Path) -> None:
    old = program(tmp_path / "a" / "python3", "echo 3 9")
    newer = program(tmp_path / "b" / "python3.13", "echo 3 13")
    also = program(tmp_path / "b" / "python3.11", "echo 3 11")
    (tmp_path / "a" / "python3.12").write_text("not executable")
    assert list(launch.candidates(f"{tmp_path / 'a'}::{tmp_path / 'b'}")) == [newer, also, old]


def test_this_interpreter_fits() -> None:
    answer = launch.probe(sys.executable)
    assert answer is not None
    assert answer.version == sys.version_info[:2]
    assert launch.choose_python([sys.executable]) == sys.executable


def test_a_placeholder_is_passed_over(tmp_path: Path) -> None:
    shim = program(tmp_path / "python3.13", "echo 'command not found' >&2; exit 127")
    assert launch.probe(shim) is None
    assert launch.probe(str(tmp_path / "absent")) is None
    assert launch.choose_python([shim, sys.executable]) == sys.executable


def test_a_newer_one_is_taken_over_the_old_one(tmp_path: Path) -> None:
    old = program(tmp_path / "python3", "echo 3 9")
    incomplete = program(tmp_path / "python3.12", "echo 3 12 ensurepip")
    good = program(tmp_path / "python3.11", "echo 3 11")
    assert launch.choose_python([old, incomplete, good]) == good


def test_only_old_pythons_is_one_sentence(tmp_path: Path) -> None:
    old = program(tmp_path / "python3", "echo 3 9")
    with pytest.raises(launch.LaunchError) as caught:
        launch.choose_python([old, old])
    assert str(caught.value).startswith(
        f"Python 3.11 or newer is needed and none is on PATH ({old} is 3.9): install one"
    )


def test_a_python_without_venv_names_the_package(tmp_path: Path) -> None:
    incomplete = program(tmp_path / "python3.12", "echo 3 12 ensurepip")
    old = program(tmp_path / "python3", "echo 3 8")
    with pytest.raises(launch.LaunchError, match=r"apt install python3\.12-venv\b"):
        launch.choose_python([old, incomplete])


# ---- is an install needed


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    return tmp_path


def test_a_finished_install_is_known(project: Path) -> None:
    python = Path(sys.executable)
    plain, test = launch.wanted_stamp(project, []), launch.wanted_stamp(project, ["test"])
    assert launch.is_installed(plain, plain, python)
    assert launch.is_installed(test, plain, python), "more than is needed is enough"
    assert not launch.is_installed(plain, test, python)


def test_what_makes_a_reinstall_necessary(project: Path, tmp_path: Path) -> None:
    python = Path(sys.executable)
    stamp = launch.wanted_stamp(project, [])
    assert not launch.is_installed("", stamp, python), "never finished"
    assert not launch.is_installed(stamp[:40], stamp, python), "a torn stamp"
    assert not launch.is_installed(stamp, stamp, tmp_path / "gone"), "the Python was removed"
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    (moved / "pyproject.toml").write_text("[project]\n")
    assert not launch.is_installed(stamp, launch.wanted_stamp(moved, []), python)
    (project / "pyproject.toml").write_text("[project]\nname = 'other'\n")
    assert not launch.is_installed(stamp, launch.wanted_stamp(project, []), python)


def test_damage_is_found(tmp_path: Path) -> None:
    environment = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    python = launch.venv_program("python", environment)
    (site,) = environment.glob("lib/python3*/site-packages")
    (site / "thing.py").write_text("x = 1\n")
    info = site / "thing-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: thing\nVersion: 1\n")
    (info / "RECORD").write_text("thing.py,,6\nthing-1.dist-info/RECORD,,\n")
    assert launch.damaged_packages(python) == []
    (site / "thing.py").write_text("x =")
    assert launch.damaged_packages(python) == ["thing"], "cut short"
    (site / "thing.py").unlink()
    assert launch.damaged_packages(python) == ["thing"], "gone"
    (info / "RECORD").unlink()
    assert launch.damaged_packages(python) == ["thing"], "no record of its files"


# ---- what it says


def test_the_price_is_told_and_a_full_disk_refused() -> None:
    text = launch.announce([], free_bytes=10**10)
    assert f"{launch.DOWNLOAD_MB} MB to download" in text
    assert f"{launch.DISK_MB} MB on disk" in text
    more = launch.DISK_MB + launch.TEST_DISK_MB
    assert f"{more} MB on disk" in launch.announce(["test"], free_bytes=10**10)
    with pytest.raises(launch.LaunchError, match="5 MB free"):
        launch.announce([], free_bytes=5_000_000)


def test_an_unwritable_folder_is_one_sentence(tmp_path: Path) -> None:
    launch.check_writable(tmp_path)
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(launch.LaunchError, match=r"Cannot write into .* \(Not a directory\)"):
        launch.check_writable(file)


def pip_log(tmp_path: Path, *words: str) -> str:
    """The log of a pip that fails."""
    log = tmp_path / "pip.log"
    common = ["--isolated", "--log", str(log), "--disable-pip-version-check"]
    command = [sys.executable, "-m", "pip", "install", "--dry-run", *common, *words]
    assert subprocess.run(command, capture_output=True, check=False).returncode != 0
    return log.read_text(encoding="utf-8")


def test_no_network_is_told_from_a_real_log(tmp_path: Path) -> None:
    words = ["--retries", "0", "--index-url", "https://index.invalid/simple", "no-such-thing"]
    assert launch.explain(pip_log(tmp_path, *words)).startswith("No network:")


def test_a_missing_wheel_is_told_from_a_real_log(tmp_path: Path) -> None:
    log = pip_log(tmp_path, "--no-index", "--only-binary", ":all:", "no-such-thing>=2")
    assert "package (wheel) of no-such-thing>=2 for Python" in launch.explain(log)


def test_any_other_failure_names_the_log() -> None:
    assert str(launch.LOG) in launch.explain("something else")
    assert "disk is full" in launch.explain("OSError: [Errno 28] No space left on device")


# ---- how it starts


@pytest.mark.parametrize(
    ("environment", "platform", "wanted"),
    [
        ({"DISPLAY": ":0"}, "linux", True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, "linux", True),
        ({"DISPLAY": ""}, "linux", False),
        ({}, "linux", False),
        ({}, "darwin", True),
        ({"SSH_CONNECTION": "10.0.0.1 5 10.0.0.2 22"}, "darwin", False),
        ({"DISPLAY": "localhost:10.0", "SSH_CONNECTION": "a 1 b 22"}, "linux", False),
    ],
)
def test_a_browser_is_opened_only_where_it_is_seen(
    environment: dict[str, str], platform: str, wanted: bool
) -> None:
    assert launch.browser_wanted(environment, platform) is wanted


def test_the_way_in_over_ssh() -> None:
    environment = {"SSH_CONNECTION": "10.0.0.1 50000 10.0.0.2 22", "USER": "ann"}
    assert "\n    ssh -L 8080:127.0.0.1:8080 ann@10.0.0.2\n" in launch.ssh_line(environment, [])
    environment["SSH_CONNECTION"] = "10.0.0.1 50000 fe80::2 2222"
    line = launch.ssh_line(environment, ["studio", "--port", "9000"])
    assert "\n    ssh -p 2222 -L 9000:127.0.0.1:9000 ann@fe80::2\n" in line


@pytest.mark.parametrize(
    ("words", "browser", "full"),
    [
        ([], True, ["studio", "--browser"]),
        ([], False, ["studio", "--no-browser"]),
        (["--no-browser"], True, ["studio", "--no-browser"]),
        (["--port", "9000"], False, ["studio", "--no-browser", "--port", "9000"]),
        (["studio", "case"], True, ["studio", "--browser", "case"]),
        (["studio", "case", "--browser"], False, ["studio", "case", "--browser"]),
        (["studio", "--help"], True, ["studio", "--help"]),
        (["run", "case", "--event", "e"], True, ["run", "case", "--event", "e"]),
    ],
)
def test_words_go_to_the_command_line(words: list[str], browser: bool, full: list[str]) -> None:
    assert launch.physagent_words(words, browser) == full


@pytest.mark.parametrize(
    ("terminal", "answer", "calls"), [(True, "y", 1), (True, "", 0), (False, "y", 0)]
)
def test_models_are_offered_once(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    terminal: bool,
    answer: str,
    calls: int,
) -> None:
    asked: list[object] = []
    monkeypatch.setattr(launch, "OFFERED", tmp_path / "offered")
    monkeypatch.setattr(launch.subprocess, "call", asked.append)
    monkeypatch.setattr("sys.stdin.isatty", lambda: terminal, raising=False)
    monkeypatch.setattr("sys.stdout.isatty", lambda: terminal, raising=False)

    def told(question: str) -> str:
        assert terminal  # nobody is asked where nobody can answer
        print(question)
        return answer

    monkeypatch.setattr("builtins.input", told)
    for _ in range(2):
        launch.offer_models()
    assert len(asked) == calls
    assert capsys.readouterr().out.count("141 MB") == 1
