#!/usr/bin/env python3
"""From a fresh machine to the running product, with the standard library alone.

    python3 launch.py                   set up once, then open the studio on the demo
    python3 launch.py --no-browser      the same, but only print the address
    python3 launch.py run CASE …        any words go to the `physagent` command line
    python3 launch.py test              set up what the tests need and run all of them

The first start makes the folder .venv beside this file; later starts go straight through. Nothing
outside this folder is changed, but for pip's own download cache (and, for `test` as root on
Debian, the package chromium).
"""

# Plain Python 3.8: an old interpreter must get far enough to find a newer one.
from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Iterable, Iterator, Mapping, NamedTuple, Sequence

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMP = VENV / "launch-stamp.txt"
LOG = VENV / "install.log"
OFFERED = VENV / "models-offered"
LOCK = ROOT / "requirements.lock"

OLDEST = (3, 11)
# The order of preference: the newest Python often waits months for its wheels.
NAMES = ("python3.13", "python3.12", "python3.11", "python3.14", "python3", "python")

# Measured on Linux x86-64; the disk counts .venv and what pip keeps in its cache.
DOWNLOAD_MB, DISK_MB, MINUTES = 200, 950, "1 to 3"
TEST_DOWNLOAD_MB, TEST_DISK_MB = 130, 600
STUDIO_PORT = "8080"  # where the studio begins to look for a free port
SUPPORTED = "Python 3.11 to 3.14 on Linux (x86-64 or ARM64, glibc 2.28) and macOS on Apple silicon"


class LaunchError(Exception):
    """One sentence for the person at the terminal."""


class Probe(NamedTuple):
    """What an interpreter said of itself."""

    version: tuple[int, int]
    missing: str  # the modules that a virtual environment needs and this Python lacks


def candidates(search_path: str) -> Iterator[str]:
    """Every file on the search path that is called like a Python, the preferred names first."""
    for name in NAMES:
        for folder in search_path.split(os.pathsep):
            path = os.path.join(folder, name)
            if folder and os.path.isfile(path) and os.access(path, os.X_OK):
                yield path


