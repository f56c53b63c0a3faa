"""Things of one kind are equally tall: a foot that is read too low does not move one of them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Click, Cylinder, Grounding, SceneObject, SceneState
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.grounding.same_kind import kind_name
from physagent_studio.reconstruction.placement.alike_sizes import (
    Stood,
    seen_whole,
    shared_distances,
)
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.records.case import Case

CAMERA = Camera.from_horizon((320, 240), 60.0, 0.5, focal=400.0, source="given", confirmed=True)


def _stood(name, distance, height, low=0.0, **changes):
    """A thing seen with a focal length of 400 from half a metre up, its foot read too low."""
    top, foot = 60 + 400 * (0.5 - height) / distance, 60 + 200 / distance + low
    width = 400 * height / distance / 3
    return replace(Stood(name, "floor", foot, 60.0, top, width, 0.06), **changes)


def _distance(thing, found):
    return 200 / (thing.foot - 60) * found.get(thing.name, 1.0)


def test_a_foot_that_was_read_too_low_moves_up():
    things = [_stood(f"pin_{k}", 2.0, 0.38) for k in range(3)]
    low = _stood("pin_9", 2.0, 0.38, low=4)
    found = shared_distances([*things, low])
    assert 1.01 < found["pin_9"] < 1.05
    before, after = abs(_distance(low, {}) - 2.0), abs(_distance(low, found) - 2.0)
    assert after < 0.75 * before
    assert all(abs(found.get(one.name, 1.0) - 1) < 0.01 for one in things)


def test_what_a_person_set_speaks_for_all_and_stays():
    mine = _stood("can_1", 2.0, 0.30, fixed=True)
    found = shared_distances([mine, _stood("can_2", 2.0, 0.30, low=4)])
    assert set(found) == {"can_2"}
    assert found["can_2"] > 1


@pytest.mark.parametrize(
    "other",
    [
        _stood("ball", 2.0, 0.39),
        _stood("pin_2", 2.0, 0.39, plane="table"),
        _stood("pin_2", 2.0, 0.39, width=60.0),
        _stood("pin_2", 2.0, 0.80),
    ],
    ids=["another kind", "another plane", "another silhouette", "another size"],
)
def test_what_is_not_alike_is_left_alone(other):
    assert shared_distances([_stood("pin_1", 2.0, 0.38), other]) == {}


def test_names_of_one_kind():
    assert kind_name("red_stone") == kind_name("stone_2") == "stone"
    assert kind_name("top_orange") == kind_name("orange") == "orange"


def test_cut_and_covered_things_do_not_count():
    mask = np.zeros((60, 80), bool)
    mask[20:40, 30:50] = True
    front = np.zeros_like(mask)
    front[30:50, 25:60] = True
    assert seen_whole("a", {"a": mask})
    assert not seen_whole("a", {"a": mask & ~front, "b": front})
    edge = np.zeros_like(mask)
    edge[20:40, :20] = True
    assert not seen_whole("a", {"a": edge})


def test_a_reflection_under_one_of_three_pins_moves_it_less():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 255, (240, 320, 3), dtype=np.uint8)
    shape = Cylinder(radius=0.06, height=0.38)
    mesh = mesh_of(shape)
    names = ("left_pin", "middle_pin", "right_pin")
    true = {name: np.array([0.2 * k - 0.2, 1.2, 0.19]) for k, name in enumerate(names)}
    masks = {n: silhouette(CAMERA, mesh.vertices + p, mesh.faces) for n, p in true.items()}
    grown = masks["right_pin"].copy()
    grown[5:] |= masks["right_pin"][:-5]
    masks["right_pin"] = cv2.morphologyEx(
        grown.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    ).astype(bool)
    case = Case(
        name="pins",
        image=image,
        image_hash=photo_hash(image),
        objects=tuple((n, Grounding(points=(Click(x=1, y=1),))) for n in names),
        supports=(),
        landmarks=(),
        prompt="The pins stay.",
    )

    def depth_of_right(names_given):
        objects = tuple(
            SceneObject(name=new, grounding=Grounding(points=(Click(x=1, y=1),)), form="cylinder")
            for new in names_given
        )
        known = {new: masks[old] for new, old in zip(names_given, names, strict=True)}
        state = SceneState(camera=CAMERA, objects=objects)
        scene = reconstruct(case, state, segmenter=TrueMasks(known))
        found = scene.state.object(names_given[2])
        assert found is not None
        assert found.position is not None
        return found.position[1]

    together, alone = depth_of_right(names), depth_of_right(("object_1", "object_2", "object_3"))
    assert alone < 1.2 - 0.03
    assert abs(together - 1.2) < 0.8 * abs(alone - 1.2)
