"""Videos as a browser sees them."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import av
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import video_size, write_video
from physagent_studio.program import Clip
from physagent_studio.program.timing import timing_of


def pictures(count: int, height: int, width: int):
    y, x = np.mgrid[0:height, 0:width]
    for t in range(count):
        yield np.stack([(x * 3 + t * 9) % 256, y * 255 // height, 0 * x + 90], -1).astype(np.uint8)


def boxes(path: Path) -> list[str]:
    """The top-level boxes of an MP4, in order."""
    data, names, at = path.read_bytes(), [], 0
    while at < len(data):
        size, name = struct.unpack(">I4s", data[at : at + 8])
        names.append(name.decode())
        at += size
    return names


def test_plays_in_browsers(tmp_path: Path):
    path = tmp_path / "deep" / "clip.mp4"
    write_video(path, pictures(12, 48, 64), 25)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert float(stream.average_rate or 0) == 25
        assert len(list(container.decode(stream))) == 12
    order = boxes(path)
    assert order.index("moov") < order.index("mdat")
    assert [p.name for p in path.parent.iterdir()] == ["clip.mp4"]


def test_how_the_time_goes_is_in_the_file(tmp_path: Path):
    timing = timing_of(Clip(step_seconds=0.01, steps_per_frame=1))
    assert timing == {"time_factor": 0.25, "simulated_seconds": 0.8, "playback_fps": 25.0}
    write_video(tmp_path / "slow.mp4", pictures(3, 48, 64), 25, timing)
    with av.open(str(tmp_path / "slow.mp4")) as container:
        assert json.loads(container.metadata["comment"]) == timing
    write_video(tmp_path / "plain.mp4", pictures(3, 48, 64), 25)
    with av.open(str(tmp_path / "plain.mp4")) as container:
        assert "comment" not in container.metadata


def test_its_size_is_read_from_its_file(tmp_path: Path):
    write_video(tmp_path / "odd.mp4", pictures(2, 47, 65), 25)
    # The format wants even sides.
    assert video_size(tmp_path / "odd.mp4") == (66, 48)


def test_colours_come_back(tmp_path: Path):
    flat = np.zeros((64, 96, 3), np.uint8)
    flat[:, :32], flat[:, 32:64], flat[:, 64:] = (200, 30, 40), (20, 160, 60), (240, 240, 235)
    write_video(tmp_path / "a.mp4", [flat] * 3, 10)
    with av.open(str(tmp_path / "a.mp4")) as container:
        frame = next(container.decode(video=0))
        assert frame.colorspace == 1
        back = frame.reformat(format="rgb24", src_colorspace="ITU709").to_ndarray()
    for x in (16, 48, 80):
        assert np.abs(back[32, x].astype(int) - flat[32, x]).max() <= 6


def test_odd_sides_grow_by_one(tmp_path: Path):
    write_video(tmp_path / "odd.mp4", pictures(3, 47, 63), 29.97)
    with av.open(str(tmp_path / "odd.mp4")) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height) == (64, 48)
        assert float(stream.average_rate or 0) == pytest.approx(29.97, abs=1e-3)


def test_same_bits_every_time(tmp_path: Path):
    for name in ("a.mp4", "b.mp4"):
        write_video(tmp_path / name, pictures(9, 48, 64), 25)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_nothing_is_left_of_a_broken_video(tmp_path: Path):
    def broken():
        yield from pictures(3, 48, 64)
        raise RuntimeError("the renderer failed")

    path = tmp_path / "clip.mp4"
    path.write_text("the earlier one")
    with pytest.raises(RuntimeError, match="renderer failed"):
        write_video(path, broken(), 25)
    assert [p.name for p in tmp_path.iterdir()] == ["clip.mp4"]
    assert path.read_text() == "the earlier one"


def test_refusals(tmp_path: Path):
    with pytest.raises(InputError, match="no frames"):
        write_video(tmp_path / "a.mp4", [], 25)
    with pytest.raises(InputError, match="no rate"):
        write_video(tmp_path / "a.mp4", pictures(2, 48, 64), float("nan"))
    mixed = [*pictures(2, 48, 64), *pictures(1, 32, 64)]
    with pytest.raises(InputError, match="frame 2 is"):
        write_video(tmp_path / "a.mp4", mixed, 25)
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="cannot be written"):
        write_video(tmp_path / "file" / "a.mp4", pictures(2, 48, 64), 25)
    (tmp_path / "folder.mp4").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        write_video(tmp_path / "folder.mp4", pictures(2, 48, 64), 25)
    assert not list(tmp_path.glob("*.mp4")) or list(tmp_path.glob("*.mp4")) == [
        tmp_path / "folder.mp4"
    ]