def probe(path: str) -> Probe | None:
    """Ask an interpreter for its version and its missing modules; None where it does not run."""
    code = (
        "import sys, importlib.util as u; print(*sys.version_info[:2], "
        "*[m for m in ('venv', 'ensurepip') if u.find_spec(m) is None])"
    )
    try:
        done = subprocess.run(
            [path, "-c", code], capture_output=True, text=True, timeout=20, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    words = done.stdout.split()
    if done.returncode != 0 or len(words) < 2:
        return None  # for example a version manager's placeholder
    return Probe((int(words[0]), int(words[1])), " and ".join(words[2:]))


def choose_python(paths: Iterable[str]) -> str:
    """The first interpreter that is new enough and can make a virtual environment.

    Raises:
        LaunchError: there is none; the sentence names what was found and what to install.
    """
    found: dict[str, Probe] = {}
    for path in paths:
        answer = probe(path)
        if answer is None:
            continue
        if answer.version >= OLDEST and not answer.missing:
            return path
        found[path] = answer
    for path, answer in found.items():
        if answer.version >= OLDEST:
            version = dotted(answer.version)
            raise LaunchError(
                f"Python {version} ({path}) lacks {answer.missing}, needed for a virtual "
                "environment: install that part of it "
                f"(Debian and Ubuntu: sudo apt install python{version}-venv) and start again."
            )
    old = [f"{path} is {dotted(answer.version)}" for path, answer in found.items()]
    raise LaunchError(
        f"Python {dotted(OLDEST)} or newer is needed and none is on PATH "
        f"({'; '.join(old) or 'no Python runs'}): install one (python.org, "
        "`brew install python@3.13` or `sudo apt install python3 python3-venv`) and start again."
    )


def dotted(version: tuple[int, ...]) -> str:
    """(3, 11) as "3.11"."""
    return ".".join(str(part) for part in version)


def venv_program(name: str, venv: Path = VENV) -> Path:
    """Where a virtual environment keeps a program."""
    return venv / "Scripts" / f"{name}.exe" if os.name == "nt" else venv / "bin" / name


def wanted_stamp(project: Path, extras: Sequence[str]) -> str:
    """What identifies an install: the project's metadata and lock, its place and the extras."""
    parts = [project / "pyproject.toml", project / LOCK.name]
    found = b"".join(part.read_bytes() for part in parts if part.exists())
    digest = hashlib.sha256(found).hexdigest()
    return f"{digest}\n{project}\n{' '.join(extras)}\n"


def is_installed(stamp: str, wanted: str, python: Path) -> bool:
    """Whether the stamp of the last finished install covers what is wanted now."""
    have, want = stamp.splitlines(), wanted.splitlines()
    if len(have) != 3 or len(want) != 3 or have[:2] != want[:2] or not python.exists():
        return False
    return set(want[2].split()) <= set(have[2].split())


def read_stamp() -> str:
    """The stamp of the last finished install, empty where there is none."""
    try:
        return STAMP.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        return ""


def damaged_packages(python: Path) -> list[str]:
    """The installed packages of which a file is missing or has the wrong size.

    A killed pip can leave a package that it takes for installed next time.
    """
    code = (
        "import importlib.metadata as m\n"
        "def bad(f): p = f.locate(); return not p.exists() or p.stat().st_size != f.size\n"
        "for d in m.distributions():\n"
        "    files = d.files\n"
        "    if files is None or any(bad(f) for f in files if f.size is not None):\n"
        "        print(d.metadata['Name'])\n"
    )
    done = subprocess.run(
        [str(python), "-I", "-c", code], capture_output=True, text=True, check=False
    )
    return done.stdout.split() if done.returncode == 0 else ["python"]


def announce(extras: Sequence[str], free_bytes: int) -> str:
    """What the install will cost.

    Raises:
        LaunchError: the disk has no room for it.
    """
    download = DOWNLOAD_MB + (TEST_DOWNLOAD_MB if "test" in extras else 0)
    disk = DISK_MB + (TEST_DISK_MB if "test" in extras else 0)
    if free_bytes < disk * 1e6:
        raise LaunchError(
            f"The disk of {ROOT} has {free_bytes / 1e6:.0f} MB free and {disk} MB are needed: "
            "make room and start again."
        )
    return (
        f"Setting up in {VENV}: about {download} MB to download, {disk} MB on disk, {MINUTES} "
        "minutes, once. Ctrl+C stops; the same command continues."
    )


def check_writable(folder: Path) -> None:
    """Raises LaunchError where no file can be made in a folder."""
    try:
        with tempfile.TemporaryFile(dir=str(folder)):
            pass
    except OSError as error:
        raise LaunchError(
            f"Cannot write into {folder} ({error.strerror}): copy the project to a folder of "
            "your own and start there."
        ) from error


def make_venv() -> None:
    """A fresh virtual environment, in the place of any broken one."""
    say("Making the virtual environment …")
    command = [sys.executable, "-m", "venv", "--clear", str(VENV)]
    if subprocess.call(command) != 0:
        raise LaunchError(
            f"Python's venv module failed for {VENV} (its message is above): "
            "repair that Python or put another one first on PATH."
        )


def pip_install(extras: Sequence[str]) -> None:
    """Install what the lock pins, by its hashes, then the project, editable.

    With pip's own progress on the terminal. What only extras need is not locked.
    """
    target = str(ROOT) + (f"[{','.join(extras)}]" if extras else "")
    command = [str(venv_program("python")), "-m", "pip", "install", "--log", str(LOG)]
    command += ["--disable-pip-version-check", "--retries", "3"]
    # Ready-made packages only: a compiler error says nothing to a user. Python compiles what it
    # imports when it does: most of what is installed never is.
    command += ["--only-binary", ":all:", "--no-compile"]
    steps = [["--require-hashes", "--requirement", str(LOCK)]] if LOCK.exists() else []
    if LOG.exists():
        LOG.unlink()  # pip appends, and the last failure is what `explain` shall read
    for step in [*steps, ["--editable", target]]:
        if subprocess.call(command + step, env={**os.environ, "PIP_USER": "0"}) != 0:
            log = LOG.read_text(encoding="utf-8", errors="replace") if LOG.exists() else ""
            raise LaunchError(explain(log))


def explain(log: str) -> str:
    """One sentence on why pip failed, from its log."""
    if re.search(r"Retry\(total=0|Could not fetch URL|Temporary failure in name resol", log):
        return (
            "No network: the package index cannot be reached; connect (behind a proxy, set "
            "HTTPS_PROXY) and give the same command again, it continues where it stopped."
        )
    if "No space left on device" in log:
        return "The disk is full: make room and give the same command again."
    missing = re.findall(r"No matching distribution found for (\S+)", log)
    if missing:
        return (
            f"There is no ready-made package (wheel) of {missing[-1]} for Python "
            f"{dotted(sys.version_info[:2])} on {platform.system()} {platform.machine()}; "
            f"{SUPPORTED} have one."
        )
    return f"pip could not install the project: its last lines above, or {LOG}, say why."


def install(extras: Sequence[str]) -> None:
    """Bring .venv to what pyproject.toml says, whatever state it is in."""
    kept = sorted({*extras, *"".join(read_stamp().splitlines()[2:]).split()})
    check_writable(ROOT)
    say(announce(kept, shutil.disk_usage(str(ROOT)).free))
    if STAMP.exists():
        STAMP.unlink()  # from here on, until the end, the install counts as broken
    python = venv_program("python")
    answer = probe(str(python)) if python.exists() else None
    if answer is None or answer.version < OLDEST or damaged_packages(python):
        make_venv()
    pip_install(kept)
    if damaged_packages(python):
        raise LaunchError(f"{', '.join(damaged_packages(python))} came out damaged: start again.")
    fresh = STAMP.with_suffix(".new")
    fresh.write_text(wanted_stamp(ROOT, kept), encoding="utf-8")
    os.replace(str(fresh), str(STAMP))
    say("Installed.")


def ensure_installed(extras: Sequence[str], arguments: Sequence[str]) -> None:
    """Nothing where all is in place; else the install, with a newer Python where needed."""
    if is_installed(read_stamp(), wanted_stamp(ROOT, extras), venv_program("python")):
        return
    chosen = choose_python([sys.executable, *candidates(os.environ.get("PATH", ""))])
    if chosen != sys.executable:
        say(f"This Python is {dotted(sys.version_info[:2])}; going on with {chosen}.")
        hand_over([chosen, str(ROOT / "launch.py"), *arguments])
    install(extras)


def over_ssh(environment: Mapping[str, str]) -> bool:
    """Whether the person sits at another machine."""
    return any(environment.get(name) for name in ("SSH_CONNECTION", "SSH_CLIENT", "SSH_TTY"))


def browser_wanted(environment: Mapping[str, str], system: str) -> bool:
    """Whether a browser opened here would be seen by the person who asked for it."""
    if over_ssh(environment):
        return False
    if system in ("darwin", "win32"):
        return True
    return bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))


