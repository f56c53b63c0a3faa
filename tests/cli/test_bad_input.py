"""Bad input on the command line: one clear sentence, exit 2, nothing lost."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.cli import main
from physagent_studio.cli.clips import export_session, replaced
from physagent_studio.cli.early import RunRequest, video_name
from physagent_studio.cli.programs import reconstruct_case
from physagent_studio.cli.run import run_loop
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange.prior.export import MARK, META
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import LoopState, Round

CASE = """
image: {image}
size: [64, 48]
objects:
  ball: {{points: [[{x}, 20, 1]]}}
events: {{falls: The ball falls.}}
"""


@dataclass(frozen=True, slots=True)
class Said:
    """What a command came to."""

    returncode: int
    stdout: str
    stderr: str


Physagent = Callable[..., Said]


@pytest.fixture
def physagent(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Physagent:
    """The command line, in this process: to start one for each would cost more than all else."""

    def call(*words: str, home: Path) -> Said:
        monkeypatch.setenv("PHYSAGENT_HOME", str(home))
        monkeypatch.setattr(sys, "argv", ["physagent", *words])
        monkeypatch.setattr(sys, "excepthook", sys.excepthook)
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        assert isinstance(ended.value.code, int)
        said = capsys.readouterr()
        return Said(ended.value.code, said.out, said.err)

    return call


def test_it_is_the_same_in_a_process_of_its_own(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "physagent_studio", "run", "./nowhere"]
    environment = {"PHYSAGENT_HOME": str(tmp_path), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)
    one_sentence(Said(done.returncode, done.stdout, done.stderr), "nowhere")


def case_folder(folder: Path, *, image: str = "input.png", x: float | str = 20) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "case.yaml").write_text(CASE.format(image=image, x=x))
    cv2.imwrite(str(folder / "input.png"), np.full((48, 64, 3), 128, np.uint8))
    (folder / "words.png").write_text("this is no picture")
    return folder


def one_sentence(result: Said, *words: str) -> None:
    lines = result.stderr.strip().splitlines()
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr
    assert len(lines) == 1, lines
    for word in words:
        assert word in lines[0], lines[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"image": "gone.png"}, ("gone.png",)),
        ({"image": "words.png"}, ("words.png",)),
        ({"x": 900}, ("ball", "900")),
        ({"x": ".nan"}, ("ball",)),
    ],
)
def test_a_broken_case(
    tmp_path: Path, physagent: Physagent, change: dict[str, str], said: tuple[str, ...]
) -> None:
    folder = case_folder(tmp_path / "case", **change)  # type: ignore[arg-type]
    one_sentence(physagent("run", str(folder), "--event", "falls", home=tmp_path), *said)


def test_unknown_event_names_the_known_ones(tmp_path: Path, physagent: Physagent) -> None:
    folder = case_folder(tmp_path / "case")
    result = physagent("run", str(folder), "--event", "fals", home=tmp_path)
    one_sentence(result, "fals", "falls")


def test_a_missing_target(tmp_path: Path, physagent: Physagent) -> None:
    one_sentence(physagent("run", "./nowhere", home=tmp_path), "nowhere")
    one_sentence(physagent("render", "nosession", "--out", "x.mp4", home=tmp_path), "nosession")


def test_a_bench_refuses_a_page_that_it_could_not_write(
    tmp_path: Path, physagent: Physagent
) -> None:
    # Before the work, which may take an hour.
    page = tmp_path / "nowhere" / "page.md"
    one_sentence(physagent("bench", "physics", "--out", str(page), home=tmp_path), str(page))


PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1]}
event:
  actions:
    - {operator: ApplyForce, id: kick, name: NAME, force: [FORCE, 0, 0],
       start_step: START, duration: 5}
"""


@pytest.mark.parametrize(
    ("name", "force", "start", "said"),
    [
        ("bal", "1", "0", ("event.actions.kick.name", "bal", "ball")),
        ("ball", ".nan", "0", ("event.actions.kick.force",)),
        ("ball", "1", "318", ("event.actions.kick.duration", "past the end")),
        ("ball", "1", "900", ("event.actions.kick.start_step", "past the end")),
    ],
)
def test_a_broken_program(
    tmp_path: Path, physagent: Physagent, name: str, force: str, start: str, said: tuple[str, ...]
) -> None:
    path = tmp_path / "program.yaml"
    path.write_text(PROGRAM.replace("NAME", name).replace("FORCE", force).replace("START", start))
    one_sentence(physagent("validate", str(path), home=tmp_path), "program.yaml, line ", *said)
    out = tmp_path / "rollout.npz"
    one_sentence(physagent("simulate", str(path), "--out", str(out), home=tmp_path), *said)
    assert not out.exists()


def test_an_unwritable_workspace(tmp_path: Path, physagent: Physagent) -> None:
    folder = case_folder(tmp_path / "case")
    blocked = tmp_path / "blocked"
    blocked.write_text("a file, not a folder")
    result = physagent("run", str(folder), "--workspace", str(blocked), home=tmp_path)
    one_sentence(result, "blocked", "cannot be written")


def test_a_workspace_that_is_not_there_is_no_empty_one(
    tmp_path: Path, physagent: Physagent
) -> None:
    wrong, empty = tmp_path / "wrong", tmp_path / "empty"
    result = physagent("sessions", "--workspace", str(wrong), home=tmp_path)
    one_sentence(result, str(wrong), "does not exist")
    assert not wrong.exists()
    empty.mkdir()
    for words in (("--workspace", str(empty)), ()):
        # Nobody has to make the default one before there is a session to put in.
        result = physagent("sessions", *words, home=tmp_path / "not_yet")
        assert (result.returncode, result.stderr) == (0, "")
        assert "no sessions yet" in result.stdout


