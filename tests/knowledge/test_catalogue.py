"""The tables of kinds and paces are whole, and are found by the words that people use."""

from collections import Counter

import pytest

from physagent_studio.agent.rules.contract.intents import ACTIVE
from physagent_studio.errors import InputError
from physagent_studio.knowledge import (
    catalogue,
    colour_bounds,
    colours,
    kind_of,
    kinds,
    materials,
    pace_of,
    paces,
    usual_size,
    word_lists,
)
from physagent_studio.language.tokens import vocabulary as v

STATES = {"withdrawn", "end", "wind"}
"""What sets things going without a speed of its own: a support taken away, an end, the air."""


def test_no_word_stands_for_two_kinds():
    words = Counter(word for kind in kinds() for word in (kind.name, *kind.synonyms))
    assert [word for word, count in words.items() if count > 1] == []
    assert len(kinds()) >= 60
    assert len({pace.sense for pace in paces()}) == len(paces())


def _listed(text: str) -> list[str]:
    """The words of a list."""
    return text.split()


COCO = [
    "person",
    "bicycle",
    "car",
    "motorcycle",
    "airplane",
    "bus",
    "train",
    "truck",
    "boat",
    "traffic_light",
    "fire_hydrant",
    "stop_sign",
    "parking_meter",
    "bench",
    "bird",
    "cat",
    "dog",
    "horse",
    "sheep",
    "cow",
    "elephant",
    "bear",
    "zebra",
    "giraffe",
    "backpack",
    "umbrella",
    "handbag",
    "tie",
    "suitcase",
    "frisbee",
    "skis",
    "snowboard",
    "sports_ball",
    "kite",
    "baseball_bat",
    "baseball_glove",
    "skateboard",
    "surfboard",
    "tennis_racket",
    "bottle",
    "wine_glass",
    "cup",
    "fork",
    "knife",
    "spoon",
    "bowl",
    "banana",
    "apple",
    "sandwich",
    "orange",
    "broccoli",
    "carrot",
    "hot_dog",
    "pizza",
    "donut",
    "cake",
    "chair",
    "couch",
    "potted_plant",
    "bed",
    "dining_table",
    "toilet",
    "tv",
    "laptop",
    "mouse",
    "remote",
    "keyboard",
    "cell_phone",
    "microwave",
    "oven",
    "toaster",
    "sink",
    "refrigerator",
    "book",
    "clock",
    "vase",
    "scissors",
    "teddy_bear",
    "hair_drier",
    "toothbrush",
]
"""The classes of the COCO data set."""
YCB = [
    "master_chef_can",
    "cracker_box",
    "sugar_box",
    "tomato_soup_can",
    "mustard_bottle",
    "tuna_fish_can",
    "pudding_box",
    "gelatin_box",
    "potted_meat_can",
    "banana",
    "strawberry",
    "apple",
    "lemon",
    "peach",
    "pear",
    "orange",
    "plum",
    "pitcher_base",
    "bleach_cleanser",
    "windex_bottle",
    "wine_glass",
    "bowl",
    "mug",
    "sponge",
    "skillet",
    "lid",
    "plate",
    "fork",
    "spoon",
    "knife",
    "spatula",
    "power_drill",
    "wood_block",
    "scissors",
    "padlock",
    "key",
    "large_marker",
    "small_marker",
    "adjustable_wrench",
    "phillips_screwdriver",
    "flat_screwdriver",
    "hammer",
    "medium_clamp",
    "large_clamp",
    "extra_large_clamp",
    "mini_soccer_ball",
    "softball",
    "baseball",
    "tennis_ball",
    "racquetball",
    "golf_ball",
    "chain",
    "foam_brick",
    "dice",
    "marbles",
    "cups",
    "toy_airplane",
    "lego_duplo",
    "rubiks_cube",
    "nine_hole_peg_test",
    "t_shirt",
    "magazine",
    "timer",
]
"""The objects of the YCB set, but for those of one kind that are only numbered."""


def test_all_coco_classes_and_ycb_objects_have_a_size():
    assert len(COCO) == 80
    unknown = [name for name in (*COCO, *YCB) if not usual_size(name).known]
    assert unknown == []


def test_every_row_is_complete():
    for kind in kinds():
        assert kind.material in materials(), kind.name
        assert kind.ground is None or kind.ground in materials(), kind.name
        assert set(kind.colours) <= colours().keys(), kind.name
        place = kind.support or kind.surface or kind.name in PLACES
        assert kind.size is not None or place, f"{kind.name} has no size"
        # What is hollow or a frame weighs less than what it is made of.
        if kind.density is not None:
            assert kind.density <= 1.05 * max(materials()[kind.material].density, 2500), kind.name


PLACES = ("water", "rail", "belt", "bridge", "goal", "gate", "hole", "target")
"""What has no size of its own: a picture shows a part of it."""


def test_the_tables_speak_of_each_other():
    for name, row in materials().items():
        assert set(row.colours) <= colours().keys(), name
    assert {word.kind for word in colours().values()} - {""} <= colour_bounds().keys()
    assert set(word_lists().meant.values()) <= materials().keys()


def test_an_error_says_row_and_field(tmp_path, monkeypatch):
    text = "- {name: ball, material: rubber}\n- {name: box, material: wood, colour: [red]}\n"
    (tmp_path / "objects.yaml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(catalogue, "__file__", str(tmp_path / "catalogue.py"))
    with pytest.raises(InputError, match=r"objects.yaml, row 2 (.|\n)*colour"):
        catalogue.kinds.__wrapped__()


def test_what_runs_on_wheels_faces_along_an_axis_or_says_that_it_does_not():
    wheeled = [kind for kind in kinds() if kind.wheels]
    assert len(wheeled) >= 25
    assert {kind.wheels for kind in wheeled} == {"long_axis", "short_axis", "any_way"}
    assert not any(kind.wheels for kind in kinds() if kind.name in ("ball", "can", "box", "sled"))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("toy_car", "toy_car"), ("red_toy_cars", "toy_car"), ("car_2", "car"), ("buses", "bus"),
        ("office_chair", "office_chair"), ("red_office_chair_1", "office_chair"),
        ("wooden_chair", "chair"), ("roller_skates", "roller_skate"), ("car_box", "box"),
        ("trash_can", "bin"), ("knives", "knife"), ("leaves", "leaf"), ("gadget", None),
        ("scooter", "scooter"), ("batteries", "battery"), ("dummies", None), ("", None),
    ],
)  # fmt: skip
def test_a_name_is_known_by_its_last_words(name: str, kind: str | None):
    found = kind_of(name)
    assert (None if found is None else found.name) == kind


def test_every_sense_of_motion_has_a_pace():
    told = {verb.sense for verb in v.VERBS.values() if verb.kind in ("move", "act", "goto")}
    told |= {*v.COMBINED.values(), *v.WITH_OBJECT.values(), *ACTIVE} - STATES
    states = {verb.sense for verb in v.VERBS.values() if verb.kind not in ("move", "act", "goto")}
    missing = {s for s in told - states - STATES - {"lose"} if pace_of(s) is None}
    assert missing == set()


def test_slow_is_slower_and_fast_is_faster():
    for pace in paces():
        for unit in ("metres", "lengths"):
            slow, plain, fast = (getattr(getattr(pace, m), unit) for m in ("slow", "plain", "fast"))
            assert slow.usual < plain.usual < fast.usual, pace.sense
            assert slow.low <= plain.low <= fast.low, pace.sense
            assert slow.high <= plain.high <= fast.high, pace.sense
