"""What is looked at: playhead, selection and switches. Shared by all browsers, and kept nowhere.

It is no part of the document: nothing here changes a program or a round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from physagent_studio.program import Clip

SHOWN_AT_FIRST = frozenset({"photo", "supports", "trails", "ghosts", "labels", "clean"})
DRAWN_OVER = frozenset({"supports", "labels"})
"""What is drawn over the photo and, with paths and ghosts, not while a clean clip plays."""


@dataclass(frozen=True, slots=True)
class Selection:
    """The selected thing; kind "none" is nothing."""

    kind: str = "none"
    name: str = ""


@dataclass(frozen=True, slots=True)
class View:
    """step: control step on view. once: this playback ends at the end.

    loop_start, loop_end: frames. compare: another round's id. hidden: things
    that are not drawn.
    """

    step: int = 0
    playing: bool = False
    speed: float = 1.0
    loop: bool = True
    once: bool = False
    loop_start: int | None = None
    loop_end: int | None = None
    selection: Selection = Selection()
    shown: frozenset[str] = SHOWN_AT_FIRST
    follow: bool = False
    compare: str | None = None
    hidden: frozenset[str] = frozenset()

    def frame(self, clip: Clip) -> int:
        """The frame on view."""
        return min(self.step // clip.steps_per_frame, clip.frames - 1)

    def at_frame(self, frame: int, clip: Clip) -> View:
        """The same view with the playhead on a frame of the clip."""
        inside = max(0, min(frame, clip.frames - 1))
        return replace(self, step=inside * clip.steps_per_frame)

    def with_shown(self, what: str, on: bool) -> View:
        """The same view with one switch set."""
        return replace(self, shown=self.shown | {what} if on else self.shown - {what})

    @property
    def is_clean(self) -> bool:
        """Whether nothing is to be drawn over the picture: it plays, and `clean` is chosen."""
        return self.playing and "clean" in self.shown

    @property
    def drawn(self) -> frozenset[str]:
        """The switches that count now."""
        return self.shown - DRAWN_OVER if self.is_clean else self.shown

    def range(self, clip: Clip) -> tuple[int, int]:
        """First and last step of what is played."""
        last = clip.steps
        first = (self.loop_start or 0) * clip.steps_per_frame
        end = last if self.loop_end is None else self.loop_end * clip.steps_per_frame
        return (0, last) if not 0 <= first < end else (first, min(end, last))


def advance(view: View, clip: Clip, seconds: float) -> View:
    """The view after `seconds` of the wall clock, playing; at the end it repeats or stops.

    At speed 1 it goes as the clip is shown, slow motion and all.

    Keeps whole steps only; the caller carries the rest of the time over.
    """
    if not view.playing:
        return view
    first, last = view.range(clip)
    step = view.step + round(seconds * view.speed * clip.time_factor / clip.step_seconds)
    if step < last:
        return replace(view, step=max(step, first))
    if view.loop and not view.once:
        return replace(view, step=first + (step - last) % max(last - first, 1))
    return replace(view, step=last, playing=False, once=False)
