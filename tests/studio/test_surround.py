"""The photo around a scene: what lies where, and that its own camera sees it as it was."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from physagent_studio.program import Camera, PhysicalProgram, SceneState
from physagent_studio.studio.scene.cameras import Cameras, add_backdrop
from physagent_studio.studio.scene.surround import beyond_of, seen_of

SIZE = (320, 200)


@pytest.fixture(scope="module")
def camera() -> Camera:
    return Camera.from_horizon(SIZE, 80.0, 1.2, focal=300.0)


def _image() -> np.ndarray:
    rng = np.random.default_rng(3)
    return rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8)


def test_what_the_photo_shows_is_seen_where_it_was(camera: Camera) -> None:
    for mesh in seen_of(camera, _image(), 0.0, (), 50.0, 1.0):
        if mesh.texture is None or mesh.texture.shape[:2] != (SIZE[1], SIZE[0]):
            continue
        used = np.unique(mesh.faces)
        pixels, depth = camera.project(np.asarray(mesh.vertices)[used])
        assert (depth > 0).all()
        assert mesh.uv is not None
        assert np.abs(pixels - mesh.uv[used]).max() < 1.0


def test_the_ground_is_level_and_below_the_things(camera: Camera) -> None:
    ground = seen_of(camera, _image(), 0.0, (), 50.0, 1.0)[-1]
    used = np.unique(ground.faces)
    heights = np.asarray(ground.vertices)[used, 2]
    assert np.ptp(heights) < 1e-6
    assert -0.01 < heights[0] < 0


def test_the_sky_closes_all_around(camera: Camera) -> None:
    (sky,) = beyond_of(camera, _image(), 50.0)
    ways = np.asarray(sky.vertices) - np.array(camera.position)
    angles = np.sort(np.arctan2(ways[:, 1], ways[:, 0]))
    assert np.diff(angles).max() < 0.2
    assert ways[:, 2].max() > 0.99 * np.linalg.norm(ways[0])


class _Node:
    """A node of a browser's scene: whether it is seen, and whether it is still there."""

    def __init__(self, name: str) -> None:
        self.name, self.visible, self.there = name, True, True

    def remove(self) -> None:
        self.there = False


class _Browser:
    """As much of viser's client as a camera needs, with the nodes that it was sent, in order."""

    client_id = 1

    def __init__(self) -> None:
        self.nodes: list[_Node] = []
        # The lines around the picture come and go with it.
        self.scene = SimpleNamespace(
            add_glb=self._added, add_image=self._added, add_line_segments=lambda *_, **__: None
        )
        self.camera = SimpleNamespace(image_width=640, image_height=480)

    def _added(self, name: str, *_: Any, **__: Any) -> _Node:
        self.nodes.append(_Node(name))
        return self.nodes[-1]

    def atomic(self) -> Any:
        return nullcontext()

    def flush(self) -> None:
        pass

    def seen(self) -> list[str]:
        return [one.name for one in self.nodes if one.there and one.visible]


def test_a_frame_stands_where_the_photo_ends(camera: Camera) -> None:
    drawn: dict[str, Any] = {}

    def added(name: str, points: Any, *_: Any, **more: Any) -> None:
        drawn[name] = (points, more)

    scene = SimpleNamespace(add_image=added, add_line_segments=added)
    add_backdrop(cast("Any", scene), PhysicalProgram(), camera, _image())
    position = drawn["/backdrop"][1]["position"]
    width, rows = camera.size
    for name in ("/backdrop/dark", "/backdrop/light"):
        ends = drawn[name][0].reshape(-1, 3) @ camera.matrix.T + position
        pixels, depth = camera.project(ends)
        assert (depth < np.linalg.norm(position - np.array(camera.position))).all()
        corners = {(round(x, 3), round(y, 3)) for x, y in pixels}
        assert corners == {(0, 0), (width, 0), (width, rows), (0, rows)}


def test_the_picture_around_is_there_first_and_stays_while_the_view_turns(camera: Camera) -> None:
    def shown(image: np.ndarray) -> Any:
        return SimpleNamespace(plate=None, photo=image, support_meshes={})

    browser, cameras = _Browser(), Cameras()
    program = PhysicalProgram(scene=SceneState(camera=camera))
    picture = shown(_image())
    cameras.set_scene(program, picture, with_photo=True)
    cameras.add(cast("Any", browser))
    assert browser.seen() == ["/around/beyond/0", "/backdrop"], "no bare border before it"
    cameras.look(1, "top")
    assert browser.seen()[0] == "/around/beyond/0"
    assert "/backdrop" not in browser.seen()
    assert all(one.startswith("/around") for one in browser.seen())
    sent = len(browser.nodes)
    assert sent > 2
    cameras.look(1, "photo")
    cameras.look(1, "front")
    assert len(browser.nodes) == sent, "nothing is sent again"
    cameras.reset()
    assert browser.seen() == ["/around/beyond/0", "/backdrop"]
    # Another photo takes the place of all of it.
    cameras.set_scene(program, shown(_image()), with_photo=True)
    assert [one.there for one in browser.nodes[:sent]] == [False] * sent
    cameras.set_scene(program, shown(_image()), with_photo=False)
    assert browser.seen() == []
