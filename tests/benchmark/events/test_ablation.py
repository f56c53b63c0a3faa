"""The ablation: three variants, over photographs and over the bundled scenes."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark import run_bench
from physagent_studio.benchmark.events import ablation
from physagent_studio.benchmark.events.bare_scenes import load_bare_scene
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_event
from physagent_studio.benchmark.events.variants import VARIANTS, variant_of
from physagent_studio.benchmark.rows import Row
from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import SceneState

SCENES = sorted((assets_dir() / "scenes").glob("*.yaml"))
REPORT = {
    "realised": True, "outcome": "realised", "rounds": 2, "simulations": 7, "seconds": 4.0,
    "cpu_seconds": 3.0, "contract": [], "diagnosis": [], "untested": [], "not_understood": [],
}  # fmt: skip


def result(label: str, variant: str, **report: object) -> EventResult:
    return EventResult(label, "It falls.", False, variant, {**REPORT, **report})


def value(rows: list[Row], name: str) -> object:
    (found,) = [row.value for row in rows if row.name.startswith(name)]
    return found


def test_the_bundled_scenes_are_those_of_the_tests(repository: Path):
    path = repository / "tools" / "dump_bare_scenes.py"
    spec = importlib.util.spec_from_file_location("dump_bare_scenes", path)
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    written = {path.stem: path.read_text(encoding="utf-8") for path in SCENES}
    assert written == tool.scenes(), "run python tools/dump_bare_scenes.py"


def test_there_are_sixty_prompts_and_more():
    groups = ablation.prompts_of(assets_dir() / "scenes")
    assert sum(len(group) for group in groups) >= 60
    assert all(len(group) == 5 for group in groups)


@pytest.mark.parametrize("path", SCENES, ids=[path.stem for path in SCENES])
def test_an_open_state_is_filled_from_the_scene(path: Path):
    bare = load_bare_scene(path)
    opened = SceneState(
        objects=tuple(
            item.model_copy(update={"shape": None, "position": None, "support": None})
            for item in bare.scene.objects
        ),
        supports=tuple(s.model_copy(update={"shape": None}) for s in bare.scene.supports),
    )
    filled = bare.filled(opened)
    assert filled.is_resolved
    assert filled.objects == bare.scene.objects
    assert filled.supports == bare.scene.supports
    assert bare.filled(filled) == filled


def test_what_is_no_scene_is_said(tmp_path: Path):
    for text in ("[]", "scene: {}\nprompts: {}\n", "prompts: {a: [b]}\n"):
        (tmp_path / "bad.yaml").write_text(text)
        with pytest.raises(InputError, match="is no scene with prompts"):
            load_bare_scene(tmp_path / "bad.yaml")


@pytest.mark.parametrize("variant", list(VARIANTS))
def test_each_variant_runs_a_prompt(variant: str):
    path = assets_dir() / "scenes" / "desk.yaml"
    outcome = run_event(EventTask(path, "cube_off#1", variant=variant))
    assert outcome.label == "desk/cube_off#1"
    assert outcome.prompt.startswith("A push to the right")
    assert outcome.report["outcome"] in ("realised", "budget", "stuck")
    assert outcome.report["rounds"] <= VARIANTS[variant].rounds


def test_without_reflection_there_is_one_round():
    path = assets_dir() / "scenes" / "desk.yaml"
    outcome = run_event(EventTask(path, "cup_stops#0", variant="no_reflection"))
    assert (outcome.report["rounds"], outcome.report["simulations"]) == (1, 1)


def test_an_unknown_variant_lists_the_known():
    with pytest.raises(InputError, match="full, no_reflection, no_semantics"):
        variant_of("half")


def test_counts_are_per_group_and_variant():
    rows = ablation.figures(
        [
            result("a/b", "full"),
            result("a/b", "no_reflection", realised=False, outcome="budget", rounds=1),
            result("a/b", "no_semantics", rounds=6),
            result("desk/x#0", "full"),
            result("desk/x#0", "no_reflection", realised=False, outcome="budget"),
            result("desk/x#0", "no_semantics", realised=False, outcome="stuck"),
        ]
    )
    assert value(rows, "photographs, full: realised of 1") == 1
    assert value(rows, "photographs, without reflection: realised of 1") == 0
    assert value(rows, "photographs, without the semantic actions: rounds per realised") == 6
    assert value(rows, "photographs: full ahead") == 0
    assert value(rows, "prompts: full ahead") == 1


def test_a_lead_of_another_variant_fails_the_bench():
    rows = ablation.figures(
        [
            result("a/b", "full", realised=False),
            result("a/b", "no_reflection"),
            result("a/b", "no_semantics"),
        ]
    )
    (lead,) = [row for row in rows if "ahead" in row.name]
    assert (lead.value, lead.ok) == (-1, False)


def test_the_page_has_a_row_per_event():
    several = [result(f"desk/x#{k}", "full", realised=k < 3) for k in range(5)]
    other = [
        replace(item, variant=name)
        for item in several
        for name in ("no_reflection", "no_semantics")
    ]
    single = [result("a/b", name) for name in VARIANTS]
    text = ablation.page([*several, *other, *single])
    assert "| desk/x | 3 of 5 wordings, 2 rounds, 35 runs |" in text
    assert "| a/b | **realised**, 2 rounds, 7 runs |" in text


def test_nothing_by_that_name_is_said():
    with pytest.raises(InputError, match="no event or scene that is called nowhere"):
        run_bench("ablation", cases=None, out=None, only=["nowhere"])
