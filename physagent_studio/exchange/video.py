"""H.264 videos that browsers play."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Self

import av
import cv2
import numpy as np
from av.codec.codec import Codec, UnknownCodecError
from av.container import OutputContainer
from av.video.reformatter import ColorRange
from av.video.stream import VideoStream
from numpy.typing import NDArray

from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange.files import written

Picture = NDArray[np.uint8]

_ENCODERS = ("libx264", "libopenh264")
_OPTIONS = {
    # Its macroblock tree came out differently in 2 of 100 runs, even in one thread; without it
    # 400 of 400 runs gave the same bits.
    "libx264": {
        # As near to the picture as preset medium at 17, in two fifths of its time, a third larger.
        "crf": "16",
        "preset": "veryfast",
        "x264-params": "threads=1:mbtree=0",
    },
    "libopenh264": {"b": "8M"},
}
_SOONER = {"libx264": {"preset": "ultrafast"}, "libopenh264": {}}
_BT709 = 1
_LUMA = np.array([0.2126, 0.7152, 0.0722])
"""Parts of red, green and blue in brightness, BT.709."""
_TO_Y = np.append(_LUMA * 219 / 255, 16.0)
_TO_CHROMA = np.array(
    [
        np.append((np.array([0, 0, 1]) - _LUMA) / 1.8556 * 224 / 255, 128.0),
        np.append((np.array([1, 0, 0]) - _LUMA) / 1.5748 * 224 / 255, 128.0),
    ]
)
"""Rows that make Y, Cb and Cr of RGB and 1, in the range of video (BT.709, 3.2 to 3.4)."""


def encoder_name() -> str:
    """The H.264 encoder that this installation has.

    Raises:
        BackendMissing: PyAV was built without one.
    """
    for name in _ENCODERS:
        try:
            Codec(name, "w")
        except UnknownCodecError:
            continue
        return name
    raise BackendMissing(
        f"this PyAV ({av.__version__}) has no H.264 encoder ({' or '.join(_ENCODERS)}); "
        "install its wheel with `pip install --force-reinstall --only-binary :all: av`"
    )


def write_video(
    path: Path | str,
    frames: Iterable[Picture],
    fps: float,
    timing: Mapping[str, float] | None = None,
) -> None:
    """Write pictures as an MP4; see `VideoFile`.

    Raises:
        InputError: no frames, frames of different sizes, a bad rate, an unwritable path.
        BackendMissing: there is no H.264 encoder.
    """
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise InputError(f"there are no frames, so {Path(path).name} was not written")
    with VideoFile(path, fps, timing) as video:
        video.add(first)
        for picture in pictures:
            video.add(picture)


def video_size(path: Path | str) -> tuple[int, int]:
    """Width and height of a video's pictures."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        return stream.width, stream.height


