"""Handler files of the peers' releases, read from their syntax tree."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import load_peer_config
from physagent_studio.exchange.peers.effects import Schedule
from physagent_studio.exchange.peers.handler import parsed, read_handler
from physagent_studio.program import PhysicalProgram, SceneObject, SceneState, apply
from physagent_studio.program.scene.state import Sphere

FORCES = """
import os
os.mkdir("was_run")
class Ball(CaseHandler):
    def __init__(self, config, all_obj_info, device):
        super().__init__(config, all_obj_info, device)
        self.done = False

    def custom_simulation(self, sid):
        left = np.array([-1.0, 0.0, 0.0])
        push = (100 * left / np.linalg.norm(left)).reshape(1, 3)
        if sid <= 5:
            self.all_objs[1].solver.apply_links_external_force(force=push, links_idx=[1])
        a, b = 0, 1
        if sid == 0 and not self.done:
            self.done = True
            quick = np.array([0.8, 0.0, 0.0, 0.0, -4.0, 0.0], dtype=np.float32)
            self.all_objs[0].set_dofs_velocity(velocity=quick, dofs_idx_local=np.arange(6))
        if 10 <= sid < 14:
            here = self.all_objs[0].get_pos().cpu().numpy()
            there = self.all_objs[1].get_pos().cpu().numpy()
            way = there - here
            way = way / (np.linalg.norm(way) + 1e-8)
            self.all_objs[0].solver.apply_links_external_force(force=way.reshape(1, 3) * 2.5)
        if self.all_objs[0].get_pos()[2] < 0.3:
            self.all_objs[0].set_pos(np.array([0, 0, 1]))

    def fix_particles(self):
        self.scene.pin(3)

    def add_entities_to_scene(self, scene, materials, modes):
        self.all_obj_info[0]['center'][2] += 0.025
        return super().add_entities_to_scene(scene, materials, modes)
"""
ACTIONS = """
class Ball(ActionCaseHandler):
    object_names = ["red ball", "can"]
    def build_actions(self):
        return [
            SetVelocity("red ball", [1, 0, 0]),
            ApplyForce("can", DirectionTo("red_ball", 3.0), duration=5, frame=10),
            ApplyAngledForce(0, 2.0, 90, duration=4),
            ApplyDisturbance("obj_1", "shake", 0.4, duration=20),
            SetOrientation(name=0, rotation=[0, 0, 90], frame=3),
            FixObject("can", 12),
        ]
"""


def schedule_of(text: str) -> Schedule:
    return parsed(text, "ball.py", 2, 160, {"dt": 0.01}, ())


def test_forces_velocities_and_lifts_step_by_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = schedule_of(FORCES)
    assert not list(tmp_path.iterdir()), "it was run"
    assert found.actions == [
        {
            "operator": "ApplyForce",
            "object": 1,
            "start_step": 0,
            "force": [-100.0, 0.0, 0.0],
            "duration": 6,
        },
        {"operator": "SetVelocity", "object": 0, "start_step": 0, "velocity": [0.8, 0, 0]},
        {
            "operator": "SetAngularVelocity",
            "object": 0,
            "start_step": 0,
            "angular_velocity": [0.0, -4.0, 0.0],
        },
        {
            "operator": "ApplyForce",
            "object": 0,
            "start_step": 10,
            "force": {"magnitude": 2.5, "toward": 1, "horizontal": False},
            "duration": 4,
        },
    ]
    assert found.lifts == {0: [0.0, 0.0, 0.025]}


def test_what_has_no_counterpart_is_listed_with_its_line() -> None:
    found = schedule_of(FORCES)
    assert [one.split(":")[0] for one in found.left_out] == ["line 28", "line 14", "line 25"]
    assert "fix_particles" in found.left_out[0]
    assert "get_pos" in found.left_out[2]


def test_actions_by_name() -> None:
    found = schedule_of(ACTIONS)
    assert [one["operator"] for one in found.actions] == [
        "SetVelocity",
        "ApplyForce",
        "ApplyAngledForce",
        "ApplyDisturbance",
        "SetOrientation",
        "FixObject",
    ]
    assert [one["object"] for one in found.actions] == [0, 1, 0, 1, 0, 1]
    assert found.actions[1]["force"] == {"magnitude": 3.0, "toward": 0, "horizontal": False}
    assert found.actions[4]["rotation"] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])
    assert len(found.left_out) == 1


def test_a_configuration_with_its_handler_becomes_a_valid_program(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "input.png"), np.full((48, 64, 3), 90, np.uint8))
    (tmp_path / "handler.py").write_text(FORCES)
    (tmp_path / "config.yaml").write_text(
        "all_object_points: [[[20, 20, 1]], [[40, 20, 1]]]\nmaterial_type: [rigid, rigid]\n"
        "dt: 0.005\nframe_steps: 2\nsimulated_frames_num: 6\n"
    )
    setup = load_peer_config(tmp_path / "config.yaml", names=["ball", "can"])
    things = [
        SceneObject(name=name, shape=Sphere(radius=0.1), position=(x, 2.0, 0.1))
        for name, x in (("ball", 0.0), ("can", 0.5))
    ]
    program = PhysicalProgram(scene=SceneState(objects=tuple(things)))
    made = apply(program, setup.edits_of_scheduled(program))
    assert (made.clip.steps, made.clip.step_seconds) == (10, 0.005)
    assert [action.name for action in made.event.actions] == ["can", "ball", "ball"]
    ball = made.scene.object("ball")
    assert ball is not None
    assert ball.position == pytest.approx((0.0, 2.0, 0.125))
    assert any("fix_particles" in line for line in setup.left_out)


@pytest.mark.parametrize(
    "text",
    [
        "class A(B):\n def custom_simulation(self, sid):\n  x = " + "(" * 5000,
        "x = 1\n",
        "class A(B):\n def custom_simulation(self, s):\n  for a in range(999):\n"
        "   for b in range(999):\n    for c in range(999):\n     d = a + b + c\n",
        "class A(B):\n def custom_simulation(self, s):\n  x = " + "+".join(["1"] * 20000),
    ],
    ids=["nested", "no class", "loops", "long"],
)
def test_hostile_files_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "handler.py").write_text(text)
    with pytest.raises(InputError, match=r"handler\.py"):
        read_handler(tmp_path / "handler.py", 2, 100, {}, ())


def test_powers_and_unknown_calls_are_not_computed() -> None:
    text = (
        "class A(B):\n def custom_simulation(self, s):\n  x = 9 ** 9 ** 9\n"
        "  y = __import__('os').getcwd()\n  self.all_objs[0].set_pos(np.array([x, 0, 0]))\n"
    )
    found = parsed(text, "a.py", 1, 3, {}, ())
    assert found.actions == []
    assert len(found.left_out) == 3
