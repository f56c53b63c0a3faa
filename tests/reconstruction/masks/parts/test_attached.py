"""Parts of another colour join the mask of the thing they are attached to; others do not."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.parts.attached import led_by, with_attached
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.scene import Candidate

HEIGHT, WIDTH = 300, 400
FLOOR, WALL = (150, 128, 104), (196, 200, 206)
NOTHING = Grounding(points=(Click(x=200, y=190, label=1),))


def _scene(grain: float = 5.0) -> np.ndarray:
    """A wall above a floor, both with grain."""
    rng = np.random.default_rng(7)
    image = np.empty((HEIGHT, WIDTH, 3))
    image[:170], image[170:] = WALL, FLOOR
    rough = cv2.GaussianBlur(rng.normal(0, 1, (HEIGHT, WIDTH)), (0, 0), 1.2)
    return image + grain / rough.std() * rough[..., None]


def _painted(image: np.ndarray, mask: np.ndarray, colour: tuple[int, int, int]) -> None:
    """A shaded surface of one colour over a part of the picture."""
    shade = np.linspace(1.12, 0.8, WIDTH)[None, :, None]
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 0.8)[..., None]
    image[:] = image * (1 - soft) + soft * shade * np.array(colour)


def _drawn(what, *args) -> np.ndarray:
    canvas = np.zeros((HEIGHT, WIDTH), np.uint8)
    what(canvas, *args)
    return canvas.astype(bool)


def _polygon(*points) -> np.ndarray:
    return _drawn(cv2.fillPoly, [np.array(points, np.int32)], 1)


def _line(a, b, width: int) -> np.ndarray:
    return _drawn(cv2.line, a, b, 1, width)


BODIES = {
    "gourd": _drawn(cv2.ellipse, (200, 195), (62, 48), 0, 0, 360, 1, -1),
    "bottle": _polygon((165, 150), (235, 150), (240, 262), (160, 262)),
    "trolley": _polygon((110, 226), (290, 226), (290, 250), (110, 250)),
    "mug": _polygon((160, 140), (240, 140), (234, 250), (166, 250)),
}
PARTS = {
    "stem": ("gourd", _polygon((192, 155), (208, 155), (214, 108), (200, 106)), (44, 70, 40)),
    "cap": ("bottle", _polygon((182, 118), (218, 118), (218, 152), (182, 152)), (190, 40, 48)),
    "pole": ("trolley", _line((282, 232), (252, 120), 9), (40, 42, 46)),
    "handle": ("mug", _drawn(cv2.ellipse, (234, 195), (36, 34), 0, -90, 90, 1, 10), (60, 96, 190)),
    "leg": ("bottle", _polygon((190, 258), (208, 258), (206, 292), (192, 292)), (52, 48, 120)),
}
COLOURS = {
    "gourd": (226, 120, 30),
    "bottle": (70, 130, 80),
    "trolley": (214, 60, 50),
    "mug": (236, 232, 220),
}


@pytest.mark.parametrize("name", PARTS)
def test_a_part_of_another_colour_joins(name: str) -> None:
    kind, part, colour = PARTS[name]
    body, image = BODIES[kind], _scene()
    _painted(image, part, colour)
    _painted(image, body, COLOURS[kind])
    found = with_attached(np.clip(image, 0, 255).astype(np.uint8), body, NOTHING)
    assert found is not None
    assert iou(found, body | part) > 0.94 > 0.9 * iou(body, body | part)
    own = part & ~body
    assert found[own].mean() > 0.8
    assert (found & ~(body | part)).sum() < 0.15 * own.sum() + 40


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("beside", ["line", "shadow", "tiles", "neighbour", "gloss"])
def test_what_lies_beside_does_not_join(kind: str, beside: str) -> None:
    body, image = BODIES[kind], _scene()
    if beside == "line":
        _painted(image, _line((0, 240), (WIDTH, 222), 5), (226, 224, 218))
    if beside == "shadow":
        below = _drawn(cv2.ellipse, (232, 254), (86, 13), 0, 0, 360, 1, -1)
        image *= 1 - 0.5 * cv2.GaussianBlur(below.astype(np.float32), (0, 0), 4)[..., None]
    if beside == "tiles":
        for x in range(0, WIDTH, 24):
            _painted(image, _line((x, 170), (2 * x - 200, HEIGHT), 2), (112, 92, 74))
    if beside == "neighbour":
        _painted(image, _drawn(cv2.circle, (326, 210), 44, 1, -1), (40, 90, 170))
    if beside == "gloss":
        low = int(np.flatnonzero(body.any(1))[-1])
        mirrored = np.zeros_like(body)
        mirrored[low:] = body[2 * low - HEIGHT + 1 : low + 1][::-1]
        seen = 0.35 * cv2.GaussianBlur(mirrored.astype(np.float32), (0, 0), 2)[..., None]
        image[:] = (1 - seen) * image + seen * np.array(COLOURS[kind])
    _painted(image, body, COLOURS[kind])
    found = with_attached(np.clip(image, 0, 255).astype(np.uint8), body, NOTHING)
    assert found is None or iou(found, body) > 0.97


@pytest.mark.parametrize(("blur", "joins"), [(0.0, True), (4.0, False)])
def test_what_is_out_of_focus_behind_a_thing_does_not_join(blur: float, joins: bool) -> None:
    """The same cap joins where it is as sharp as the bottle."""
    _, part, colour = PARTS["cap"]
    body, image = BODIES["bottle"], _scene()
    _painted(image, part, colour)
    if blur:
        image = cv2.GaussianBlur(image, (0, 0), blur)
    _painted(image, body, COLOURS["bottle"])
    found = with_attached(np.clip(image, 0, 255).astype(np.uint8), body, NOTHING)
    assert (found is not None and bool((found & part)[:140].any())) == joins


def test_what_holds_a_click_outside_or_leaves_the_box_does_not_join() -> None:
    kind, part, colour = PARTS["stem"]
    body, image = BODIES[kind], _scene()
    _painted(image, part, colour)
    _painted(image, body, COLOURS[kind])
    picture = np.clip(image, 0, 255).astype(np.uint8)
    denied = NOTHING.model_copy(update={"points": (*NOTHING.points, Click(x=205, y=130, label=0))})
    found = with_attached(picture, body, denied)
    assert found is None or not found[part & ~body].any()
    boxed = NOTHING.model_copy(update={"box": (136.0, 145.0, 264.0, 245.0)})
    found = with_attached(picture, body, boxed)
    assert found is None or not found[:140].any()


def test_the_mask_with_its_parts_leads_and_the_one_without_comes_next() -> None:
    kind, part, colour = PARTS["stem"]
    body, image = BODIES[kind], _scene()
    _painted(image, part, colour)
    _painted(image, body, COLOURS[kind])
    picture = np.clip(image, 0, 255).astype(np.uint8)
    small = np.roll(body, 9, 1) & body
    offers = [Candidate(body, 0.9, "colour"), Candidate(small, 0.8, "a"), Candidate(part, 0.7, "b")]
    offers.append(Candidate(np.roll(body, 20, 0), 0.5, "with shadow"))
    found = with_attached(picture, body, NOTHING)
    assert found is not None
    led = led_by(found, offers)
    assert [offer.method for offer in led] == ["colour and parts", "colour", "a", "with shadow"]
    assert led[0].mask[part].mean() > 0.8
    # A ball has no stem: nothing joins that makes it less like one.
    assert led_by(found, offers, (0.77, 0.05)) == tuple(offers)
    # There are four still where others hardly differ from the one that leads.
    near = Candidate(found, 0.8, "near")
    led = led_by(found, [offers[0], near, near, offers[-1]])
    assert [offer.method for offer in led] == ["colour and parts", "colour", "near", "with shadow"]
