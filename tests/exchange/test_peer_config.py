"""Configurations of the peers' releases, read as cases and edits."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from physagent_studio.errors import InputError
from physagent_studio.exchange import PeerSetup, load_case, load_peer_config
from physagent_studio.exchange.peer_config import _BODIES
from physagent_studio.exchange.prior.peer_config import config_of
from physagent_studio.program import (
    PhysicalProgram,
    SceneObject,
    SceneState,
    SetField,
    Support,
    apply,
)
from physagent_studio.program.program import EventProgram
from physagent_studio.program.scene.bodies import Soft

CONFIG = """\
example_name: jelly on ramp
all_object_points: [[[20, 20, 1], [22, 30, 0]], [[40, 20, 1]]]
support_object_points: [[[10, 40, 1]]]
support_object_names: [clear ramp]
material_type: [mpm_elastic, rigid]
MPM_E: 1e5
MPM_nu: 0.3
MPM_rho: 650.0
rigid_rho: 800.0
rigid_friction: 0.35
plane_friction: 0.6
fixed_area:
- [0, 1, 0.8, 1.0]
dt: 0.005
substeps: 20
frame_steps: 2
simulated_frames_num: 81
gravity: -1
foam_initial_velocity_x: 2.8
vgen_prompt: A strong gust
  blows from the side.
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    picture = np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "input.png"), picture)
    (tmp_path / "config.yaml").write_text(CONFIG)
    return tmp_path / "config.yaml"


def test_everything_that_has_a_place(config: Path):
    setup = load_peer_config(config, names=["jelly", "stone"])
    case = setup.case
    assert case.name == "jelly_on_ramp"
    assert [name for name, _ in case.objects] == ["jelly", "stone"]
    assert [c.label for c in case.objects[0][1].points] == [1, 0]
    assert [s.name for s in case.supports] == ["clear_ramp"]
    assert case.prompt == "A strong gust blows from the side."
    assert setup.left_out == ("foam_initial_velocity_x",)
    config.write_text(CONFIG.replace("mpm_elastic", "mpm_sand"))
    # Sand has no stiffness here, and nothing holds it.
    unused = {"MPM_E", "MPM_nu", "fixed_area", "foam_initial_velocity_x"}
    assert set(load_peer_config(config).left_out) == unused

    objects = tuple(SceneObject(name=name, grounding=g) for name, g in case.objects)
    scene = SceneState(objects=objects, supports=(*case.supports, Support(name="floor")))
    bare = PhysicalProgram(scene=scene)
    program = apply(bare, setup.edits(bare))
    assert program.clip.frames == 81
    assert (program.clip.step_seconds, program.clip.steps_per_frame) == (0.005, 2)
    assert program.clip.substeps == 20
    assert program.scene.gravity == (0, 0, -1)
    jelly, stone = program.scene.objects
    assert isinstance(jelly.body, Soft)
    assert (jelly.body.young, jelly.body.poisson, jelly.body.pinned) == (1e5, 0.3, "bottom")
    assert jelly.density == 650
    assert (stone.density, stone.friction, stone.body.kind) == (800, 0.35, "rigid")
    floor = program.scene.support("floor")
    assert floor is not None
    assert floor.friction == 0.6


def test_names_are_made_where_none_are_given(config: Path):
    setup = load_peer_config(config)
    assert [name for name, _ in setup.case.objects] == ["object_1", "object_2"]
    with pytest.raises(InputError, match="has 2 objects"):
        load_peer_config(config, names=["one"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[mpm_elastic, rigid]", "[mpm_elastic, wood]", "line 5: there is no material 'wood'"),
        ("[mpm_elastic, rigid]", "[rigid]", "line 5: material_type must list 2 materials"),
        ("material_type", "materials", "no configuration of these releases"),
        ("[40, 20, 1]", "[400, 20, 1]", "line 2: the click .400, 20. lies outside"),
        ("[40, 20, 1]", "[40, 20]", "line 2: a point of all_object_points must be"),
        ("gravity: -1", "gravity: .nan", "line 18: gravity must be finite"),
        ("dt: 0.005", "dt: fast", "line 14: dt must be a number"),
        ("- [0, 1, 0.8, 1.0]", "- [0, 1]", "fixed_area must be a list of"),
    ],
)
def test_refusals_say_where(config: Path, old: str, new: str, message: str):
    assert old in CONFIG
    config.write_text(CONFIG.replace(old, new))
    with pytest.raises(InputError, match=message):
        load_peer_config(config)


