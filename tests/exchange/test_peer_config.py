"""Configurations of the peers' releases, read as cases and edits."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case, load_peer_config
from physagent_studio.program import PhysicalProgram, SceneObject, SceneState, Support, apply
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
