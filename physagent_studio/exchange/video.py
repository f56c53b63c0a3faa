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
import numpy as np
from av.codec.codec import Codec, UnknownCodecError
from av.container import OutputContainer
from av.video.reformatter import ColorRange, Colorspace
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
        "crf": "17",
        "preset": "medium",
        "x264-params": "threads=1:mbtree=0",
    },
    "libopenh264": {"b": "8M"},
}
_SOONER = {"libx264": {"preset": "ultrafast"}, "libopenh264": {}}
_BT709 = 1


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


class VideoFile:
    """An MP4 (H.264, yuv420p, faststart) that grows by a picture at a time.

    Pictures are (H, W, 3) uint8 RGB, all of one size. An odd side grows by one repeated row or
    column, since the format wants even ones. The file appears under its name only when it is
    complete, and not at all without a picture. Its comment holds `timing` as JSON
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
        self._container.mux(self._stream.encode(_video_frame(picture)))
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


def _video_frame(picture: Picture) -> av.VideoFrame:
    height, width = picture.shape[:2]
    if height % 2 or width % 2:
        picture = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
    return frame.reformat(
        format="yuv420p",
        dst_colorspace=Colorspace.ITU709,
        dst_color_range=ColorRange.MPEG,
    )