def ssh_line(environment: Mapping[str, str], words: Sequence[str]) -> str:
    """How to see the studio of this machine from the one the person sits at."""
    parts = environment.get("SSH_CONNECTION", "").split()
    host, gate = (parts[2], parts[3]) if len(parts) == 4 else (platform.node(), "22")
    user = environment.get("USER") or environment.get("LOGNAME") or "you"
    port = words[words.index("--port") + 1] if "--port" in words[:-1] else STUDIO_PORT
    other = "" if gate == "22" else f"-p {gate} "
    return (
        f"You are here over SSH. On your own machine, give\n"
        f"    ssh {other}-L {port}:127.0.0.1:{port} {user}@{host}\n"
        f"and open the address below there (if it has another port, put that for {port})."
    )


def physagent_words(words: Sequence[str], browser: bool) -> list[str]:
    """The words for the `physagent` command line; none, or options alone, mean the studio."""
    full = list(words) if words and not words[0].startswith("-") else ["studio", *words]
    decided = {"--browser", "--no-browser", "--help"} & set(full)
    if full[0] == "studio" and not decided:
        full.insert(1, "--browser" if browser else "--no-browser")
    return full


def offer_models() -> None:
    """Names the learned models once; asks only where somebody can answer."""
    try:
        OFFERED.touch(exist_ok=False)
    except OSError:
        return  # it was offered, or it could not be remembered that it was
    offer = "Learned models make better masks and backgrounds (141 MB, once)"
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        say(f"{offer}: python3 launch.py models fetch")
        return
    try:
        wanted = input(f"{offer}: fetch them now? [y/N] ").strip().lower() in ("y", "yes")
    except EOFError:
        wanted = False
    if wanted:
        # Without them everything runs as well, so that a failure here stops nothing.
        subprocess.call([str(venv_program("physagent")), "models", "fetch"])


def hand_over(command: list[str]) -> None:
    """Become another program, so that signals and the exit code are its own."""
    sys.stdout.flush()
    if os.name == "nt":
        raise SystemExit(subprocess.call(command))
    os.execv(command[0], command)


def say(text: str) -> None:
    """One line for the person, at once even where the output is a pipe."""
    print(text, flush=True)


def main(arguments: list[str]) -> int:
    """Exit code of this start; on POSIX a start of the product does not return."""
    if arguments[:1] in (["-h"], ["--help"]):
        say(__doc__ or "")
        return 0
    try:
        if arguments[:1] == ["test"]:
            ensure_installed(["test"], arguments)
            tests = ROOT / "tests" / "run_all.py"
            hand_over([str(venv_program("python")), str(tests), *arguments[1:]])
        ensure_installed([], arguments)
        words = physagent_words(arguments, browser_wanted(os.environ, sys.platform))
        if words[0] == "studio" and over_ssh(os.environ):
            say(ssh_line(os.environ, words))
        if words[0] == "studio" and "--help" not in words:
            offer_models()
        # Through the interpreter: the first line of a script cannot hold every path.
        interpreter = [] if os.name == "nt" else [str(venv_program("python"))]
        hand_over([*interpreter, str(venv_program("physagent")), *words])
    except LaunchError as error:
        print(f"launch.py: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nStopped. The same command continues.", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
