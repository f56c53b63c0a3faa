"""The focal length that a file states is used, where it is one of this picture."""

import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.synthetic import scene
from physagent_studio.exchange import case_from_image
from physagent_studio.program.scene.state import Click, Grounding, SceneObject, SceneState
from physagent_studio.reconstruction import reconstruct, stated_focal

pytestmark = pytest.mark.usefixtures("unfilled")

SIZE = (320, 200)


def _entry(tag, kind, value):
    if kind == 3:
        return struct.pack("<HHIHH", tag, kind, 1, value, 0)
    return struct.pack("<HHII", tag, kind, 1, value)


def _tiff(rows, rationals=()):
    """A little-endian TIFF with an Exif directory. rows: (tag, kind, value); rationals likewise."""
    count = len(rows) + len(rationals)
    sub = 8 + 2 + 12 + 4
    data = sub + 2 + 12 * count + 4
    entries = [(tag, _entry(tag, kind, value)) for tag, kind, value in rows]
    blob = b""
    for tag, over, under in rationals:
        entries.append((tag, struct.pack("<HHII", tag, 5, 1, data + len(blob))))
        blob += struct.pack("<II", over, under)
    body = struct.pack("<H", count) + b"".join(entry for _, entry in sorted(entries)) + b"\0" * 4
    first = struct.pack("<H", 1) + _entry(0x8769, 4, sub) + b"\0" * 4
    return b"II*\0" + struct.pack("<I", 8) + first + body + blob


def _jpeg(path, tiff, image=None):
    image = np.full((SIZE[1], SIZE[0], 3), 128, np.uint8) if image is None else image
    data = cv2.imencode(".jpg", image[..., ::-1])[1].tobytes()
    exif = b"Exif\0\0" + tiff
    segment = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    path.write_bytes(data[:2] + segment + data[2:])
    return path


def test_the_35_mm_equivalent_refers_to_the_diagonal(tmp_path):
    path = _jpeg(tmp_path / "a.jpg", _tiff([(0xA405, 3, 26)]))
    assert stated_focal(path, SIZE) == pytest.approx(26 / 43.267 * np.hypot(*SIZE), rel=1e-3)
    assert stated_focal(path, (200, 320)) == stated_focal(path, SIZE)


def test_focal_length_and_pitch_of_the_sensor(tmp_path):
    rows = [(0xA002, 4, 3200), (0xA003, 4, 2000), (0xA210, 3, 3)]
    tiff = _tiff(rows, [(0x920A, 50, 1), (0xA20E, 3200, 2)])
    # 160 pixels per mm at full size, a tenth of that in this picture: 50 mm are 800 pixels.
    assert stated_focal(_jpeg(tmp_path / "b.jpg", tiff), SIZE) == pytest.approx(800)


@pytest.mark.parametrize(
    "tiff",
    [
        _tiff([(0xA405, 3, 26), (0xA002, 4, 1000), (0xA003, 4, 1000)]),
        _tiff([(0xA405, 3, 0)]),
        _tiff([(0xA405, 3, 60000)]),
        _tiff([], [(0x920A, 50, 0), (0xA20E, 1, 1)]),
        _tiff([(0xA405, 3, 26)])[:20],
        b"II*\0\xff\xff\xff\xff",
        b"nonsense",
    ],
)
def test_a_picture_that_was_cut_or_states_nonsense_states_nothing(tmp_path, tiff):
    assert stated_focal(_jpeg(tmp_path / "c.jpg", tiff), SIZE) is None


def test_png_states_it_too_and_other_files_state_nothing(tmp_path):
    path = tmp_path / "d.png"
    data = cv2.imencode(".png", np.zeros((SIZE[1], SIZE[0], 3), np.uint8))[1].tobytes()
    block = _tiff([(0xA405, 3, 35)])
    chunk = struct.pack(">I", len(block)) + b"eXIf" + block + b"\0\0\0\0"
    path.write_bytes(data[:33] + chunk + data[33:])
    assert stated_focal(path, SIZE) == pytest.approx(35 / 43.267 * np.hypot(*SIZE), rel=1e-3)
    path.write_bytes(data)
    assert stated_focal(path, SIZE) is None
    assert stated_focal(tmp_path / "none.jpg", SIZE) is None


def test_the_scene_has_the_camera_that_the_file_states(tmp_path):
    drawn = scene(2)
    path = _jpeg(tmp_path / "e.jpg", _tiff([(0xA405, 3, 50)]), drawn.image)
    case = case_from_image(path, "It moves.", {"ball": Grounding(points=(Click(x=320, y=200),))})
    assert case.focal == pytest.approx(50 / 43.267 * np.hypot(640, 400), rel=1e-3)
    objects = tuple(SceneObject(name=n, grounding=g) for n, g in case.objects)
    found = reconstruct(case, SceneState(objects=objects))
    assert found.state.camera is not None
    assert found.state.camera.focal == pytest.approx(case.focal)
    other = reconstruct(replace(case, focal=None), SceneState(objects=objects))
    assert other.hash != found.hash
