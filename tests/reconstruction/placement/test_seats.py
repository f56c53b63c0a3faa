"""What stands on a seat is placed there, before the back, not on top of that."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Grounding, Inflated, SceneObject, SceneState
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.records.case import Case

pytestmark = pytest.mark.usefixtures("unfilled")


def _picture() -> np.ndarray:
    """A chair seen from the front, with a blue box on its seat."""
    image = np.full((480, 640, 3), 205, np.uint8)
    image[300:] = 150
    image = cv2.GaussianBlur(image, (0, 0), 9)
    brown = (120, 70, 30)
    cv2.rectangle(image, (230, 120), (410, 280), brown, -1)
    cv2.rectangle(image, (215, 270), (425, 330), brown, -1)
    for x in (220, 400):
        cv2.rectangle(image, (x, 330), (x + 20, 440), brown, -1)
    cv2.rectangle(image, (290, 220), (350, 300), (30, 60, 200), -1)
    return image


def test_a_thing_on_a_chair_stands_on_its_seat() -> None:
    things = {"jug": (286.0, 216.0, 354.0, 304.0), "chair": (210.0, 115.0, 430.0, 445.0)}
    objects = tuple(SceneObject(name=n, grounding=Grounding(box=b)) for n, b in things.items())
    scene = reconstruct(
        Case(name="chair", image=_picture(), prompt=""), SceneState(objects=objects)
    )
    shown = {f.subject: f.measured for f in scene.findings if f.name == "reprojection"}
    jug, chair = scene.state.object("jug"), scene.state.object("chair")
    assert jug is not None
    assert chair is not None
    assert jug.support == "chair"
    assert isinstance(chair.shape, Inflated)
    assert chair.shape.seat is not None
    assert shown["jug"] > 0.8
    assert shown["chair"] > 0.6
    assert all(f.ok for f in scene.findings if f.name == "contact")