def test_no_photo_beside_it(config: Path):
    (config.parent / "input.png").unlink()
    with pytest.raises(InputError, match="no photo beside"):
        load_peer_config(config)


def test_real_configurations(cases_dir: Path):
    found = sorted(cases_dir.glob("*/peer_config.yaml"))
    assert len(found) >= 8
    for path in found:
        names = [name for name, _ in load_case(path.parent).objects]
        count = len(load_peer_config(path).case.objects)
        setup = load_peer_config(path, names=names if len(names) == count else ())
        objects = tuple(SceneObject(name=n, grounding=g) for n, g in setup.case.objects)
        bare = PhysicalProgram(scene=SceneState(objects=objects))
        program = apply(bare, setup.edits(bare))
        assert program.clip.frames in (81, 165)
        assert setup.case.prompt


def scene_of(path: Path) -> tuple[PeerSetup, PhysicalProgram]:
    setup = load_peer_config(path)
    objects = tuple(SceneObject(name=n, grounding=g) for n, g in setup.case.objects)
    scene = SceneState(objects=objects, supports=(*setup.case.supports, Support(name="floor")))
    bare = PhysicalProgram(scene=scene, event=EventProgram(prompt=setup.case.prompt))
    return setup, apply(bare, setup.edits(bare))


CARRIED = (
    *("all_object_points", "support_object_points", "gravity", "dt"),
    *("substeps", "frame_steps", "simulated_frames_num", "rigid_rho", "MPM_rho"),
    *("pbd_elastic_rho", "rigid_friction", "plane_friction"),
)


def flat(value: object) -> list[float]:
    if isinstance(value, list):
        return [number for part in value for number in flat(part)]
    return [float(str(value))]


def exported_and_read(path: Path, into: Path) -> tuple[list[str], dict, dict]:
    """A configuration, what is exported of its program, and that the program is the same again."""
    _, program = scene_of(path)
    data, left_out = config_of(program, None)
    shutil.copy(path.parent / "input.png", into / "input.png")
    (into / "config.yaml").write_text(yaml.safe_dump(data))
    again, twice = scene_of(into / "config.yaml")
    assert twice == program
    assert not again.left_out or again.left_out == ("fixed_area",)
    before = yaml.safe_load(re.sub(r"(\d)e(\d)", r"\1.0e+\2", path.read_text()))
    return left_out, before, data


def test_exported_again_it_carries_the_same_values(config: Path, tmp_path_factory):
    left_out, before, after = exported_and_read(config, tmp_path_factory.mktemp("again"))
    assert left_out == []
    assert after["material_type"] == before["material_type"]
    for key in (*CARRIED, "MPM_E", "MPM_nu"):
        if key in before:
            assert flat(after[key]) == pytest.approx(flat(before[key])), key
    assert after["vgen_prompt"] == " ".join(before["vgen_prompt"].split())


def test_what_their_format_cannot_say_is_named(config: Path):
    _, program = scene_of(config)
    other = SetField(path="scene.objects.object_1.body", value={"kind": "rigid"})
    heavy = SetField(path="scene.objects.object_2.density", value=2000.0)
    rope = SetField(path="scene.objects.object_2.body", value={"kind": "rope"})
    _, left_out = config_of(apply(program, [other, heavy]), None)
    assert left_out == ["rigid_rho of object_2 (2000)"]
    assert "rope" not in config_of(apply(program, [rope]), None)[0]["material_type"]
    assert "object_2 is of a kind" in config_of(apply(program, [rope]), None)[1][0]


def test_real_configurations_carry_the_same_values_again(cases_dir: Path, tmp_path: Path):
    found = sorted(cases_dir.glob("*/peer_config.yaml"))
    assert len(found) == 9
    for path in found:
        into = tmp_path / path.parent.name
        into.mkdir()
        _, before, after = exported_and_read(path, into)
        for key in CARRIED:
            if key in before and before[key] is not None:
                assert flat(after[key]) == pytest.approx(flat(before[key])), (path, key)
        kinds = [[_BODIES[one] for one in data["material_type"]] for data in (before, after)]
        assert kinds[0] == kinds[1]
