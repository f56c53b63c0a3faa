"""Commands that answer at once load none of the rooms that they do not need."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("mujoco", "viser", "scipy", "trimesh", "physagent_studio.reconstruction")


@pytest.mark.parametrize(
    "module",
    [
        "physagent_studio.cli.app",
        "physagent_studio.cli.marks",
        "physagent_studio.cli.studio",
        "physagent_studio.program",
    ],
)
def test_it_loads_no_heavy_room(module: str) -> None:
    code = f"import sys, {module}; print([m for m in {HEAVY!r} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


ASKED = """
import sys
from physagent_studio.cli import main
sys.argv = ["physagent", *sys.argv[1:]]
try:
    main()
except SystemExit as ended:
    print(ended.code, [one for one in HEAVY if one in sys.modules])
"""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run gone.png --prompt x", "gone.png does not exist"),
        ("run nosession", "no session 'nosession'"),
        ("run here.png --prompt x --policy whatever", "--policy whatever is not known"),
        ("run here.png --prompt x --by-hand cook", "--by-hand cook is not known"),
        ("run here.png --prompt x --agent none", "--agent none is not known"),
        ("run here.png --prompt x --object a@1,2,1,2", "an empty box"),
        ("studio gone.png --no-browser", "gone.png does not exist"),
        ("simulate gone.yaml --out a.npz", "gone.yaml cannot be read"),
        ("import gone.xml --out a.yaml", "gone.xml does not exist"),
        ("render nosession --out a.mp4", "no session 'nosession'"),
        ("render nosession --out a.gif", "call it a.mp4"),
        ("render nosession --out a.mp4 --size large", "--size large is not of the form"),
        ("export nosession --out a", "no session 'nosession'"),
        ("generate gone --out a.mp4", "gone does not exist"),
        ("reconstruct gone --sheet a.png", "gone does not exist"),
        ("sweep gone.yaml --grid a=0:1:2 --out a", "gone.yaml does not exist"),
        ("attribute nosession", "no session 'nosession'"),
    ],
)
def test_what_is_wrong_with_the_words_is_said_before_a_heavy_room_is_loaded(
    tmp_path: Path, words: str, said: str
) -> None:
    (tmp_path / "here.png").touch()
    command = [
        sys.executable,
        "-c",
        f"HEAVY = {HEAVY!r}\n{ASKED}",
        *words.replace("here.png", str(tmp_path / "here.png")).split(),
    ]
    home = os.environ | {"PHYSAGENT_HOME": str(tmp_path / "home")}
    run = subprocess.run(command, capture_output=True, text=True, env=home)
    assert said in run.stderr
    assert run.stdout.strip() == "2 []"
