"""Every check of this project, in order: `python3 launch.py test`, and nothing else, calls this.

It runs on the interpreter of .venv. Words after `test` go to pytest; `--quick` runs the linters and
the tests of rooms that are quick to test, without a browser. A failing step does not stop the
others; the exit code is 0 only when all of them passed.
"""

import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
# Of what pyright makes, node keeps more before it sorts out what is not needed any more: a fifth of
# the processor time less.
NODE = {"NODE_OPTIONS": "--max-semi-space-size=64"}
# What is compiled is kept, also where the environment forbids it: else each process of the tests
# compiles anew what it imports, three seconds and more.
KEPT = {"PYTHONDONTWRITEBYTECODE": ""}
SHELL = "chromium-headless-shell"
"""Chromium without windows and what is in them, which nobody sees here: a third of its work."""
BROWSERS = (SHELL, "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


class Step(NamedTuple):
    """One check: its headline, the command that makes it, and whether it runs beside the others.

    What tests leave of the machine while they wait for a browser is enough for one that does.
    quiet: its words are only shown where it fails.
    """

    name: str
    command: list[str]
    beside: bool = False
    quiet: bool = False


QUICK = ["-m", "not slow"]
"""What pytest runs where nothing else is asked for."""
QUICK_ROOMS = ("knowledge", "program", "contract", "records", "session", "rendering", "simulation")
"""Rooms whose tests need neither a browser nor a reconstruction, for `--quick`."""
COLLECTED = ["--ignore=tests/packaging"]
# Tests of one file share what is dear to make, so a file stays with one process. They come in the
# order of tests/conftest.py, the long ones first: by their number the longest would come last.
# One more process than there are cores uses the time in which others wait for a browser.
SHARED = [
    "-n",
    str(min(os.cpu_count() or 1, 4) + 1),
    "--dist",
    "loadfile",
    "--no-loadscope-reorder",
]


def quick_steps() -> list[Step]:
    """The checks of `--quick`: a couple of minutes."""
    python = [sys.executable, "-m"]
    rooms = [f"tests/{room}" for room in QUICK_ROOMS]
    return [
        Step("ruff check", [*python, "ruff", "check", "."]),
        Step("ruff format", [*python, "ruff", "format", "--check", "."]),
        Step("pytest", [*python, "pytest", "-q", *rooms, *SHARED, *QUICK]),
    ]


def steps(pytest_words: list[str]) -> list[Step]:
    """The checks, the quick ones first."""
    python = [sys.executable, "-m"]
    lint_imports = str(Path(sys.executable).with_name("lint-imports"))
    # Compiles all tests once, which all processes of pytest else do at the same time.
    compiling = [*python, "pytest", "-qq", "--collect-only", *COLLECTED]
    return [
        Step("ruff check", [*python, "ruff", "check", "."]),
        Step("ruff format", [*python, "ruff", "format", "--check", "."]),
        Step("pyright", [*python, "pyright", "--pythonpath", sys.executable], beside=True),
        Step("lint-imports", [sys.executable, lint_imports]),
        Step("wheel", [*python, "pytest", "-q", "tests/packaging"]),
        *([] if pytest_words else [Step("collect", compiling, quiet=True)]),
        # The big doses have a marker; words of one's own decide for themselves.
        Step(
            "pytest",
            [
                *python,
                "pytest",
                "-q",
                *COLLECTED,
                *SHARED,
                *(pytest_words or QUICK),
            ],
        ),
    ]


def playwright_browser() -> str | None:
    """Path of the Chromium that playwright has downloaded, if it has."""
    from playwright.sync_api import sync_playwright  # only the test extra has it

    with sync_playwright() as playwright:
        path = playwright.chromium.executable_path
    return path if Path(path).exists() else None


def is_debian() -> bool:
    """Whether apt has a real chromium package here; Ubuntu's is a stub for a snap."""
    release = Path("/etc/os-release")
    return (
        release.exists()
        and "ID=debian" in release.read_text(encoding="utf-8").splitlines()
        and shutil.which("apt-get") is not None
    )


def browser_commands() -> list[list[str]]:
    """What brings a Chromium, the first choice first."""
    is_root = os.name == "posix" and os.geteuid() == 0
    # Only root may add the system libraries that the download leans on.
    libraries = ["--with-deps"] if is_root and sys.platform == "linux" else []
    download = [sys.executable, "-m", "playwright", "install", *libraries, "chromium"]
    if is_root and is_debian():
        apt = "apt-get update -q && apt-get install -q -y --no-remove --no-install-recommends"
        return [["sh", "-c", f"{apt} {name}"] for name in (SHELL, "chromium")] + [download]
    return [download]


def find_browser() -> str | None:
    """A Chromium on this machine: the one without windows, the system's own, a downloaded one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None) or playwright_browser()


def ensure_browser() -> bool:
    """Whether there is a Chromium, after having tried for the one without windows."""
    for command in browser_commands():
        if shutil.which(SHELL) or (find_browser() and SHELL not in command[-1]):
            break
        print(f"Installing a Chromium: {' '.join(command)}", flush=True)
        subprocess.call(command, cwd=ROOT)
    return find_browser() is not None


class Done(NamedTuple):
    """What came of a check; said: its words, where they were not shown at once."""

    name: str
    passed: bool
    seconds: float
    said: str = ""


def carry_out(step: Step) -> Done:
    """Makes a check; the words of one that runs beside the others, or is quiet, are kept."""
    kept = step.beside or step.quiet
    out, errors = (subprocess.PIPE, subprocess.STDOUT) if kept else (None, None)
    begun = time.monotonic()
    done = subprocess.run(
        step.command,
        cwd=ROOT,
        env=NODE | os.environ | KEPT,
        text=True,
        check=False,
        stdout=out,
        stderr=errors,
    )
    return Done(step.name, done.returncode == 0, time.monotonic() - begun, done.stdout or "")


def headline(text: str) -> None:
    """A line that the eye finds in a long log."""
    print(f"\n==== {text} {'=' * max(0, 74 - len(text))}", flush=True)


def main(pytest_words: list[str]) -> int:
    """Run all steps, print a summary, return the exit code."""
    results: list[Done] = []
    quick = pytest_words == ["--quick"]
    if not quick:
        headline("Chromium")
        begun = time.monotonic()
        results.append(Done("Chromium", ensure_browser(), time.monotonic() - begun))
        print(find_browser() or "Chromium could not be installed.", flush=True)
    wanted = quick_steps() if quick else steps(pytest_words)
    with ThreadPoolExecutor() as pool:
        beside = [pool.submit(carry_out, step) for step in wanted if step.beside]
        for step in wanted:
            if not step.beside:
                headline(step.name)
                done = carry_out(step)
                if not done.passed:
                    print(done.said, flush=True)
                results.append(done)
    for done in [future.result() for future in beside]:
        headline(done.name)
        print(done.said, flush=True)
        results.append(done)
    headline("Summary")
    for done in results:
        print(f"{'passed' if done.passed else 'FAILED':8}{done.name:16}{done.seconds:7.1f} s")
    return 0 if all(done.passed for done in results) else 1


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        print("\nStopped.", file=sys.stderr)
        sys.exit(130)
