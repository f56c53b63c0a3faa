"""What goes into the networks and what is made of what comes out; real OpenCV, small networks."""

import numpy as np
import pytest

from physagent_studio.errors import Cancelled
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.learned import lama
from physagent_studio.reconstruction.learned.efficient_sam import prompt_of, proposals
from physagent_studio.reconstruction.learned.lama import inpainted
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.reconstruction.learned.zoo import ModelFailed
from tests.reconstruction.learned.onnx_files import small_efficientsam, small_lama


def _clicked(*points, box=None):
    return Grounding(points=tuple(Click(x=x, y=y, label=label) for x, y, label in points), box=box)


@pytest.fixture(scope="module")
def coloured():
    """(60, 80, 3): a red square and a green one that overlap, and a blue rim."""
    image = np.zeros((60, 80, 3), np.uint8)
    image[10:40, 10:40, 0] = 255
    image[20:50, 30:70, 1] = 255
    image[:4, :, 2] = 255
    return image


def test_a_prompt_is_in_pixels_of_the_square():
    prompt = prompt_of(_clicked((40, 30, 1), (1, 1, 0), box=(60, 50, 20, 10)), (60, 80, 3))
    assert prompt is not None
    points, labels = prompt
    assert points.shape == (1, 1, 6, 2)
    assert labels.shape == (1, 1, 6, 1)
    assert labels.ravel().tolist() == [2, 3, 1, -1, -1, -1]
    expected = np.array([[20, 10], [60, 50], [40, 30]]) * (1024 / 80, 1024 / 60)
    assert np.allclose(points[0, 0, :3], expected)
    assert not points[0, 0, 3:].any()
    many = prompt_of(_clicked(*((x, 5, 1) for x in range(9))), (60, 80, 3))
    assert many is not None
    assert many[1].ravel().tolist() == [1] * 6
    assert prompt_of(_clicked((3, 3, 0)), (60, 80, 3)) is None


def test_masks_are_ranked_by_their_predicted_iou(coloured):
    network = Network(small_efficientsam(base=(0.3, 0.9, 1.7)))
    found = proposals(network, coloured, _clicked((35, 30, 1)))
    # Blue does not cover the click.
    assert [one.score for one in found] == pytest.approx([0.9, 0.3])
    for one, channel in zip(found, (1, 0), strict=True):
        assert one.method == "efficientsam"
        assert np.array_equal(one.mask, coloured[..., channel] > 127)
    outside = proposals(network, coloured, _clicked((35, 30, 1), (60, 30, 0)))
    assert [one.score for one in outside] == pytest.approx([0.3])


def test_the_network_sees_clicks_and_labels(coloured):
    coords, labels = np.zeros((12, 3)), np.zeros((6, 3))
    coords[0, 0] = coords[1, 1] = 1 / 1024
    labels[0, 0], labels[5, 1] = 0.1, -0.2
    found = proposals(
        Network(small_efficientsam(coords=coords, labels=labels)), coloured, _clicked((32, 36, 1))
    )
    scores = [36 / 60 + 0.2, 32 / 80 + 0.1]
    assert [one.score for one in found] == pytest.approx(scores, abs=1e-5)


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "cannot read"),
        (b"no network at all", "cannot read"),
        (small_efficientsam()[:300], "cannot read"),
        (small_lama(), "does not run"),
        (small_efficientsam(base=(0.1, np.nan, 0.2)), "iou_predictions has values"),
        (small_efficientsam(at=np.nan), "output_masks has values"),
        (small_efficientsam(mask_shape=(1, 3, 1024, 1024)), "output_masks has the shape"),
        (small_efficientsam(mask_shape=(1, 1, 1, 3072, 1024)), "output_masks has the shape"),
    ],
)
def test_another_network_fails_in_one_sentence(coloured, data, what):
    with pytest.raises(ModelFailed, match=what):
        proposals(Network(data), coloured, _clicked((35, 30, 1)))


@pytest.mark.parametrize("size", [(40, 60), (600, 400), (700, 1100)])
def test_a_hole_is_filled_at_the_resolution_of_the_photo(size):
    rng = np.random.default_rng(1)
    photo = rng.integers(0, 256, (*size, 3)).astype(np.uint8)
    hole = np.zeros(size, bool)
    hole[size[0] // 4 : -size[0] // 8, 8 : -size[1] // 4] = True
    hole[2:5, -6:-2] = True
    filled = inpainted(Network(small_lama((0.1, 0.5, 0.9))), photo, hole, lambda: False)
    assert np.array_equal(filled[~hole], photo[~hole])
    # The network has blue first.
    assert np.unique(filled[hole], axis=0).tolist() == [[230, 128, 26]]


def test_a_large_hole_is_filled_from_its_rim_inwards(monkeypatch):
    """Every window sees what was filled before: none has but a hole in it."""
    seen = []

    def spread(network, part, missing):
        seen.append(float((~missing).mean()))
        return np.full_like(part, part[~missing].max())

    monkeypatch.setattr(lama, "_filled", spread)
    photo = np.full((1400, 1400, 3), 7, np.uint8)
    hole = np.zeros((1400, 1400), bool)
    hole[100:1300, 100:1300] = True
    filled = inpainted(Network(small_lama()), photo, hole, lambda: False)
    assert len(seen) == 25
    assert min(seen) > 0.2
    assert (filled == 7).all()


def test_filling_can_be_cancelled():
    asked = []

    def cancelled():
        asked.append(True)
        return len(asked) > 1

    hole = np.zeros((300, 700), bool)
    hole[50:250, 20:680] = True
    with pytest.raises(Cancelled):
        inpainted(Network(small_lama()), np.zeros((300, 700, 3), np.uint8), hole, cancelled)
    assert len(asked) == 2


def test_a_filler_that_gives_something_else_fails():
    photo, hole = np.zeros((50, 50, 3), np.uint8), np.ones((50, 50), bool)
    for data in (small_efficientsam(), small_lama((np.nan, 0, 0))):
        with pytest.raises(ModelFailed):
            inpainted(Network(data), photo, hole, lambda: False)
