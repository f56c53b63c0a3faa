"""Names, words, edges, horizon and metres."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.synthetic import scene
from physagent_studio.knowledge import support_kind, usual_size
from physagent_studio.language.hints import called, hints
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Landmark, Ramp, Scale, SceneState, Support
from physagent_studio.reconstruction.camera import estimate as cues
from physagent_studio.reconstruction.camera.scale import FLOOR, Measured, solve
from physagent_studio.reconstruction.photo.ellipses import level_circles
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.supports.clicked import marked_ramp
from physagent_studio.reconstruction.supports.ramps import (
    Profile,
    find_profile,
    place_ramp,
)
from physagent_studio.reconstruction.supports.stances import read
from physagent_studio.reconstruction.supports.standing import lifted, standing_on
from physagent_studio.reconstruction.survey.frames import find_frame
from physagent_studio.reconstruction.survey.landmarks import Shown, resolve


@pytest.mark.parametrize(
    ("name", "metres"),
    [
        ("soccer_ball", 0.22),
        ("left_pin2", 0.38),
        ("red_toy_car", 0.10),
        ("three_oranges", 0.08),
        ("mystery", 0.30),
    ],
)
def test_usual_sizes(name, metres):
    assert usual_size(name).metres == pytest.approx(metres)


def test_the_sentence_makes_a_name_more_special():
    assert usual_size("yellow_stone").metres != pytest.approx(0.29)
    words = "A red curling stone slides toward a yellow stone."
    assert usual_size(called("yellow_stone", words)).metres == pytest.approx(0.29)


def test_an_unknown_name_says_so():
    assert not usual_size("gizmotron").known


@pytest.mark.parametrize(
    ("name", "kind"),
    [("grass_field", "floor"), ("acrylic_ramp", "ramp"), ("brick_wall", "wall"), ("desk", "slab")],
)
def test_kinds_of_supports(name, kind):
    assert support_kind(name) == kind


def test_words_that_lift_belong_to_the_nearest_noun():
    names = {"pumpkin": 0, "wooden_stool": 0}
    words = "A huge pumpkin hangs directly above a small wooden stool."
    assert hints(words, names).aloft == {"pumpkin"}


@pytest.mark.parametrize(
    ("words", "aloft"),
    [
        ("The glass rises off the table, hovers in the air and drops back down.", set()),
        ("The balloon jumps up. It floats in the air.", set()),
        ("The balloon floats in the air and then rises.", {"balloon"}),
        ("The cup is thrown at the lamp that hangs there.", {"lamp"}),
        ("The cup is thrown at the balloon that floats in the air.", {"balloon"}),
        ("The cup bounces off the floor and hits the balloon hovering above.", {"balloon"}),
    ],
)
def test_what_goes_up_first_does_not_hang_there_to_begin_with(words, aloft) -> None:
    assert hints(words, ["glass", "balloon", "cup", "lamp"]).aloft == aloft


def test_stacks_are_read_from_masks():
    masks = {name: np.zeros((200, 200), bool) for name in ("top", "low", "far")}
    masks["top"][40:80, 60:120] = True
    masks["low"][80:130, 50:130] = True
    masks["far"][60:90, 150:190] = True
    stances = read(masks)
    assert stances["top"].on == "low"
    assert stances["low"].on is None
    assert stances["far"].on is None
    assert stances["low"].foot == (90.0, 130.0)


@pytest.mark.parametrize(("right", "on"), [(115, "left"), (160, None)])
def test_what_straddles_two_side_by_side_stands_on_one_of_them(right, on):
    masks = {name: np.zeros((200, 200), bool) for name in ("top", "left", "right")}
    masks["top"][40:80, 70:140] = True
    masks["left"][80:130, 40:100] = True
    masks["right"][80:130, right : right + 60] = True
    assert read(masks)["top"].on == on


def test_the_top_of_a_pyramid_stands_on_one_of_two_with_its_middle_between_them():
    masks = {name: np.zeros((200, 200), bool) for name in ("top", "left", "right")}
    masks["top"][40:80, 62:102] = True
    masks["left"][80:120, 40:80] = True
    masks["right"][80:120, 84:124] = True
    assert read(masks)["top"].on in ("left", "right")
    assert read({name: masks[name] for name in ("top", "left")})["top"].on is None


@pytest.mark.parametrize(
    ("foot", "on"), [((100, 90), "ramp"), ((100, 140), "floor"), ((5, 60), "floor")]
)
def test_a_foot_well_within_a_slope_that_is_seen_from_above_is_on_it(foot, on):
    """Neither one before it nor one at its side, whatever the edges of its outline say."""
    slope = np.zeros((200, 200), bool)
    slope[40:130, 10:190] = True
    x, y = foot
    thing = np.zeros((200, 200), bool)
    thing[y - 30 : y, max(0, x - 10) : x + 10] = True
    state = SceneState(supports=(Support(name="ramp"),))
    profile = Profile(toe=(180.0, 190.0), top=(20.0, 180.0), end=(20.0, 180.0))
    stances = read({"thing": thing})
    seen = standing_on(state, stances, {"ramp": slope & ~thing}, {"ramp": profile})
    assert seen["thing"] == on


def test_what_is_behind_something_does_not_stand_on_it():
    masks = {name: np.zeros((200, 200), bool) for name in ("behind", "front")}
    masks["behind"][20:100, 60:120] = True
    masks["front"][40:140, 70:130] = True
    masks["behind"] &= ~masks["front"]
    assert read(masks)["behind"].on is None


def _camera(pitch: float, height: float = 1.0, focal: float = 579.0) -> Camera:
    row = 240 - focal * math.tan(math.radians(pitch))
    return Camera.from_horizon((832, 480), row, height, focal=focal)


def test_sizes_of_known_things_give_the_horizon_and_metres():
    camera = _camera(14)
    spots = np.array([[-0.4, 2.0, 0], [0.3, 3.5, 0], [0.1, 5.0, 0]])
    feet, depth = camera.project(spots)
    extents = 579.0 * 0.38 / depth
    blank = np.full((480, 832, 3), 128, np.uint8)
    standing = [
        cues.Standing(float(v), float(e), 0.38, 0.04, "floor")
        for (_, v), e in zip(feet, extents, strict=True)
    ]
    found = cues.estimate((832, 480), segments(blank), standing)
    assert found.row == pytest.approx(camera.horizon, abs=15)


def test_level_edges_give_the_horizon():
    camera = _camera(18)
    image = np.full((480, 832, 3), 200, np.uint8)
    for k in range(-6, 7):
        ends = camera.project(np.array([[0.35 * k, 1.8, 0], [0.35 * k, 9.0, 0]]))[0]
        near, far = ((int(x), int(y)) for x, y in ends)
        cv2.line(image, near, far, (40, 40, 40), 3, cv2.LINE_AA)
    found = cues.estimate((832, 480), segments(image), [])
    assert found.row == pytest.approx(camera.horizon, abs=12)
    assert found.sigma < 60


def test_a_given_size_wins():
    ball = Measured("ball", "floor", 0.2, usual_size("soccer_ball"))
    free = solve([ball], {}, Scale(), None)
    given = solve([ball], {}, Scale(reference="ball", metres=1.0, source="person"), None)
    assert free.camera == pytest.approx(1.1)
    assert given.camera == pytest.approx(5.0)
    assert given.scale.source == "person"


def test_a_table_is_as_high_as_the_sizes_on_and_below_it_say():
    apple = usual_size("apple")
    seen = [Measured("a", "table", 0.16, apple), Measured("b", "floor", 0.08, apple)]
    heights = solve(seen, {"table": 0.75}, Scale(), None)
    assert heights.camera == pytest.approx(1.0)
    assert heights.tops["table"] == pytest.approx(0.5)
    alone = solve(seen[:1], {"table": 0.75}, Scale(), None)
    assert alone.tops["table"] == pytest.approx(0.75)
    assert alone.camera == pytest.approx(0.75 + 0.5)


def test_ramp_from_three_clicks():
    camera = _camera(15)
    truth = Ramp(toe=(0.1, 2.5, 0), yaw=0.3, run=0.8, rise=0.3, width=0.4)
    ahead = np.array([math.cos(0.3), math.sin(0.3), 0]) * 0.8
    side = np.array([-math.sin(0.3), math.cos(0.3), 0]) * -0.2
    toe = np.array(truth.toe) + side
    pixels = camera.project(np.array([toe, toe + ahead, toe + ahead + [0, 0, 0.3]]))[0]
    toe, foot, top = (tuple(p) for p in pixels)
    found = marked_ramp(camera, [toe], [foot], top)
    assert found is not None
    assert math.atan2(found.rise, found.run) == pytest.approx(math.atan2(0.3, 0.8), abs=1e-6)
    assert found.run == pytest.approx(0.8, rel=1e-6)


def test_ramp_from_its_edges():
    image = np.full((480, 832, 3), 190, np.uint8)
    outline = np.array([[150, 380], [600, 380], [300, 220], [150, 220]])
    cv2.fillPoly(image, [outline], (90, 110, 130), cv2.LINE_AA)
    profile = find_profile(segments(image), [(300.0, 320.0)], (832, 480))
    assert profile is not None
    assert profile.toe == pytest.approx((600, 380), abs=8)
    assert profile.top == pytest.approx((300, 220), abs=8)
    assert profile.end[0] == pytest.approx(150, abs=8)
    ramp = place_ramp(_camera(12), profile)
    assert ramp is not None
    assert ramp.yaw == pytest.approx(math.pi)
    assert ramp.plateau > 0.2 * ramp.run


def test_a_goal_is_found_and_stands_upright():
    camera = _camera(3, height=1.5)
    corners = np.array([[-3, 12, 0], [3, 12, 0], [3, 12, 2.4], [-3, 12, 2.4]], float)
    pixels = camera.project(corners)[0]
    image = np.full((480, 832, 3), 110, np.uint8)
    for a, b in ((0, 3), (3, 2), (2, 1)):
        (ax, ay), (bx, by) = pixels[a], pixels[b]
        ends = (int(ax), int(ay)), (int(bx), int(by))
        cv2.line(image, *ends, (250, 250, 250), 5, cv2.LINE_AA)
    frame = find_frame(image, np.zeros((480, 832), bool))
    assert frame is not None
    goal = Landmark(name="goal", kind="opening")
    (found,), flags = resolve((goal,), camera, (), Shown(frame))
    assert not flags
    assert found.points is not None
    assert np.array(found.points) == pytest.approx(corners, abs=0.7)
    assert found.source == "estimated"


def test_the_middle_of_a_target_is_that_of_the_circle():
    camera = _camera(25)
    turn = np.linspace(0, 2 * math.pi, 60)
    rim = np.stack([0.2 + 0.6 * np.cos(turn), 2.4 + 0.6 * np.sin(turn), 0 * turn], 1)
    image = np.full((480, 832, 3), 225, np.uint8)
    cv2.fillPoly(image, [camera.project(rim)[0].astype(np.int32)], (40, 40, 200), cv2.LINE_AA)
    circles = tuple(level_circles(image))
    target = Landmark(name="target_centre", kind="point")
    (found,), _ = resolve((target,), camera, (), Shown(None, circles))
    assert found.points is not None
    assert found.points[0] == pytest.approx((0.2, 2.4, 0), abs=0.03)


def test_a_landmark_that_nothing_shows_stays_open():
    camera = scene(1).camera
    (found,), flags = resolve((Landmark(name="goal", kind="opening"),), camera, (), Shown())
    assert found.points is None
    assert "goal" in flags[0]


@pytest.mark.parametrize(
    ("prompt", "on"),
    [
        ("The ball drops, bounces off the box and rolls away.", AIR),
        ("The ball lands on the box and stays on top of it.", AIR),
        ("The ball rolls to the left.", FLOOR),
        ("The ball falls on the floor beside the box.", FLOOR),
    ],
)
def test_what_drops_onto_a_thing_seen_below_it_is_in_the_air(prompt, on):
    """What stands farther away is seen higher too: without the words it may stand on the floor."""
    camera = Camera.from_horizon((320, 240), 56.0, 1.0, focal=300.0)
    masks = {name: np.zeros((240, 320), bool) for name in ("ball", "box")}
    masks["ball"][90:120, 145:175] = True
    masks["box"][150:200, 130:190] = True
    told = hints(prompt, tuple(masks))
    stances = read(masks, told)
    assert stances["ball"].over == "box"
    usual = {name: told.usual(name) for name in masks}
    floored = dict.fromkeys(masks, FLOOR)
    assert lifted(camera, SceneState(), stances, floored, usual)["ball"] == on
