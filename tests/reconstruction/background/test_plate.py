"""The background without the objects: no seams, lines go on, no shade stays behind."""

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.plates import plate_of, scores, vacated
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Floor, Grounding, Mark, Ramp, Slab, Support
from physagent_studio.reconstruction.background.cast_shadows import shaded
from physagent_studio.reconstruction.background.floor_reflections import mirrored
from physagent_studio.reconstruction.background.harmonic_fill import from_steps
from physagent_studio.reconstruction.background.leftovers import leftovers
from physagent_studio.reconstruction.background.lines_behind import (
    edges_of,
    faces_of,
    lines_through,
)
from physagent_studio.reconstruction.background.plate import background, fill, hole_of, taken_out
from physagent_studio.reconstruction.background.smooth_fill import smooth_fill
from physagent_studio.reconstruction.background.structure import Structure
from physagent_studio.reconstruction.background.surfaces import surfaces
from physagent_studio.reconstruction.photo.line_segments import segments

SHAPE = (240, 320)


def _noise(amount: float, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(0, amount, (*SHAPE, 3))


def _rgb(values: np.ndarray) -> np.ndarray:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def _lit_wall() -> np.ndarray:
    """A wall that gets darker to the right and downwards."""
    y, x = np.indices(SHAPE)
    return np.repeat((200 - 0.25 * x - 0.15 * y)[..., None], 3, 2) * (1.0, 0.98, 0.94)


def _ball(at: tuple[int, int] = (160, 110), radius: int = 34) -> np.ndarray:
    return cv2.circle(np.zeros(SHAPE, np.uint8), at, radius, 1, -1).astype(bool)


def test_a_wall_in_changing_light_is_filled_without_a_seam():
    truth = _lit_wall() + _noise(1.5)
    mask = _ball()
    photo = _rgb(np.where(mask[..., None], (30, 60, 200), truth))
    plate = fill(photo, hole_of([mask], SHAPE)).astype(float)
    off = cv2.GaussianBlur(plate - _lit_wall(), (0, 0), 3).mean(-1)
    assert np.abs(off[mask]).max() < 5


def test_an_edge_that_runs_behind_an_object_goes_on():
    y, x = np.indices(SHAPE)
    upper = y < 60 + 0.35 * x
    truth = np.where(upper[..., None], (205.0, 200, 190), (120.0, 84, 52)) + _noise(2)
    mask = _ball((150, 112))
    photo = _rgb(np.where(mask[..., None], (20, 160, 60), truth))
    hole = hole_of([mask], SHAPE)
    lines = lines_through(photo, hole, segments(photo))
    assert len(lines) == 1
    row = np.interp([110, 190], *sorted_by_x(lines[0]))
    assert row == pytest.approx([60 + 0.35 * 110, 60 + 0.35 * 190], abs=3)
    plate = fill(photo, hole, lines).astype(float).mean(-1)
    wrong = (plate > 140) != upper
    assert wrong[mask].mean() < 0.03


def sorted_by_x(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    order = np.argsort(line[:, 0])
    return line[order, 0], line[order, 1]


def test_an_edge_whose_other_end_is_hidden_goes_on_to_the_border_where_it_parts_two_colours():
    y, x = np.indices(SHAPE)
    red, white = np.array([200.0, 20, 30]), np.array([225.0, 225, 222])
    truth = np.where((x > 150 + y / 10)[..., None], red, white) + _noise(1.5)
    mask = (np.abs(x - 165) < 45) & (y > 80)
    photo = _rgb(np.where(mask[..., None], 20, truth))
    plate = background(photo, [mask], found=segments(photo)).astype(float)
    assert np.abs(cv2.GaussianBlur(plate - truth, (0, 0), 2))[mask].mean() < 8
    # Red only in a corner above: what is below the thing's middle is white on both sides.
    corner = np.where(((x > 150 + y / 10) & (y < 120))[..., None], red, white) + _noise(1.5)
    photo = _rgb(np.where(mask[..., None], 20, corner))
    plate = background(photo, [mask], found=segments(photo)).astype(float)
    assert np.abs(plate - white)[200:, 200:208].mean() < 12


def test_edges_of_a_table_are_taken_where_a_person_marked_it_or_where_they_are_seen():
    camera = Camera.from_horizon((SHAPE[1], SHAPE[0]), -40, 1.4, focal=300.0)
    slab = Slab(position=(0.0, 2.0, 0.68), size=(1.0, 0.6, 0.04))
    seen = Support(name="table", shape=slab)
    marks = tuple(Mark(role="top", x=1.0, y=1.0) for _ in range(3))
    marked = seen.model_copy(update={"grounding": Grounding(marks=marks)})
    blank = np.full((*SHAPE, 3), 150, np.uint8)
    pixels = camera.project(np.array([[0.0, 1.7, 0.7], [-0.5, 1.7, 0.7]]))[0]
    hole = _ball((round(pixels[0, 0]), round(pixels[0, 1])), 14)
    floor = Support(name="floor", shape=Floor())
    assert len(edges_of(blank, hole, camera, (floor, seen))) == 0
    (edge,) = edges_of(blank, hole, camera, (floor, marked))
    assert edge[:, 1] == pytest.approx([pixels[1, 1]] * 2)
    drawn = blank.copy()
    drawn[round(pixels[1, 1]) :] = 60
    assert len(edges_of(drawn, hole, camera, (seen,))) == 1


def test_edges_of_a_ramp_go_on_behind_what_stands_on_it():
    camera = Camera.from_horizon((SHAPE[1], SHAPE[0]), -40, 1.4, focal=300.0)
    ramp = Support(name="ramp", shape=Ramp(toe=(-0.5, 2.0, 0), yaw=0, run=1, rise=0.4, width=0.6))
    drawn = np.full((*SHAPE, 3), 150, np.uint8)
    faces = faces_of(ramp, camera)
    for face, tone in zip(faces, (60, 210, 90, 30), strict=False):
        cv2.fillPoly(drawn, [np.round(face).astype(np.int32)], (tone, tone, tone))
    middle = np.concatenate(faces).mean(0)
    hole = _ball((round(middle[0]), round(middle[1])), 40)
    edges = edges_of(drawn, hole, camera, (ramp,))
    assert len(edges) >= 2
    assert not len(edges_of(np.full_like(drawn, 150), hole, camera, (ramp,)))
    shown = surfaces(drawn, hole, camera, (ramp,))
    assert len(np.unique(shown)) > len(faces)
    assert not surfaces(np.full_like(drawn, 150), hole, camera, (ramp,)).any()


def test_ground_that_a_thing_shines_on_goes_with_it():
    y, x = np.indices(SHAPE)
    share = 0.18 * np.exp(-(((x - 160) / 20) ** 2) - ((y - 158) / 12) ** 2)[..., None]
    mask = _ball()
    truth = _lit_wall() + _noise(1.5)
    glossy = truth * (1 - share) + share * np.array([235.0, 120, 30])
    photo = _rgb(np.where(mask[..., None], (235, 120, 30), glossy))
    assert shaded(photo, [mask], hole_of([mask], SHAPE))[154:160, 154:166].all()
    plate = background(photo, [mask]).astype(float)
    assert np.abs(plate - _lit_wall())[146:166, 146:176].mean() < 6


def test_what_polished_ground_mirrors_leaves_with_its_thing():
    y, x = np.indices(SHAPE)
    board = 14 * np.sin(x / 9 + y / 30)[..., None]
    truth = np.where((y > 70)[..., None], _lit_wall() + board, _lit_wall()) + _noise(1.5)
    mask = ((np.abs(x - 160) / 26) ** 2 + (np.abs(y - 90) / 44) ** 2) < 1
    image = ((np.abs(x - 160) / 26) ** 2 + (np.abs(y - 178) / 44) ** 2) < 1
    soft = cv2.GaussianBlur(image.astype(float), (0, 0), 1.5)[..., None]
    seen = truth * (1 - 0.35 * soft) + 0.35 * soft * np.array([60.0, 40, 30])
    polished = _rgb(np.where(mask[..., None], (60, 40, 30), seen))
    matt = _rgb(np.where(mask[..., None], (60, 40, 30), truth))
    assert mirrored(polished, [mask])[image & (y < 215)].mean() > 0.95
    assert not mirrored(matt, [mask]).any()
    # What differs now one way and now the other along the same outline is painted there.
    painted = truth - 40 * soft * np.where(y % 18 < 12, 1, -1)[..., None]
    photo = _rgb(np.where(mask[..., None], (60, 40, 30), painted))
    assert not mirrored(photo, [mask]).any()
    # A mask that holds the beginning of the image as well does not hide the rest.
    low = mask | (image & (y < 148))
    assert mirrored(polished, [low])[image & (y > 152) & (y < 210)].mean() > 0.95
    plate = background(polished, [mask]).astype(float)
    left = cv2.GaussianBlur(truth - plate, (0, 0), 3).mean(-1)
    assert np.abs(left[image]).mean() < 10


def test_an_image_is_seen_on_both_sides_of_its_outline_and_a_stripe_is_not():
    y, x = np.indices(SHAPE)
    thing = ((np.abs(x - 160) / 26) ** 2 + (np.abs(y - 90) / 44) ** 2) < 1
    image = ((np.abs(x - 160) / 26) ** 2 + (np.abs(y - 178) / 44) ** 2) < 1
    soft = cv2.GaussianBlur(image.astype(float), (0, 0), 1.5)[..., None]
    found = []
    for seed in range(8):
        # Boards that run away from the eye, each of its own brightness.
        rng = np.random.default_rng(seed)
        board = ((x - 160) / (y + 20) * 12 + 40).astype(int)
        truth = _lit_wall() + rng.normal(0, 12, 200)[board][..., None] + _noise(1.5)
        paint = rng.uniform(30, 220, 3)
        polished = _rgb(np.where(thing[..., None], paint, truth + 0.2 * soft * (paint - truth)))
        found.append(mirrored(polished, [thing])[image & (y < 215)].mean() > 0.95)
        assert not mirrored(_rgb(np.where(thing[..., None], paint, truth)), [thing]).any()
    assert sum(found) >= 6


def test_bare_ground_is_filled_smoothly_and_as_grainy_as_it_is():
    part = (_lit_wall() + _noise(5)).astype(np.float32)
    hole = _ball()
    filled = smooth_fill(part, hole, hole, Structure(np.zeros((0, 2, 2))))
    assert np.array_equal(filled[~hole], part[~hole])
    assert np.abs(cv2.GaussianBlur(filled - _lit_wall(), (0, 0), 4))[hole].max() < 6
    grey = filled.mean(-1)
    fine = grey - cv2.GaussianBlur(grey, (0, 0), 1.2)
    assert fine[hole].std() == pytest.approx(fine[~hole].std(), rel=0.35)


def test_the_shade_around_a_foot_goes_with_the_object():
    y, x = np.indices(SHAPE)
    dark = 0.5 * np.exp(-(((x - 176) / 22) ** 2) - ((y - 146) / 9) ** 2)
    lit = _lit_wall()
    mask = _ball()
    truth = lit * (1 - dark[..., None]) + _noise(1.5)
    photo = _rgb(np.where(mask[..., None], (200, 60, 30), truth))
    shade = shaded(photo, [mask], hole_of([mask], SHAPE))
    assert shade[150, 190]
    assert not shade[:100].any()
    plate = background(photo, [mask]).astype(float)
    left = (plate / lit).mean(-1)
    assert left[140:150, 165:185].min() > 0.9
    assert np.array_equal(plate[:60], photo[:60])


def test_what_is_small_in_the_picture_is_looked_at_from_nearer():
    y, x = np.indices((480, 640))
    mask = (np.abs(x - 300) < 22) & (np.abs(y - 200) < 24)
    dark = (((x - 330) / 60) ** 2 + ((y - 222) / 6) ** 2) < 1
    ground = 190.0 + np.random.default_rng(3).normal(0, 2, (480, 640))
    grey = np.where(mask, 60.0, ground * (1 - 0.4 * dark))
    photo = _rgb(np.repeat(cv2.GaussianBlur(grey, (0, 0), 0.8)[..., None], 3, 2))
    hole = hole_of([mask], mask.shape)
    found = shaded(photo, [mask], hole)
    assert found[dark & ~hole].mean() > 0.9
    assert (found & ~hole).sum() < 2.4 * (dark & ~hole).sum()


def test_a_stack_shades_the_ground_as_one():
    y, x = np.indices(SHAPE)
    lower, upper = ((np.abs(x - 90) < 18) & (np.abs(y - at) < 18) for at in (180, 143))
    # A low sun from the left and behind: the shade of two runs up the picture, farther than one.
    along = (x - 90) / 1.2
    dark = (np.abs(200 - y - 0.8 * along) < 10) & (along > 0) & (along < 95)
    soft = 1 - 0.45 * cv2.GaussianBlur(dark.astype(float), (0, 0), 2)[..., None]
    photo = np.where((lower | upper)[..., None], (40, 90, 160), _lit_wall() * soft + _noise(1.5))
    hole = hole_of([lower, upper], SHAPE)
    both = shaded(_rgb(photo), [lower, upper], hole)
    assert (both & dark)[:150].sum() > 0.8 * (dark & ~hole)[:150].sum() > 0
    assert not both[:110].any()


def test_a_painted_patch_under_a_thing_stays():
    y, x = np.indices(SHAPE)
    around = ((x - 160) / 120) ** 2 + ((y - 130) / 60) ** 2
    truth = _lit_wall()
    truth[around < 1] = (180, 30, 40)
    truth[around < 0.45] = (150, 150, 148)
    mask = _ball((160, 110), 30)
    photo = _rgb(np.where(mask[..., None], (40, 40, 44), truth + _noise(1.5)))
    shade = shaded(photo, [mask], hole_of([mask], SHAPE))
    assert not shade[150:, :].any()


def test_the_faint_rim_of_a_shade_goes_with_it_also_where_it_ends_at_paint():
    y, x = np.indices(SHAPE)
    ball, paint = _ball((160, 110), 40), y > 180
    spot = (((x - 160) / 62) ** 2 + ((y - 146) / 22) ** 2 < 1).astype(float)
    shade = 0.4 * cv2.GaussianBlur(spot, (0, 0), 14)
    ground = np.where(paint[..., None], (188.0, 60, 64), (226.0, 232, 236))
    photo = np.where(ball[..., None], 60.0, ground * (1 - shade[..., None]) + _noise(1))
    hole = hole_of([ball], SHAPE)
    found = shaded(_rgb(photo), [ball], hole)
    dark = (shade > 0.02) & ~paint & ~hole
    assert (dark & ~found).sum() < 0.2 * dark.sum()
    assert not (found & paint & ~hole & (shade < 0.02)).any()


def test_a_picture_comes_back_from_its_steps():
    picture = np.random.default_rng(2).uniform(0, 255, (20, 30, 3)).astype(np.float32)
    hole = np.zeros((20, 30), bool)
    hole[4:15, 6:30] = True
    right = np.roll(picture, -1, 1) - picture
    down = np.roll(picture, -1, 0) - picture
    start = np.where(hole[..., None], 0, picture).astype(np.float32)
    assert from_steps(start, hole, (right, down)) == pytest.approx(picture, abs=0.01)


def test_the_same_picture_gives_the_same_plate():
    photo = _rgb(_lit_wall() + _noise(4))
    masks = [_ball(), _ball((60, 180), 20)]
    assert np.array_equal(background(photo, masks), background(photo, masks))
    everything = np.ones(SHAPE, bool)
    assert (background(photo, [everything]) == 128).all()
    assert np.array_equal(background(photo, []), photo)


@pytest.mark.parametrize("texture", ["boards", "lane"])
def test_what_lies_on_the_ground_goes_on_in_perspective(texture: str):
    item = vacated(texture, 2)
    tone, contrast, _, shadow = scores(item, plate_of(item))
    assert tone < 9
    assert contrast < 0.25
    assert shadow < 11


def test_what_the_mask_has_missed_goes_with_its_thing():
    thing, handle = _ball(), np.zeros(SHAPE, bool)
    handle[100:116, 192:214] = True
    photo = np.where((thing | handle)[..., None], (180, 40, 30), _lit_wall()) + _noise(1.5)
    found = leftovers(_rgb(photo), [thing], hole_of([thing], SHAPE))
    assert found[104:112, 204:210].all()
    assert not found[:, 220:].any()
    plate = background(_rgb(photo), [thing]).astype(float)
    assert np.abs(plate - _lit_wall())[90:126, 190:220].mean() < 8
    # What is as red and goes on elsewhere is no part of it.
    photo[:, 200:] = (180, 40, 30)
    assert not leftovers(_rgb(photo), [thing], hole_of([thing], SHAPE)).any()


def test_leaves_that_the_mask_of_a_tree_has_missed_go_with_it_and_its_foot_stays():
    y, x = np.indices(SHAPE)
    ground = np.where((y > 170)[..., None], (66.0, 84, 40), (228.0, 216, 200)) + _noise(2)
    crown = _ball((160, 90), 46)
    trunk = (np.abs(x - 160) < 8) & (y > 90) & (y < 196)
    spray = _ball((108, 84), 6) | _ball((213, 104), 3)
    tuft = _ball((170, 194), 5)
    leaves = np.array([60.0, 76, 36]) + _noise(5)
    photo = np.where((crown | trunk | spray | tuft)[..., None], leaves, ground)
    mask = crown | trunk
    hole, _ = taken_out(_rgb(photo), [mask], None, [mask])
    assert hole[spray].mean() > 0.6
    assert not hole[tuft & ~hole_of([mask], SHAPE)].any()
