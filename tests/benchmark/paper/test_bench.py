from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.paper import bench as paper
from physagent_studio.benchmark.paper.listing import events, write_case
from physagent_studio.benchmark.paper.pictures import click_on, said_of_scenes, taken
from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case


@pytest.mark.parametrize("scene", ["curling"])
def test_a_scene_is_a_case_that_a_person_could_bring(scene: str, tmp_path: Path) -> None:
    case = load_case(write_case(scene, tmp_path))
    shot = taken(scene)
    assert case.image is not None
    np.testing.assert_array_equal(case.image, shot.image)
    asked = {prop.name for prop in shot.props if prop.asked}
    assert {name for name, _ in case.objects} == asked
    for name, grounding in case.objects:
        (click,) = grounding.points
        assert shot.masks[name][int(click.y), int(click.x)]
        assert grounding.box is not None
    for prop in shot.props:
        low, high = (np.array(prop.thing.bounds)[:, 2]).tolist()
        assert low >= -1e-9, "nothing is below the ground, which is drawn behind all things"
        assert high > low
    written = {path.stem for path in (tmp_path / "references").glob("*.yaml")}
    assert written == {f"{scene}__{event.name}" for event in events() if event.scene == scene}


def test_a_picture_is_drawn_once_until_its_lines_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = write_case("balloon", tmp_path)
    first = (case / "input.png").read_bytes()
    monkeypatch.setattr("physagent_studio.benchmark.paper.pictures.taken", _never)
    assert write_case("balloon", tmp_path) == case
    (case / "drawn_from.txt").write_text("another")
    with pytest.raises(AssertionError):
        write_case("balloon", tmp_path)
    assert (case / "input.png").read_bytes() == first


def _never(scene: str) -> None:
    raise AssertionError(scene)


def test_a_click_lies_near_the_middle_of_what_is_seen() -> None:
    mask = np.zeros((50, 80), bool)
    mask[10:30, 20:60] = True
    assert np.hypot(*(np.array(click_on(mask)) - (39.5, 19.5))) < 5
    mask[15:28, 25:55] = False
    x, y = click_on(mask)
    assert mask[y, x]


def test_every_scene_has_a_seed_of_its_own_from_3000_on() -> None:
    seeds = [paper.DRAWN + k for k in range(len(said_of_scenes()["scenes"]))]
    from physagent_studio.benchmark.paper.pictures import seed_of

    assert [seed_of(name) for name in said_of_scenes()["scenes"]] == seeds


# --- the bench ---------------------------------------------------------------------------------


def result(task: EventTask, **fields: Any) -> EventResult:
    report = {"realised": True, "outcome": "realised", "rounds": 3, "seconds": 1.0, "view": []}
    report |= {"simulations": 2, "contract": [], "physics": [], "untested": []}
    told = {"reference_holds": True, "passed_in": 2} | fields
    return EventResult(task.label, "", False, task.variant, report, **told)


Runs = list[EventTask]


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Runs:
    """Events that are not run: half of them pass at once, every third is denied."""
    asked: Runs = []

    def run(task: EventTask) -> list[EventResult]:
        asked.append(task)
        number = len(asked)
        held = number % 3 != 0
        return [
            result(task, reference_holds=held, passed_in=1 + number % 2, at_once=number % 2 == 0)
        ]

    def case(scene: str, folder: Path) -> Path:
        path = folder / "cases" / scene
        path.mkdir(parents=True, exist_ok=True)
        for name in ("case.yaml", "input.png"):
            (path / name).write_text(scene)
        references = folder / "references"
        references.mkdir(exist_ok=True)
        for event in events():
            (references / f"{event.scene}__{event.name}.yaml").write_text(event.prompt)
        return path

    monkeypatch.setattr(paper, "run_apart", run)
    monkeypatch.setattr(paper, "write_case", case)
    return asked


def value(rows: list, name: str) -> Any:
    return next(row.value for row in rows if row.name == name)


def test_the_tables_count_what_came_out_and_a_second_run_goes_on(
    runs: Runs, tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    bench: Callable = paper.bench
    rows = bench(cases=None, out=page, sheets=tmp_path / "s", count=6, variants=("full",))
    assert len(runs) == 6
    assert value(rows, "rules, with reflection: realised of 6") == 4
    assert value(rows, "rules, with reflection: rounds, mean") == 1.5
    assert value(rows, "rules, without reflection: realised of 6") == 3
    assert value(rows, "reflection gains") == pytest.approx(100 / 6)
    assert value(rows, "claimed, but the reference denies it") == 2
    text = page.read_text(encoding="utf-8")
    assert "4 of 6 (67 %)" in text
    assert text.count("\n### ") == 6
    again = bench(cases=None, out=None, sheets=tmp_path / "s", count=6, variants=("full",))
    assert len(runs) == 6
    assert again == rows
    bench(cases=None, out=None, sheets=tmp_path / "s", count=6)
    assert [task.variant for task in runs[6:]] == ["no_semantics"] * 6


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no event or scene called moon"):
        paper.bench(cases=None, out=None, only=("moon",))
    with pytest.raises(InputError, match="no variant 'best'"):
        paper.bench(cases=None, out=None, variants=("best",))
    with pytest.raises(InputError, match="draws its own pictures"):
        paper.bench(cases=tmp_path, out=None)


def test_a_small_dose_is_the_same_each_time_and_part_of_a_larger_one() -> None:
    labels = [event.label for event in paper.chosen_events((), 5)]
    assert labels == [event.label for event in paper.chosen_events((), 5)]
    assert set(labels) <= {event.label for event in paper.chosen_events((), 20)}


@pytest.mark.slow
def test_the_first_round_is_the_run_without_reflection(tmp_path: Path) -> None:
    case = write_case("mug_on_table", tmp_path)
    for event in ("pushed_off", "slides_left"):
        reference = tmp_path / "references" / f"mug_on_table__{event}.yaml"
        task = EventTask(case, event, None, reference)
        (full,) = run_apart(task)
        (once,) = run_apart(EventTask(case, event, None, reference, "no_reflection"))
        assert full.at_once == once.realised == once.at_once
