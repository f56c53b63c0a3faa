"""The stage over a real viser server: what it draws is what the snapshot says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene import state as shapes
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Check, Mesh, Round
from physagent_studio.session import Store
from physagent_studio.studio.guard import open_server, stop_server
from physagent_studio.studio.library import fits, with_ghosts
from physagent_studio.studio.scene.deforming import colours_of
from physagent_studio.studio.scene.places import held_at
from physagent_studio.studio.scene.stage import Hands, Stage
from physagent_studio.studio.view import View
from physagent_studio.sweep import Ran
from physagent_studio.sweep.robustness import Robustness
from physagent_studio.workbench import Snapshot, Workbench, commands
from physagent_studio.workbench.probing import Probed

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 1.5, 0.1], support: floor}
    - name: cloth
      shape: {kind: box, size: [0.4, 0.4, 0.01]}
      position: [0, 1.5, 0.4]
      support: air
      body: {kind: cloth}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The cloth falls over the ball.
  actions: [{operator: FixObject, id: hold, name: ball, start_step: 0, duration: 20}]
clip: {frames: 11}
"""

HELD = Check(id="a", text="moves", ok=True, measured=1, threshold=0, unit="m", margin=0)
CHECKS = (HELD, HELD.model_copy(update={"ok": False}), HELD)


@pytest.fixture(scope="module")
def snapshot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Snapshot]:
    workbench = Workbench(Store(tmp_path_factory.mktemp("stage")), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM)))
    workbench.post(commands.ShowCollisions(on=True))
    assert workbench.wait(60)
    yield workbench.snapshot()
    workbench.close()


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    async def silent(_connection: object, _role: object) -> None: ...

    running = open_server(0, lambda _path: None, silent)
    yield running
    stop_server(running)


@pytest.fixture
def stage(server: viser.ViserServer) -> Stage:
    server.scene.reset()
    hands = Hands(lambda *_: None, lambda *_: None, lambda *_: None, lambda act, *_: act())
    return Stage(server, hands)


def _node(server: viser.ViserServer, name: str) -> Any:
    return server.scene._handle_from_node_name[name]


def _nodes(server: viser.ViserServer) -> set[str]:
    return set(server.scene._handle_from_node_name)


