"""What a page tries while it drags: told to all, ended by a drop, a refusal or a closed tab."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.connection import Connection

from physagent_studio.program import SetField
from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.studio import Studio, serve
from physagent_studio.studio.figures.wire import open_page, settle, until
from physagent_studio.studio.panels.words import without_paths
from physagent_studio.workbench import Workbench, commands

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball rolls to the right.
  actions: [{operator: SetVelocity, id: go, name: ball, velocity: [0.5, 0, 0]}]
contract:
  clauses: [{id: c1, text: rolls to the right}]
  statements: [{id: far, kind: moves, subject: ball, distance: 0.1, clause: c1}]
clip: {frames: 21}
"""
START = "event.actions.go.start_step"


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM)))
    assert workbench.wait(60)
    running = serve(workbench, port=0)
    yield running
    running.stop()
    workbench.close()


def _say(page: Connection, **intent: Any) -> None:
    page.send(json.dumps(intent))


def _edits(step: int) -> list[dict[str, Any]]:
    return [{"op": "set", "path": START, "value": step}]


def _there(value: Any) -> bool:
    return value is not None


def _gone(value: Any) -> bool:
    return value is None


@pytest.mark.parametrize(
    "end",
    [
        lambda page: _say(page, do="try", edits=None),
        lambda page: _say(page, do="edit", edits=_edits(8), ticket=1),
        lambda page: _say(page, do="edit", edits=_edits(5000), ticket=1),
    ],
    ids=["let go", "dropped", "refused"],
)
def test_it_is_told_and_ends(studio: Studio, end: Callable[[Connection], None]) -> None:
    with open_page(studio) as page:
        until(page, "timeline")
        _say(page, do="try", edits=_edits(8))
        assert until(page, "attempt", _there) == {"problem": "", "holds": 1, "of": 1}
        end(page)
        until(page, "attempt", _gone)


def test_why_it_cannot_be_is_told(studio: Studio) -> None:
    with open_page(studio) as page:
        until(page, "timeline")
        _say(page, do="try", edits=_edits(5000))
        assert "clip" in until(page, "attempt", _there)["problem"]


def test_a_closed_tab_ends_it(studio: Studio) -> None:
    with open_page(studio) as watching:
        until(watching, "timeline")
        with open_page(studio) as page:
            until(page, "timeline")
            _say(page, do="try", edits=_edits(8))
            until(watching, "attempt", _there)
        until(watching, "attempt", _gone)
    action = studio.workbench.snapshot().program.action("go")
    assert action is not None
    assert action.start_step == 0


def _moved(studio: Studio, x: float, ends: bool) -> None:
    edit = SetField(path="scene.objects.ball.position", value=[x, 2.0, 0.1])
    studio.later(lambda: studio._edited((edit,), "moved in the scene", ends), 7, ends)


def _x(studio: Studio) -> float:
    assert studio.workbench.wait(60)
    position = studio.workbench.snapshot().program.scene.objects[0].position
    assert position is not None
    return position[0]


def test_a_hand_in_the_scene_has_seen_what_was_there_when_it_took_hold(studio: Studio) -> None:
    with open_page(studio) as page:
        until(page, "timeline")
        _moved(studio, 0.5, ends=False)
        until(page, "attempt", _there)
        # Somebody else is faster: what is let go now was made against what is no more.
        _say(page, do="edit", edits=_edits(8), ticket=1)
        until(page, "answer")
        _moved(studio, 0.6, ends=True)
        said = until(page, "say")
        assert f"edited {without_paths(START)}" in said["text"]
        assert _x(studio) == 0
        # Whoever takes hold anew has seen it.
        _moved(studio, 0.7, ends=False)
        _moved(studio, 0.8, ends=True)
        settle(studio)
        assert _x(studio) == 0.8