class VideoFile:
    """An MP4 (H.264, yuv420p, faststart) that grows by a picture at a time.

    Pictures are (H, W, 3) uint8 RGB, or (H, W) grey, all of one size. An odd side grows by one
    repeated row or column, since the format wants even ones. The file appears under its name only
    when it is complete, and not at all without a picture. Its comment holds `timing` as JSON
    (`program.timing.timing_of`).
    """

    def __init__(
        self,
        path: Path | str,
        fps: float,
        timing: Mapping[str, float] | None = None,
        *,
        fast: bool = False,
    ) -> None:
        """fast: what is for the eye beside the clip may be larger and is written sooner.

        Raises InputError for a bad rate, BackendMissing without an encoder.
        """
        if not 0 < fps <= 1000:
            raise InputError(f"{fps} frames a second is no rate for a video (0 … 1000)")
        self._path, self._name = Path(path), encoder_name()
        self._rate = Fraction(fps).limit_denominator(100_000)
        self._timing, self._fast = timing, fast
        self._open = ExitStack()
        self._container: OutputContainer | None = None
        self._stream: VideoStream | None = None
        self._shape: tuple[int, ...] = ()
        self._planes: _Planes | None = None
        self._count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None and self._container is not None and self._stream is not None:
            self._container.mux(self._stream.encode(None))
        # What is not complete goes again.
        self._open.__exit__(kind, error, trace)

    def add(self, picture: Picture) -> None:
        """The next picture. Raises InputError where it has another size than the first."""
        if self._container is None:
            self._begin(picture)
        if picture.shape != self._shape:
            raise InputError(f"frame {self._count} is {picture.shape}, the first {self._shape}")
        assert self._container is not None
        assert self._stream is not None
        assert self._planes is not None
        self._container.mux(self._stream.encode(self._planes.frame(picture)))
        self._count += 1

    def _begin(self, first: Picture) -> None:
        partial = self._open.enter_context(written(self._path))
        container = self._open.enter_context(
            av.open(str(partial), "w", format="mp4", options={"movflags": "+faststart"})
        )
        if self._timing is not None:
            container.metadata["comment"] = json.dumps(dict(self._timing))
        stream = container.add_stream(self._name, self._rate)
        assert isinstance(stream, VideoStream)
        _set_up(stream, first, self._name, self._fast)
        self._container, self._stream, self._shape = container, stream, first.shape
        self._planes = _Planes(stream.width, stream.height)


def _set_up(stream: VideoStream, first: Picture, name: str, fast: bool) -> None:
    height, width = first.shape[:2]
    stream.width, stream.height = width + width % 2, height + height % 2
    stream.pix_fmt = "yuv420p"
    # Said in the file, or players guess the matrix from the size and shift the colours.
    context = stream.codec_context
    context.options = dict(_OPTIONS[name]) | (_SOONER[name] if fast else {})
    context.thread_count = 1
    context.color_range = ColorRange.MPEG
    context.colorspace = context.color_primaries = context.color_trc = _BT709


class _Planes:
    """A picture as yuv420p, of which only the rows that have changed are made anew."""

    def __init__(self, width: int, height: int) -> None:
        self._size = (width, height)
        self._last: Picture | None = None
        # Y over a quarter as many of U and then of V; 128 is no colour.
        self._planes = np.full((height * 3 // 2, width), 128, np.uint8)

    def frame(self, picture: Picture) -> av.VideoFrame:
        """picture: (H, W, 3) RGB or (H, W) grey."""
        width, height = self._size
        rows = _changed(picture, self._last)
        self._last = picture.copy()
        if rows.start < rows.stop:
            part = picture[rows]
            if part.shape[0] % 2 or part.shape[1] % 2:
                more = ((0, part.shape[0] % 2), (0, part.shape[1] % 2), (0, 0))
                part = np.pad(part, more[: part.ndim], mode="edge")
            self._convert(part, rows.start)
        frame = av.VideoFrame.from_ndarray(self._planes, format="yuv420p")
        assert (frame.width, frame.height) == (width, height)
        return frame

    def _convert(self, part: Picture, top: int) -> None:
        width, height = self._size
        below = top + len(part)
        if part.ndim == 2:
            self._planes[top:below] = part * np.float32(219 / 255) + np.float32(16.5)
            return
        self._planes[top:below] = cv2.transform(part, _TO_Y[None])
        small = cv2.resize(part, (width // 2, len(part) // 2), interpolation=cv2.INTER_AREA)
        chroma = self._planes[height:].reshape(2, height // 2, width // 2)
        for plane, row in zip(chroma, _TO_CHROMA, strict=True):
            plane[top // 2 : below // 2] = cv2.transform(small, row[None])


def _changed(picture: Picture, last: Picture | None) -> slice:
    """The rows, from an even one on, in which pictures differ."""
    if last is None:
        return slice(0, len(picture))
    rows = np.flatnonzero((picture != last).reshape(len(picture), -1).any(1))
    if not len(rows):
        return slice(0, 0)
    return slice(int(rows[0]) // 2 * 2, min(int(rows[-1]) // 2 * 2 + 2, len(picture)))