def test_broken_lessons(tmp_path: Path, physagent: Physagent) -> None:
    folder, lessons = case_folder(tmp_path / "case"), tmp_path / "lessons.yaml"
    wanted = ("run", str(folder), "--event", "falls", "--lessons", str(lessons))
    one_sentence(physagent(*wanted, home=tmp_path), "lessons.yaml", "cannot be read")
    lessons.write_text("lessons:\n- {mismatch: misses}\n")
    one_sentence(physagent(*wanted, home=tmp_path), "lessons.yaml, line 2", "factor")


def test_a_busy_port(tmp_path: Path, physagent: Physagent) -> None:
    folder = case_folder(tmp_path / "case")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        result = physagent("studio", str(folder), "--no-browser", "--port", port, home=tmp_path)
    one_sentence(result, port)


def test_a_malformed_object_word(tmp_path: Path, physagent: Physagent) -> None:
    picture = tmp_path / "p.png"
    cv2.imwrite(str(picture), np.full((48, 64, 3), 128, np.uint8))
    result = physagent(
        "run", str(picture), "--prompt", "The ball falls.", "--object", "ball", home=tmp_path
    )
    one_sentence(result, "name@x,y")


def test_what_reconstruct_render_and_run_need_is_said_before_the_work(tmp_path: Path) -> None:
    folder = case_folder(tmp_path / "case")
    for sheet in (tmp_path / "sheet", tmp_path / "nowhere" / "sheet.png"):
        with pytest.raises(InputError, match=r"must be a \.png in a folder that exists"):
            reconstruct_case(str(tmp_path / "no_case"), sheet)
    with pytest.raises(InputError, match=r"another name; call it clip\.mp4"):
        video_name(tmp_path / "clip.gif")
    text = (folder / "case.yaml").read_text()
    (folder / "case.yaml").write_text(text.partition("events:")[0])
    wanted = RunRequest(str(folder), None, "", (), 1, "auto", (), False, "rules")
    with pytest.raises(InputError, match="has no event; write what shall happen into its case"):
        run_loop(wanted, tmp_path / "home", as_json=True)


@pytest.mark.parametrize(
    ("kind", "package", "said"),
    [("rerun", "rerun", r"\[rerun\]"), ("parquet", "pyarrow", r"\[tables\]")],
)
def test_a_package_that_export_needs_is_asked_for_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, package: str, said: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(BackendMissing, match=said):
        # Not even the session, of which there is none, is looked for before.
        export_session("nosession", None, tmp_path / "prior", tmp_path, ["csv", kind])
    assert not list(tmp_path.iterdir())


def test_marks_beside_a_picture_that_is_read_smaller_are_not_taken_for_its_pixels(
    tmp_path: Path,
) -> None:
    picture, marks = tmp_path / "p.jpg", tmp_path / "marks.yaml"
    cv2.imwrite(str(picture), np.full((3000, 4300, 3), 128, np.uint8))
    marks.write_text("horizon: 900\n")
    words = ("The ball falls.", ("ball@2000,1500",), 1, "auto", (), False, "rules", marks)
    with pytest.raises(InputError, match="at most 12 million pixels"):
        run_loop(RunRequest(str(picture), None, *words), tmp_path / "home", as_json=True)


UNEXPECTED = """
import sys
from physagent_studio.cli import files, main

def broken(path):
    heavy = [one for one in ("av", "cv2", "mujoco", "scipy", "viser") if one in sys.modules]
    raise RuntimeError(f"the moon is in the way, {heavy} was read for nothing")

files.read_program = broken
sys.argv = ["physagent", "validate", "program.yaml"]
main()
"""


@pytest.mark.parametrize("debug", ["", "1"])
def test_what_nobody_expected_is_one_sentence_and_exit_1(debug: str) -> None:
    command = [sys.executable, "-c", UNEXPECTED]
    environment = {"PATH": "/usr/bin:/bin", "PHYSAGENT_DEBUG": debug}
    result = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)
    assert result.returncode == 1
    # What reads no picture and runs nothing answers at once.
    assert "the moon is in the way, [] was read" in result.stderr
    assert ("Traceback" in result.stderr) == bool(debug)


def test_only_an_earlier_export_is_replaced_and_of_the_same_session(tmp_path: Path) -> None:
    only = Round(id="r1", number=1, parent=None, program=PhysicalProgram(), author="generator")
    state = LoopState(rounds=(only,), head="r1")
    assert replaced(tmp_path / "new", state, overwrite=False) == []
    assert replaced(tmp_path, state, overwrite=False) == []
    made = {"kind": MARK, "made_from": {"program": only.program.hash}}
    (tmp_path / META).write_text(json.dumps(made))
    assert "earlier export of this session" in replaced(tmp_path, state, overwrite=False)[0]
    with pytest.raises(InputError, match="another session"):
        replaced(tmp_path, LoopState(), overwrite=False)
    assert "another session" in replaced(tmp_path, LoopState(), overwrite=True)[0]
    (tmp_path / META).write_text("notes of mine")
    for overwrite in (False, True):
        with pytest.raises(InputError, match="no earlier export"):
            replaced(tmp_path, state, overwrite=overwrite)
