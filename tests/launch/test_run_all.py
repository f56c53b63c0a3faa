"""The runner of all checks: nothing is skipped and no failure is lost."""

import sys

import pytest

from tests import run_all


def step(name: str, code: str) -> run_all.Step:
    return run_all.Step(name, [sys.executable, "-c", code])


@pytest.fixture
def _browser_is_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_all, "find_browser", lambda: "/somewhere/chromium")
    monkeypatch.setattr(run_all, "browser_commands", list)


@pytest.mark.usefixtures("_browser_is_here")
def test_what_runs_beside_the_others_is_told_after_them(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    beside = step("beside", "print('wrong'); raise SystemExit(2)")._replace(beside=True)
    monkeypatch.setattr(run_all, "steps", lambda words: [beside, step("own", "print('ran')")])
    assert run_all.main([]) == 1
    shown = capfd.readouterr().out
    assert shown.index("ran") < shown.index("wrong") < shown.index("==== Summary")
    assert "FAILED  beside" in shown


@pytest.mark.usefixtures("_browser_is_here")
@pytest.mark.parametrize("code", [0, 3])
def test_what_is_quiet_speaks_where_it_fails(
    code: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    quiet = step("quiet", f"print('wor' 'ds'); raise SystemExit({code})")._replace(quiet=True)
    monkeypatch.setattr(run_all, "steps", lambda words: [quiet])
    assert run_all.main([]) == bool(code)
    assert ("words" in capfd.readouterr().out) is bool(code)


def test_what_a_process_imports_stays_compiled(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    run_all.carry_out(step("asked", "import sys; print(sys.dont_write_bytecode)"))
    assert capfd.readouterr().out == "False\n"


@pytest.mark.usefixtures("_browser_is_here")
@pytest.mark.parametrize(("middle", "code"), [("pass", 0), ("raise SystemExit(3)", 1)])
def test_one_failure_fails_the_whole_but_stops_nothing(
    middle: str, code: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    three = [step("first", "pass"), step("second", middle), step("third", "print('ran')")]
    monkeypatch.setattr(run_all, "steps", lambda words: three)
    assert run_all.main([]) == code
    shown = capfd.readouterr().out
    assert "ran" in shown
    summary = shown[shown.index("==== Summary") :]
    assert ("FAILED  second" in summary) is (code == 1)
    assert "passed  third" in summary


def test_a_browser_that_cannot_be_had_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_all, "find_browser", lambda: None)
    monkeypatch.setattr(run_all, "browser_commands", lambda: [["false"], ["true"]])
    monkeypatch.setattr(run_all, "steps", lambda words: [])
    assert run_all.main([]) == 1


@pytest.mark.parametrize(
    ("here", "tried"),
    [((), ["light", "full"]), (("full",), ["light"]), (("light",), []), (("full", "light"), [])],
)
def test_the_browser_without_windows_is_tried_for_where_another_is_there(
    here: tuple[str, ...],
    tried: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(run_all, "SHELL", "light")
    monkeypatch.setattr(run_all.shutil, "which", lambda name: name if name in here else None)
    monkeypatch.setattr(run_all, "find_browser", lambda: here[0] if here else None)
    monkeypatch.setattr(run_all, "browser_commands", lambda: [["echo", "light"], ["echo", "full"]])
    assert run_all.ensure_browser() is bool(here)
    said = capfd.readouterr().out.splitlines()
    assert [line for line in said if line in ("light", "full")] == tried


def test_every_tool_takes_its_turn_and_pytest_the_extra_words() -> None:
    steps = run_all.steps(["-k", "one"])
    assert [each.name for each in steps] == [
        "ruff check",
        "ruff format",
        "pyright",
        "lint-imports",
        "wheel",
        "pytest",
    ]
    assert steps[-1].command[-2:] == ["-k", "one"]
    assert [each.name for each in run_all.steps([])][-2:] == ["collect", "pytest"]


def test_quick_checks_need_no_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_all, "find_browser", lambda: None)
    monkeypatch.setattr(run_all, "quick_steps", lambda: [step("only", "pass")])
    assert run_all.main(["--quick"]) == 0


def test_the_rooms_of_the_quick_checks_are_there() -> None:
    assert all((run_all.ROOT / "tests" / room).is_dir() for room in run_all.QUICK_ROOMS)
