"""MJCF and URDF as programs, held against MuJoCo itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange.peers.mjcf import load_mjcf
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case
from physagent_studio.simulation import simulate

SCENE = """
<mujoco>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 .1"/>
    <geom name="table" type="box" pos="1 2 .25" size=".3 .2 .25" euler="0 0 30"/>
    <body name="ball" pos="0 2 1"><freejoint/><geom type="sphere" size=".1" mass=".5"/></body>
    <body name="crate" pos="1 2 .7" euler="0 0 10"><freejoint/>
      <geom type="box" size=".1 .05 .08" density="300"/></body>
    <body name="door" pos="3 2 1"><joint type="hinge"/><geom type="box" size=".1 .1 .1"/></body>
  </worldbody>
</mujoco>
"""


def test_it_falls_as_in_mujoco(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(SCENE)
    program, left_out = load_mjcf(tmp_path / "scene.xml")
    assert left_out == ("door: a body with joints",)
    assert [item.name for item in program.scene.supports] == ["ground", "table"]
    case = Case("scene", None, "", (), (), (), "")
    scene = reconstruct(case, program.scene)
    ours = simulate(program.model_copy(update={"scene": scene.state}), scene.meshes)
    mj: Any = mujoco
    model = mj.MjModel.from_xml_string(SCENE)
    data = mj.MjData(model)
    while data.time < 0.3 - 1e-9:
        mj.mj_step(model, data)
    step = round(0.3 / ours.step_seconds)
    assert np.abs(ours.positions[step, 0] - data.body("ball").xpos).max() < 0.01
    assert ours.masses[0] == pytest.approx(0.5, rel=1e-6)
    assert ours.masses[1] == pytest.approx(model.body("crate").mass[0], rel=1e-6)
    # On the table, turned as there.
    assert ours.positions[-1, 1] == pytest.approx([1, 2, 0.58], abs=0.01)


def test_urdf_comes_in_too(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(
        '<robot name="a"><link name="base"><collision><geometry><box size=".2 .2 .2"/></geometry>'
        "</collision></link></robot>"
    )
    program, _ = load_mjcf(tmp_path / "a.urdf")
    assert len(program.scene.supports) + len(program.scene.objects) == 1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<mujoco><include file='scene.xml'/></mujoco>", "include"),
        ("<mujoco><asset><mesh name='m' file='/etc/passwd'/></asset></mujoco>", "outside"),
        ("<mujoco><asset><mesh name='m' file='../a.stl'/></asset></mujoco>", "outside"),
        ("<mujoco><asset><mesh name='m' file='a.txt'/></asset></mujoco>", "there is no"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><mujoco/>", "entities"),
        ("<mujoco><worldbody>", "no XML"),
        (SCENE.replace("0 2 1", "nan 2 1"), "scene.xml"),
        (
            "<mujoco><worldbody><replicate count='100000000'><geom size='1'/></replicate>"
            "</worldbody></mujoco>",
            "scene.xml",
        ),
    ],
)
def test_hostile_scenes_are_refused(text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(text)
    with pytest.raises(InputError, match=told):
        load_mjcf(tmp_path / "scene.xml")
