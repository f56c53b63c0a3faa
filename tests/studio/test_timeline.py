"""The timeline's values: labels with their units, and what starts a conditional action."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.program import Clip, Directed
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.text.document import load_program
from physagent_studio.program.timing import PACE, clip_at
from physagent_studio.records import Check
from physagent_studio.session import Store
from physagent_studio.simulation import simulate
from physagent_studio.studio.panels.timeline import Pacings, choice_of, label_of, pace_of, state_of
from physagent_studio.workbench import Snapshot, Workbench, commands

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.5], support: air}
    - {name: cube, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [1, 2, 0.1], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball falls, then the cube goes.
  actions:
    - operator: ApplyForce
      id: shove
      name: cube
      force: {magnitude: 2, direction: right, quantity: target_speed}
      duration: 20
      when: {kind: on_contact, a: ball, b: floor, delay: 8}
    - operator: SetVelocity
      id: hop
      name: cube
      velocity: [0, 0, 1]
      when: {kind: after, action: shove, delay: 10}
    - operator: ApplyTorque
      id: never
      name: ball
      torque: [0, 0, 0.1]
      duration: 10
      when: {kind: on_contact, a: ball, b: cube}
clip: {frames: 41}
"""

FLEEING = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0.5, 3, 0.1], support: floor}
    - {name: cube, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [-0.5, 3, 0.1],
       support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  actions:
    - {operator: SetVelocity, id: kick, name: ball, start_step: 20, velocity: [3, 0, 0]}
"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Snapshot]:
    workbench = Workbench(Store(tmp_path_factory.mktemp("timeline")), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM)))
    assert workbench.wait(60)
    yield workbench.snapshot()
    workbench.close()


def _bars(snapshot: Snapshot) -> dict[str, Any]:
    lanes = state_of(snapshot)["lanes"]
    return {bar["id"]: bar for lane in lanes for bar in lane["actions"]}


def test_a_condition_tells_where_its_cause_lies(shown: Snapshot) -> None:
    bars = _bars(shown)
    shove, hop = bars["shove"], bars["hop"]
    assert shown.rollout is not None
    contacts = shown.rollout.contacts
    touched = int(contacts["step"][contacts["a"] == shown.rollout.index("ball")].min())
    assert shove["when"]["lane"] == "ball"
    assert shove["when"]["step"] == touched
    assert shove["fired"] == touched + 1 + 8
    assert shove["start"] == shove["fired"]
    # One action after another: the link comes from the end of the first.
    assert hop["when"]["lane"] == "cube"
    assert hop["when"]["step"] == shove["fired"] + 20
    assert hop["fired"] == hop["when"]["step"] + 10


def test_what_never_started_has_no_place(shown: Snapshot) -> None:
    never = _bars(shown)["never"]
    assert never["never"]
    assert never["fired"] is None
    assert never["when"]["step"] is None


def test_labels_say_what_the_number_is(shown: Snapshot) -> None:
    bars = _bars(shown)
    assert bars["shove"]["label"] == "Push to 2 m/s"
    assert bars["hop"]["label"] == "Set velocity 1 m/s"
    assert bars["never"]["label"] == "Twist 0.1 N·m"


@pytest.mark.parametrize(
    ("force", "label"),
    [
        (act.against(0.168), "Slow down 0.168 m/s²"),
        (act.toward_or_along(0.0, way="left"), "Slow down to 0 m/s"),
        (act.toward_or_along(0.3, way="left"), "Push to 0.3 m/s"),
    ],
)
def test_a_brake_is_named_as_one(force: Directed, label: str) -> None:
    assert label_of(act.push("cube", force)) == label


def test_what_leaves_the_picture_and_what_moves_is_on_the_timeline() -> None:
    program = load_program(FLEEING)
    camera = Camera.from_horizon((832, 480), 200, 0.8)
    scene = program.scene.model_copy(update={"camera": camera})
    program = program.model_copy(update={"scene": scene})
    rollout = simulate(program, {})
    pacings = Pacings()
    pacing = pacings.of(program, rollout)
    assert pacing is not None
    ((name, frame),) = pacing.crossings
    failed = Check(
        id="view.inside.ball", text="", ok=False, measured=None, threshold=None, unit="",
        margin=-1, kind="view", always_on=True,
    )  # fmt: skip
    shown = Snapshot(revision=0, program=program, rollout=rollout, checks=(failed,))
    found = state_of(shown, pacing)
    ball, cube = found["lanes"]
    assert (name, cube["leaves"]) == ("ball", None)
    assert ball["leaves"]["step"] == frame * program.clip.steps_per_frame
    assert ball["leaves"]["ok"] is False
    assert f"s on (frame {frame})" in ball["leaves"]["text"]
    moves = found["pace"]["moves"]
    # It is set going on step 20, and is no longer seen to move once it has left.
    assert 20 - program.clip.steps_per_frame <= moves["first"] <= 20
    assert moves["first"] < moves["last"] <= ball["leaves"]["step"] + program.clip.steps_per_frame
    # Going back and forth over the same run measures it once.
    assert pacings.of(program, rollout) is pacing
    assert pacings.of(program, None) is None


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1.0, "real time"),
        (0.4, "0.4 × real time"),
        (1 / 3, "0.33 × real time"),
        (2.0, "2 × real time"),
    ],
)
def test_the_pace_in_words(factor: float, words: str) -> None:
    clip = clip_at(Clip(), factor)
    found = pace_of(clip, None, None, ())
    assert (found["text"], found["pinned"], found["moves"]) == (words, False, None)
    assert found["length"].startswith("3.2 s at 25 frames a second")
    assert pace_of(clip, None, None, PACE)["pinned"]
    chosen = [one["factor"] for one in choice_of(clip, ())["offered"] if one["on"]]
    assert chosen == ([factor] if factor in (1.0, 1 / 3) else [])
