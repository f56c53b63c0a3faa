"""What hangs by a thread that is seen takes it along, and swings about its upper end."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.shapes.threads import thread_above, thread_below
from physagent_studio.records.case import Case
from physagent_studio.records.scene import Scene
from physagent_studio.rendering.compositor import Compositor


def picture(seed: int, thread: bool = True, top: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """A ball before a wall over a floor, hung by a thread or by nothing, and the ball's mask."""
    rng = np.random.default_rng(seed)
    image = np.full((300, 400, 3), (200, 196, 188), float)
    image[230:] = (110, 90, 80)
    if thread:
        cv2.line(image, (200, top), (200, 150), (60, 55, 50), 3)
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.circle(mask, (200, 170), 22, 1, -1)
    image[mask > 0] = (180, 60, 40)
    image += rng.normal(0, 3, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8), mask.astype(bool)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_thread_is_followed_to_its_end(seed: int) -> None:
    image, mask = picture(seed)
    found = thread_above(image, mask, np.zeros_like(mask))
    assert found is not None
    assert abs(found.top[1] - 20) < 6
    assert abs(found.top[0] - 200.5) < 1.5
    assert 2 <= found.width <= 5
    assert np.abs(found.colors.mean(0) - (60, 55, 50)).max() < 25
    assert not (found.area & mask).any()
    assert (found.area & found.core == found.core).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_where_there_is_none_none_is_seen(seed: int) -> None:
    image, mask = picture(seed, thread=False)
    nothing = np.zeros_like(mask)
    assert thread_above(image, mask, nothing) is None
    # The side of a door is no thread, nor is a stump, nor what belongs to another thing.
    door = image.copy()
    door[:230, 200:] = (90, 110, 120)
    assert thread_above(door, mask, nothing) is None
    short, mask = picture(seed, top=138)
    assert thread_above(short, mask, nothing) is None
    image, mask = picture(seed)
    taken = nothing.copy()
    taken[:150] = True
    assert thread_above(image, mask, taken) is None


def hung(prompt: str, aloft: Literal["hangs"] | None = "hangs") -> Scene:
    image, _ = picture(3)
    grounding = Grounding(points=(Click(x=200, y=170),))
    case = Case("t", image, photo_hash(image), (("ball", grounding),), (), (), prompt)
    support = "air" if aloft else None
    item = SceneObject(name="ball", grounding=grounding, support=support, aloft=aloft)
    return reconstruct(case, SceneState(objects=(item,)))


def test_it_goes_where_its_thing_goes() -> None:
    scene = hung("The ball swings.")
    item = scene.state.object("ball")
    assert item is not None
    assert item.tether is not None
    assert item.position is not None
    camera = scene.state.camera
    assert camera is not None
    top = np.add(item.position, (0, 0, item.tether))
    assert np.abs(camera.project(top[None])[0][0] - (200.5, 20)).max() < 8
    # Nothing of it is left on the background, and it is drawn where the photo has it.
    assert scene.plate is not None
    assert (
        np.abs(scene.plate[40:140, 196:206].astype(float).mean((0, 1)) - (200, 196, 188)).max() < 8
    )
    compositor = Compositor(scene)
    frame = compositor.frame(as_built=True)
    assert (frame.ids[60, 195:206] == 0).sum() >= 2
    aside = np.add([item.position], (0.1, 0, 0))
    moved = compositor.frame(positions=aside)
    assert (moved.ids[60, 195:206] == 0).sum() == 0
    assert (moved.ids[60] == 0).sum() >= 2


def test_what_stands_has_no_thread() -> None:
    item = hung("The ball rolls to the right.", None).state.object("ball")
    assert item is not None
    assert item.tether is None


def test_what_drops_leaves_its_thread_behind() -> None:
    scene = hung("The ball drops and bounces.")
    item = scene.state.object("ball")
    assert item is not None
    assert item.tether is None
    assert scene.plate is not None
    assert np.abs(scene.plate[60, 200].astype(float) - (60, 55, 50)).max() < 25


@pytest.mark.parametrize("seed", [1, 2])
def test_a_balloon_takes_the_string_below_it_along(seed: int) -> None:
    image, mask = (np.ascontiguousarray(what[::-1]) for what in picture(seed))
    found = thread_below(image, mask, np.zeros_like(mask))
    assert found is not None
    # It begins within the balloon.
    assert 130 < found.foot[1] < 152
    assert abs(found.top[1] - 280) < 6
    assert not (found.area & mask).any()
    assert found.area[160:275].any(1).all()
    assert not found.area[:150].any()


def test_the_string_of_a_balloon_is_drawn_with_it_and_holds_nothing() -> None:
    image, _ = (np.ascontiguousarray(what[::-1]) for what in picture(3))
    grounding = Grounding(points=(Click(x=200, y=129),))
    told = "The balloon rises out of the picture."
    case = Case("t", image, photo_hash(image), (("balloon", grounding),), (), (), told)
    item = SceneObject(name="balloon", grounding=grounding, support="air", aloft="hangs")
    scene = reconstruct(case, SceneState(objects=(item,)))
    assert scene.state.objects[0].tether is None
    assert scene.masks["balloon"][200:260, 195:206].any(1).all()
    assert scene.plate is not None
    string = scene.plate[190:270, 198:203].astype(float).mean((0, 1))
    beside = scene.plate[190:270, 150:190].astype(float).mean((0, 1))
    assert np.abs(string - beside).max() < 12
