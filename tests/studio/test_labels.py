"""Words in the scene cover no other, none is too small to read, and a thing has one colour."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.studio.guard import open_server, stop_server
from physagent_studio.studio.panels import plots, timeline
from physagent_studio.studio.scene.marks import GAP, LETTER, LINE, VALUE, VIEW_WIDTH, Labels
from physagent_studio.studio.scene.places import _lab, apart, colours_of
from physagent_studio.studio.scene.stage import Hands, Stage
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot, Workbench, commands

PROGRAM = """
scene:
  objects:
    - {name: lower_white_box, shape: {kind: box, size: [0.3, 0.3, 0.1]}, position: [0, 2, 0.05]}
    - {name: middle_white_box, shape: {kind: box, size: [0.3, 0.3, 0.04]}, position: [0, 2, 0.12]}
    - {name: upper_white_box, shape: {kind: box, size: [0.3, 0.3, 0.04]}, position: [0, 2, 0.16]}
    - {name: red_ball, shape: {kind: sphere, radius: 0.1}, position: [-0.4, 2, 0.1]}
  supports: [{name: floor, shape: {kind: floor}}]
event:
  prompt: The ball hits the boxes.
  actions:
    - {operator: ApplyForce, id: push_box, name: upper_white_box, force: [3, 0, 0],
       start_step: 0, duration: 60}
    - {operator: SetVelocity, id: push_ball, name: red_ball, velocity: [1.5, 0, 0], start_step: 0}
"""


@pytest.fixture(scope="module")
def snapshot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Snapshot]:
    workbench = Workbench(Store(tmp_path_factory.mktemp("labels")), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM)))
    assert workbench.wait(60)
    shown = workbench.snapshot()
    scene = shown.program.scene.model_copy(
        update={"camera": Camera.from_horizon((832, 480), 100, 0.9)}
    )
    yield replace(shown, program=shown.program.model_copy(update={"scene": scene}))
    workbench.close()


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    async def silent(_connection: object, _role: object) -> None: ...

    running = open_server(0, lambda _path: None, silent)
    yield running
    stop_server(running)


def _labels(server: viser.ViserServer) -> dict[str, Any]:
    nodes = server.scene._handle_from_node_name
    return {name: one for name, one in nodes.items() if isinstance(one, viser.LabelHandle)}


def _box(label: Any, camera: Camera) -> tuple[float, float, float, float]:
    pixel, _ = camera.project(np.array([label.position], float))
    x, y = pixel[0] * VIEW_WIDTH / camera.size[0]
    size = label.font_screen_scale
    wide, high = LETTER * len(label.text) * size + 8, LINE * size
    top = y if label.anchor.startswith("top") else y - high
    return x - wide / 2, top, x + wide / 2, top + high


def test_no_two_labels_overlap_and_all_are_read(
    snapshot: Snapshot, server: viser.ViserServer
) -> None:
    def nothing(*_: object) -> None: ...

    stage = Stage(server, Hands(nothing, nothing, nothing, nothing))
    camera = snapshot.program.scene.camera
    assert camera is not None
    every = frozenset({"labels", "forces", "contacts", "gravity", "trails", "supports"})
    seen = 0
    for step in (0, 4, 16, 24, 40, 80):
        stage.draw(snapshot, replace(View(), shown=every, step=step), None)
        labels = _labels(server)
        seen = max(seen, len(labels))
        # At 1 viser writes letters of 13 pixels.
        assert min(one.font_screen_scale for one in labels.values()) >= VALUE
        assert 13 * VALUE >= 10
        boxes = {name: _box(one, camera) for name, one in labels.items()}
        for first in boxes:
            for other in boxes:
                if first < other:
                    a, b = boxes[first], boxes[other]
                    room = GAP + 1
                    across = min(a[2], b[2]) - max(a[0], b[0])
                    down = min(a[3], b[3]) - max(a[1], b[1])
                    assert across <= 0 or down <= room, (step, first, other)
    assert seen >= 6


def test_a_label_without_a_photo_stays_where_it_points() -> None:
    point = np.array([0.0, 1.0, 2.0])
    words = Labels(None)
    assert (words.place(point, "one") == words.place(point, "two")).all()


def test_a_thing_has_one_colour_everywhere(snapshot: Snapshot) -> None:
    names = [item.name for item in snapshot.program.scene.objects]
    colours = colours_of(snapshot)
    assert len(set(colours.values())) == len(names)
    lanes = timeline.state_of(snapshot)["lanes"]
    assert {lane["name"]: tuple(lane["colour"]) for lane in lanes} == colours
    curves = plots.state_of(snapshot)
    drawn = dict(zip(curves["objects"], map(tuple, curves["colours"]), strict=True))
    assert drawn == colours


def test_colours_that_are_alike_are_told_apart_by_how_light_they_are() -> None:
    grey = (120, 122, 119)
    assert apart((grey,))[0] == pytest.approx(grey, abs=6), "its own"
    found = apart((grey, (200, 40, 40), grey, (121, 121, 121)))
    lab = [_lab(one) for one in found]
    assert all(np.linalg.norm(a - b) > 15 for a, b in itertools.combinations(lab, 2))
    assert np.abs(lab[0][1:] - lab[2][1:]).max() < 4, "another lightness, the same hue"