def test_cloth_is_drawn_as_it_moves(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    rollout = snapshot.rollout
    assert rollout is not None
    stage.draw(snapshot, View(), None)
    handle = _node(server, "/deforming/cloth/0")
    path = dict(rollout.vertices)["cloth"]
    for frame in (0, 5, 10):
        stage.pose(snapshot, View(step=frame * 4))
        assert np.allclose(handle.vertices, path[frame], atol=1e-5)
    assert not _node(server, "/objects/cloth").visible
    assert _node(server, "/objects/ball").visible


def test_what_collides_is_shown_when_asked_for(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    stage.draw(snapshot, View(), None)
    assert "/collisions/ball" not in _nodes(server)
    stage.draw(snapshot, View().with_shown("collisions", True), None)
    assert "/collisions/ball" in _nodes(server)
    assert "/collisions/cloth" not in _nodes(server)
    stage.draw(snapshot, View(), None)
    assert "/collisions/ball" not in _nodes(server)


def test_nothing_is_drawn_over_a_clip_that_plays(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    kinds = ("/supports/floor", "/objects/label ball", "/trails/now/")

    def drawn(view: View) -> set[bool]:
        stage.draw(snapshot, view, None)
        over = [name for name in _nodes(server) if name.startswith(kinds)]
        assert {kind for kind in kinds for name in over if name.startswith(kind)} == set(kinds)
        return {_node(server, name).visible for name in over}

    assert drawn(View()) == {True}
    assert drawn(View(step=8, playing=True)) == {False}
    assert _node(server, "/objects/ball").visible
    assert drawn(View(step=8, playing=True).with_shown("clean", False)) == {True}
    assert drawn(View(step=12, playing=True)) == {False}
    assert drawn(View(step=16)) == {True}


def test_what_is_held_says_so(stage: Stage, server: viser.ViserServer, snapshot: Snapshot) -> None:
    assert held_at(snapshot, 10) == {"ball"}
    assert held_at(snapshot, 25) == frozenset()
    stage.draw(snapshot, View(step=8), None)
    label = _node(server, "/objects/label ball")
    assert label.text == "ball · held"
    stage.pose(snapshot, View(step=32))
    assert label.text == "ball"


def test_nothing_stays_of_what_is_gone(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    shown = View().with_shown("collisions", True).with_shown("forces", True)
    stage.draw(snapshot, replace(shown, step=8), None)
    bare = replace(
        snapshot,
        rollout=None,
        collisions=None,
        scene=None,
        program=load_program("event: {prompt: Nothing.}"),
    )
    stage.draw(bare, View(), None)
    left = {name for name in _nodes(server) if name.startswith(("/objects/", "/deforming/c"))}
    assert left == set()
    assert not any(name.startswith(("/collisions/", "/ghosts/")) for name in _nodes(server))


def test_only_what_looks_different_is_drawn_anew(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    snapshot = replace(snapshot, scene=None)
    stage.draw(snapshot, View(), None)
    ball, cloth = _node(server, "/objects/ball"), _node(server, "/objects/cloth")
    trail = _node(server, "/trails/now/cloth")

    def changed(**update: Any) -> Snapshot:
        scene = snapshot.program.scene
        objects = (scene.objects[0].model_copy(update=update), *scene.objects[1:])
        program = snapshot.program.model_copy(
            update={"scene": scene.model_copy(update={"objects": objects})}
        )
        return replace(snapshot, program=program, rollout=None)

    stage.draw(changed(position=(0.3, 1.5, 0.1), material="steel"), View(), None)
    assert _node(server, "/objects/ball") is ball
    assert np.allclose(ball.position, (0.3, 1.5, 0.1))
    assert _node(server, "/objects/label ball").position[0] == pytest.approx(0.3)
    stage.draw(changed(shape=shapes.Box(size=(0.2, 0.2, 0.2))), View(), None)
    assert _node(server, "/objects/ball") is not ball
    assert _node(server, "/objects/cloth") is cloth
    assert np.allclose(_node(server, "/objects/ball").position, (0, 1.5, 0.1))
    stage.draw(snapshot, View(), None)
    assert _node(server, "/trails/now/cloth") is not trail
    assert "/objects/label ball" in _nodes(server)


def test_ghosts_of_another_horizon_or_size_are_left_out(snapshot: Snapshot) -> None:
    def seen(horizon: float, height: float) -> PhysicalProgram:
        camera = Camera.from_horizon((640, 480), horizon, height)
        scene = snapshot.program.scene.model_copy(update={"camera": camera})
        return snapshot.program.model_copy(update={"scene": scene})

    now = replace(snapshot, program=seen(100, 1.2), preview_rollout=snapshot.rollout)
    for other, alike in ((seen(103, 1.2), True), (seen(160, 1.2), False), (seen(100, 2), False)):
        item = Round.model_construct(id="r1", program=other)
        assert fits(now, item) is alike
        state = now.state.model_copy(update={"rounds": (item,), "head": "r1"})
        drawn = with_ghosts(replace(now, state=state))
        assert (drawn.preview_rollout is not None) is alike


def test_a_picture_comes_down_to_its_main_colours() -> None:
    texture = np.zeros((2, 2, 3), np.uint8)
    texture[0] = (200, 20, 20)
    texture[1] = (20, 20, 200)
    uv = np.array([[0.0, 0], [1, 0], [1, 0.9], [0, 1.1], [1, 1.5], [1, 1.9]])
    mesh = Mesh(np.zeros((6, 3)), np.array([[0, 1, 2], [3, 4, 5]], np.int32), uv, texture)
    colours, owner = colours_of(mesh)
    assert {colours[owner[0]], colours[owner[1]]} == {(200, 20, 20), (20, 20, 200)}
    plain = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32), color=(1, 2, 3))
    assert colours_of(plain)[0] == [(1, 2, 3)]


def test_all_runs_of_a_moved_program_are_a_ribbon_in_two_colours(
    stage: Stage, server: viser.ViserServer, snapshot: Snapshot
) -> None:
    assert snapshot.rollout is not None
    way = np.linspace(0.0, 1.0, 11)[:, None, None] * np.ones((1, 2, 3))
    runs = tuple(Ran(objects=snapshot.rollout.objects, path=way, checks=(one,)) for one in CHECKS)
    probed = Probed(sturdiness=Robustness(runs, (), np.zeros((3, 0))))
    stage.draw(replace(snapshot, probed=probed), View(), None)
    held, broken = (_node(server, f"/ribbon/{kind}/ball") for kind in ("held", "broken"))
    assert len(held.points) == 2 * len(broken.points) == 20
    stage.draw(snapshot, View(), None)
    assert not [name for name in _nodes(server) if name.startswith("/ribbon")]
