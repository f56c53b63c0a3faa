"""What learned models change in a scene, what tells so, and what happens where they fail."""

import cv2
import numpy as np
import pytest

from physagent_studio.assets import data_folder
from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState
from physagent_studio.reconstruction import photo_hash, reconstruct, scene_hash
from physagent_studio.reconstruction.background.plate import background
from physagent_studio.reconstruction.learned.at_hand import NOTHING, Inpainting, learned_here
from physagent_studio.reconstruction.masks.learned_offers import ranked_together
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter
from physagent_studio.records import Candidate, LearnedUse, Scene
from physagent_studio.records.case import Case
from physagent_studio.session.arrays import pack_scene, unpack_scene
from physagent_studio.studio.photo_desk import PhotoDesk
from tests.reconstruction.learned.onnx_files import put, small_efficientsam, small_lama

BALL = Grounding(points=(Click(x=160, y=120),))
HORIZON = 100.0


@pytest.fixture(scope="module")
def photo():
    """(240, 320, 3): a ball with stripes on a grey floor, its upper part before a wall."""
    rng = np.random.default_rng(3)
    image = np.full((240, 320, 3), (90, 100, 110), np.float64)
    image[:100] = (100, 110, 125)
    image += rng.normal(0, 3, image.shape)
    out = np.clip(image, 0, 120).astype(np.uint8)
    ball = cv2.circle(np.zeros((240, 320), np.uint8), (160, 120), 40, 1, -1) > 0
    stripes = (np.arange(240) // 14 % 2 == 0)[:, None]
    out[ball & stripes] = (220, 30, 25)
    out[ball & ~stripes] = (220, 140, 130)
    return out


@pytest.fixture
def folder():
    return data_folder() / "models"


def _scene(photo, learned, previous=None):
    objects = (("ball", BALL),)
    case = Case("t", photo, photo_hash(photo), objects, (), (), "The ball rolls.")
    state = SceneState(objects=(SceneObject(name="ball", grounding=BALL),), horizon=HORIZON)
    return reconstruct(case, state, learned=learned, previous=previous), case, state


@pytest.fixture(scope="module")
def embedded(photo):
    """The scene, its case and its state without any model."""
    return _scene(photo, NOTHING)


def test_without_files_there_is_nothing(folder):
    assert learned_here().there == NOTHING.there == ()
    assert learned_here().key == ""
    assert not folder.exists()


def test_both_models_take_part_and_it_is_told(photo, folder, monkeypatch, embedded):
    plain, case, state = embedded
    assert plain.learned == ()
    put(monkeypatch, folder, "efficientsam", small_efficientsam(base=(0.99, 0.0, 0.0)))
    put(monkeypatch, folder, "lama", small_lama((0.1, 0.5, 0.9)))
    here = learned_here()
    assert learned_here() is here
    found, _, _ = _scene(photo, here)
    assert found.learned == (
        LearnedUse("efficientsam", ("ball",)),
        LearnedUse("lama", ("background",)),
    )
    first = found.candidates["ball"][0]
    assert (first.method, first.score) == ("efficientsam", pytest.approx(0.99))
    assert np.array_equal(first.mask, photo[..., 0] > 127)
    assert 1 < len(found.candidates["ball"]) <= 4
    assert plain.plate is not None
    assert found.plate is not None
    painted = (found.plate == (230, 128, 26)).all(axis=2)
    assert painted[:100][photo[:100, :, 0] > 200].all()
    assert not painted[101:].any()  # the floor is a known plane
    # The key knows of the models.
    assert found.hash == scene_hash(case, state, here.key) != plain.hash
    assert plain.hash == scene_hash(case, state)
    # The record is kept with the session, and with what is taken over from an earlier scene.
    assert unpack_scene(pack_scene(found), photo).learned == found.learned
    assert unpack_scene(pack_scene(plain), photo).learned == ()
    again, _, _ = _scene(photo, here, found)
    assert again is found
    moved = found.state.model_copy(update={"horizon": None, "camera": found.state.camera})
    objects = tuple(o.model_copy(update={"position": None}) for o in moved.objects)
    later = reconstruct(
        case, moved.model_copy(update={"objects": objects}), learned=here, previous=found
    )
    assert later.plate is found.plate
    assert later.learned == found.learned


@pytest.mark.parametrize(
    ("masks", "why_no_masks", "filling", "why_no_filling"),
    [
        (small_efficientsam(base=(np.nan, 0, 0)), "not finite", small_efficientsam(), "not run"),
        (small_efficientsam()[:400], "cannot read", small_lama((np.nan, 0, 0)), "not finite"),
    ],
)
def test_what_fails_is_made_the_embedded_way(
    photo, folder, monkeypatch, embedded, masks, why_no_masks, filling, why_no_filling
):
    plain, case, state = embedded
    put(monkeypatch, folder, "efficientsam", masks)
    put(monkeypatch, folder, "lama", filling)
    here = learned_here()
    assert here.key
    found, _, _ = _scene(photo, here)
    assert [(use.model, use.made) for use in found.learned] == [("efficientsam", ()), ("lama", ())]
    assert why_no_masks in found.learned[0].failed
    assert why_no_filling in found.learned[1].failed
    assert isinstance(plain, Scene)
    assert found.state == plain.state
    assert np.array_equal(found.masks["ball"], plain.masks["ball"])
    assert found.plate is not None
    assert plain.plate is not None
    assert np.array_equal(found.plate, plain.plate)
    assert found.hash == plain.hash == scene_hash(case, state, here.key)


def test_a_file_with_another_content_is_never_loaded(photo, folder, monkeypatch):
    path = put(monkeypatch, folder, "efficientsam", small_efficientsam(base=(0.99, 0, 0)))
    assert learned_here().there == ("efficientsam",)
    good = path.read_bytes()
    for data in (good[:-40], good + b"\0", good[:-1] + b"\1"):
        path.write_bytes(data)
        here = learned_here()
        assert here.there == ()
        assert "physagent models fetch efficientsam" in here.failed["efficientsam"]
        assert here.masks(photo, BALL) == ()
    # What was changed after it was checked is checked again as it is loaded.
    path.write_bytes(good)
    here = learned_here()
    assert here.there == ("efficientsam",)
    path.write_bytes(good[:-1] + b"\1")
    assert here.masks(photo, BALL) == ()
    assert "SHA-256" in here.failed["efficientsam"]


def test_the_photo_tools_offer_the_masks_too(photo, folder, monkeypatch):
    plain = PhotoDesk().masks(photo, "ball", [("ball", BALL)])["masks"]
    put(monkeypatch, folder, "efficientsam", small_efficientsam(base=(0.99, 0.0, 0.0)))
    early = []
    asked = [("ball", BALL)]
    led = PhotoDesk().masks(photo, "ball", asked, early=early.append)["masks"]
    assert led[0]["score"] == 0.99
    assert len(led) <= 4
    assert plain[0]["score"] != 0.99


def test_embedded_masks_are_told_before_the_network_runs(photo, folder, monkeypatch):
    put(monkeypatch, folder, "efficientsam", small_efficientsam(base=(0.99, 0.0, 0.0)))
    told = []
    segmenter = EmbeddedSegmenter(learned=learned_here())
    found = segmenter.completed(
        photo, [("ball", BALL)], {}, meanwhile=lambda name, offers: told.append(offers())
    )
    assert all(one.method != "efficientsam" for one in told[-1])
    assert found["ball"][0].method == "efficientsam"
    # Once nobody waits the network is not asked.
    told.clear()
    left = segmenter.completed(
        photo, [("ball", BALL)], {}, lambda: bool(told), meanwhile=lambda *offers: told.append(1)
    )
    assert all(one.method != "efficientsam" for one in left["ball"])


def test_of_two_masks_that_are_almost_one_the_better_is_offered():
    mask = np.zeros((40, 40), bool)
    mask[5:30, 5:30] = True
    nearly, other = mask.copy(), np.roll(mask, 9, 1)
    nearly[5, 5] = False
    ours = (Candidate(mask, 0.8, "ours"), Candidate(other, 0.5, "ours"))
    theirs = (Candidate(nearly, 0.9, "theirs"), Candidate(~mask, 0.5, "theirs"))
    ranked = ranked_together(ours, theirs)
    assert [(one.method, one.score) for one in ranked] == [
        ("theirs", 0.9),
        ("ours", 0.5),
        ("theirs", 0.5),
    ]
    assert ranked_together(ours, ()) == ours


def test_without_a_camera_no_plane_is_known(photo, folder, monkeypatch):
    put(monkeypatch, folder, "lama", small_lama((0.1, 0.5, 0.9)))
    inpaint = Inpainting(learned_here(), None)
    ball = photo[..., 0] > 127
    plate = background(photo, [ball], inpaint=inpaint)
    assert inpaint.used
    assert (plate[ball] == (230, 128, 26)).all()
