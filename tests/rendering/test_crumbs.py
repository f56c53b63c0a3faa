"""Grains are seen as crumbs: their skin comes apart instead of being drawn out."""

import numpy as np

from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.crumbs import GROWN, LONGEST, Crumbs


def sheet(cells: int = 4) -> Mesh:
    """A square sheet of side 1 with texture coordinates that are its places."""
    at = np.linspace(0, 1, cells + 1)
    vertices = np.array([(x, y, 0.0) for x in at for y in at])
    corner = np.array([(i * (cells + 1) + j) for i in range(cells) for j in range(cells)])
    faces = np.concatenate(
        [
            np.stack([corner, corner + cells + 1, corner + 1], 1),
            np.stack([corner + 1, corner + cells + 1, corner + cells + 2], 1),
        ]
    )
    return Mesh(vertices, faces.astype(np.int32), vertices[:, :2].copy())


def longest(corners: np.ndarray) -> np.ndarray:
    corners = corners.reshape(-1, 3, 3)
    return np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max(1)


def area(corners: np.ndarray) -> float:
    a, b, c = np.moveaxis(corners.reshape(-1, 3, 3), 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_at_rest_the_crumbs_are_the_skin() -> None:
    skin = sheet()
    crumbs = Crumbs.of(skin)
    made = crumbs.split(skin)
    assert made.uv is not None
    np.testing.assert_allclose(crumbs.placed(skin.vertices), made.vertices, atol=1e-12)
    np.testing.assert_allclose(made.uv, made.vertices[:, :2], atol=1e-12)
    np.testing.assert_allclose(area(made.vertices), 1.0)
    assert longest(made.vertices).max() <= LONGEST + 1e-9


def test_moved_as_a_whole_nothing_comes_loose() -> None:
    skin = sheet()
    crumbs = Crumbs.of(skin)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    moved = crumbs.placed(skin.vertices @ turn.T + (1.0, 2.0, 3.0))
    expected = crumbs.split(skin).vertices @ turn.T + (1.0, 2.0, 3.0)
    np.testing.assert_allclose(moved, expected, atol=1e-9)


def test_drawn_out_the_crumbs_keep_their_size_and_go_along() -> None:
    skin = sheet()
    crumbs = Crumbs.of(skin)
    moved = crumbs.placed(skin.vertices * (6.0, 1.0, 1.0)).reshape(-1, 3, 3)
    before = longest(crumbs.rest)
    assert (longest(moved) <= GROWN * before + 1e-9).all()
    np.testing.assert_allclose(moved.mean(1), crumbs.rest.mean(1) * (6.0, 1.0, 1.0), atol=1e-9)


def test_faces_without_area_are_no_trouble() -> None:
    skin = sheet()
    flat = Crumbs.of(skin).placed(np.zeros_like(skin.vertices))
    assert np.isfinite(flat).all()
