"""What is known to go on behind a thing: bars by both their edges."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.background.edges_onward import onward
from physagent_studio.reconstruction.background.edges_through import drawn, seen_beside
from physagent_studio.reconstruction.background.lines_behind import lines_through
from physagent_studio.reconstruction.background.mosaic import bent_price
from physagent_studio.reconstruction.background.plate import hole_of
from physagent_studio.reconstruction.background.poisson_blend import joined, sources
from physagent_studio.reconstruction.background.shift_map import bent, shift, to_level
from physagent_studio.reconstruction.background.structure import Structure
from physagent_studio.reconstruction.photo.line_segments import segments, with_grain, with_hues

SHAPE = (260, 360)
CAMERA = Camera.from_horizon((SHAPE[1], SHAPE[0]), -160, 1.5, focal=340.0)


def _rgb(values: np.ndarray) -> np.ndarray:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def _noise(amount: float) -> np.ndarray:
    return np.random.default_rng(1).normal(0, amount, (*SHAPE, 3))


def _ball(at: tuple[int, int], radius: int) -> np.ndarray:
    return cv2.circle(np.zeros(SHAPE, np.uint8), at, radius, 1, -1).astype(bool)


@pytest.fixture(scope="module")
def beam() -> tuple[np.ndarray, np.ndarray]:
    """A beam before bricks that are as light as it is, (H, W, 3), and where it is (H, W)."""
    y, x = np.indices(SHAPE)
    rows = y // 22
    joint = (y % 22 < 3) | ((x + 24 * (rows % 2)) % 48 < 3)
    tone = np.random.default_rng(4).uniform(-14, 14, (20, 20))[rows, (x + 24 * (rows % 2)) // 48]
    bricks = np.where(joint[..., None], (198, 186, 170), (176, 112, 92) + tone[..., None])
    where = np.abs(x - 176 - 0.04 * y) < 30
    wood = np.array([166.0, 122, 62]) + 3 * np.sin(x / 3.0)[..., None]
    return np.where(where[..., None], wood, bricks) + _noise(2), where


def test_edges_of_colour_alone_are_found(beam):
    photo = _rgb(beam[0])
    found = with_hues(photo, segments(photo)).ends
    upright = np.abs(found[:, 0, 0] - found[:, 1, 0]) < 0.2 * np.abs(
        found[:, 0, 1] - found[:, 1, 1]
    )
    for side in (-30, 30):
        off = np.abs(found[..., 0] - 176 - 0.04 * found[..., 1] - side).max(1)
        assert np.ptp(found[upright & (off < 3), :, 1]) > 100


@pytest.fixture(scope="module")
def rimmed() -> tuple[np.ndarray, np.ndarray]:
    """A bare wall (H, W, 3) with a bright line, and a ball (H, W) right above the line."""
    wall = np.full((*SHAPE, 3), 130.0) + _noise(2)
    wall[150:153] += 70
    return wall, _ball((180, 110), 36)


def test_an_edge_right_beside_a_thing_stays_and_one_in_its_shade_does_not(rimmed):
    wall, ball = rimmed
    hole = hole_of([ball], SHAPE)
    for dark, stays in ((0, True), (18, False)):
        photo = wall.copy()
        photo[hole] -= dark
        photo[ball] = (200, 30, 30)
        kept = seen_beside(_rgb(photo), ball, hole, segments(_rgb(photo)))
        assert kept[hole & (np.indices(SHAPE)[0] == 151)].all() == stays
        assert not kept[ball].any()


def test_an_edge_is_drawn_through_a_fill_that_lost_it_and_not_where_the_fill_is_another(rimmed):
    wall, _ = rimmed
    hole = _ball((180, 150), 30)
    lost = wall.copy()
    lost[hole] = 130
    lines = np.array([[[148.0, 151], [212, 151]]])
    made = drawn(_rgb(wall), _rgb(lost), hole, lines).astype(float)
    assert np.abs(made - wall)[hole].mean() < 4
    lost[hole] = 40
    assert (drawn(_rgb(wall), _rgb(lost), hole, lines)[hole] < 60).all()


def test_an_edge_is_found_again_where_it_comes_out_and_no_other():
    y, x = np.indices(SHAPE)
    upper = y < 100 + 0.2 * x
    photo = _rgb(np.where(upper[..., None], (180.0, 174, 166), (150.0, 140, 130)) + _noise(3))
    hole = _ball((180, 136), 44)
    end, way = np.array([128.0, 100 + 0.2 * 128]), np.array([1, 0.2]) / np.hypot(1, 0.2)
    (line,) = onward(photo, end[None], way[None], np.array([90.0]), hole)
    assert line[1, 0] > 218
    assert line[1, 1] == pytest.approx(100 + 0.2 * line[1, 0], abs=2.5)
    ends_there = photo.copy()
    ends_there[:, 180:] = photo[20, 180:]
    assert len(onward(ends_there, end[None], way[None], np.array([90.0]), hole)) == 0


def test_lines_that_lead_on_from_one_another_have_two_sides():
    corner = np.array([[[0.0, 40], [50, 20]], [[50, 20], [100, 30]]])
    other = np.array([[[0.0, 70], [100, 70]]])
    sides = Structure(np.concatenate([corner, other])).sides((100, 100))
    assert len(np.unique(sides)) == 3
    # Beside the corner and above it, and also where one of the two lines would run on.
    assert sides[5, 50] == sides[38, 2] == sides[20, 98] != sides[40, 50]
    kept = Structure(np.concatenate([corner, other])).clear(np.ones((100, 100), bool))
    assert [len(one) for one in kept.chains()] == [2, 1]


def test_a_shift_is_not_bent_and_what_would_comb_grass_is():
    columns, rows = np.array([40, 90]), np.array([30, 120])
    sheared = np.array([[1.0, 0.7, 5], [0, 1, -4], [0, 0, 1]])
    level = to_level(CAMERA)
    along = np.linalg.inv(level) @ shift(0.6, 0.0) @ level
    for copy, least, most in (
        (shift(31.5, -12.0), 0.0, 1e-6),
        (sheared, 0.69, 0.71),
        (along, 0.1, 2.0),
    ):
        x, y, _ = sources(copy, columns, rows)
        found = bent(copy, columns, rows, x, y)
        assert ((found >= least) & (found <= most)).all()


def test_what_is_drawn_out_to_wedges_is_dear():
    columns, rows = np.array([200]), np.array([120])
    level = to_level(Camera.from_horizon((SHAPE[1], SHAPE[0]), 0, 1.5, focal=340.0))

    def price(x: float, y: float) -> float:
        copy = np.linalg.inv(level) @ shift(x, y) @ level
        return float(bent_price(bent(copy, columns, rows, *sources(copy, columns, rows)[:2]))[0])

    assert price(0.2, 0.0) == 0
    assert 5 < price(1.2, 0.0) <= 10
    assert price(3.0, 0.0) > 40


def test_where_the_smooth_fill_meets_a_copy_there_is_no_edge():
    y, x = np.indices((120, 160))
    part = np.repeat((60.0 + 60 * (x > 130))[..., None], 3, 2).astype(np.float32)
    missing = (np.abs(x - 80) < 30) & (np.abs(y - 60) < 30)
    smooth = np.where(missing[..., None], 130.0, part).astype(np.float32)
    label = np.where(missing, (x > 80).astype(int), -1)
    copies = [shift(-40.0, 0.0), None]
    out = joined(part, missing, missing, label, copies, smooth)
    assert np.abs(np.diff(out[40:80, 55:105], axis=1)).max() < 10


@pytest.fixture(scope="module")
def rug() -> np.ndarray:
    """A round rug on a floor, (H, W, 3), as if seen through grain."""
    y, x = np.indices(SHAPE)
    inside = np.hypot(x - 180, (y - 330) * 1.2) < 230
    colours = np.where(inside[..., None], (60.0, 90, 140), (190.0, 170, 140))
    return cv2.GaussianBlur(colours, (0, 0), 0.7)


def test_an_edge_that_bends_goes_on_in_an_arc(rug):
    photo = _rgb(rug + _noise(2))
    hole = _ball((180, 138), 40)
    photo[hole] = (200, 40, 40)
    lines = lines_through(photo, hole, with_hues(photo, segments(photo)))
    chains = Structure(lines).chains()
    assert [len(chain) > 1 for chain in chains] == [True]
    off = np.hypot(chains[0][..., 0] - 180, (chains[0][..., 1] - 330) * 1.2) - 230
    assert np.abs(off).max() < 6


def test_edges_are_found_in_grain():
    y, x = np.indices(SHAPE)
    upper = y < 100 + 0.3 * x
    rough = np.random.default_rng(2).normal(0, 30, SHAPE)[..., None].repeat(3, -1)
    photo = _rgb(np.where(upper[..., None], 190.0, 110.0) + rough)

    def long(found: np.ndarray) -> float:
        off = np.abs(found[..., 1] - 100 - 0.3 * found[..., 0]).max(1)
        return float(np.ptp(found[off < 4, :, 0], axis=1).sum())

    assert long(segments(photo).ends) < 200 < long(with_grain(photo, segments(photo)).ends)
