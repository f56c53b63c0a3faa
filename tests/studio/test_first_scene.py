"""What stands in for the first program while it is written, and what waits for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState, Support
from physagent_studio.records import Case, LoopState
from physagent_studio.studio.first_scene import Waiting, marked, unwritten
from physagent_studio.workbench import Snapshot

CLICKED = Grounding(points=(Click(x=3, y=4),))
CASE = Case(
    name="case",
    image=np.zeros((9, 9, 3), np.uint8),
    image_hash="0",
    objects=(("ball", CLICKED),),
    supports=(Support(name="table"),),
    landmarks=(),
    prompt="The ball rolls.",
    horizon=2.0,
)
OPENED = Snapshot(revision=1, session_id="a", case=CASE, busy="reading the photo")
WRITTEN = replace(
    OPENED,
    busy=None,
    state=LoopState(draft=PhysicalProgram()),
    program=PhysicalProgram(scene=SceneState(objects=(SceneObject(name="other"),))),
)


def test_the_case_stands_in_for_the_program_until_there_is_one() -> None:
    assert unwritten(OPENED)
    assert [(one.name, one.grounding) for one in marked(OPENED).objects] == [("ball", CLICKED)]
    assert marked(OPENED).supports == CASE.supports
    assert not unwritten(WRITTEN)
    assert [one.name for one in marked(WRITTEN).objects] == ["other"]
    # Nothing is being made of a scene without a photo or a sentence: it is edited as it is.
    for case in (replace(CASE, image=None), replace(CASE, prompt=" "), None):
        assert not unwritten(replace(OPENED, case=case))


def test_what_waits_is_due_in_its_order_and_only_in_its_own_session() -> None:
    done: list[str] = []
    waiting = Waiting()
    for number, session in enumerate(("a", "b", "a")):
        waiting.add(session, lambda number=number: done.append(str(number)))
    assert waiting.due(OPENED) == []
    for act in waiting.due(WRITTEN):
        act()
    assert done == ["0", "2"]
    assert waiting.due(replace(WRITTEN, session_id="b")) == []
    # Where the making was cancelled it is due too, to say what is missing.
    waiting.add("a", lambda: done.append("last"))
    assert len(waiting.due(replace(OPENED, busy=None))) == 1
