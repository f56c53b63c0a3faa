"""Rows of things that stand within reach of one another and fall one after another."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import EventFrame, Reading

_OVER = ("topple", "fall")


def as_waves(reading: Reading, layout: Layout) -> Reading:
    """ "The dominoes fall one after another": the first of a row brings down the next, where each
    stands within reach of it; the reading with that said."""
    frames: list[EventFrame] = []
    for frame in reading.frames:
        row = _row(frame, layout)
        if row and any(row[-1] in f.patient and row[0] not in f.patient for f in frames):
            # The one that is struck, or told of before, is the one that falls first.
            row = row[::-1]
        if not row:
            frames.append(frame)
            continue
        frames.append(replace(frame, sense="topple", patient=row[:1], timing=""))
        frames.append(replace(frame, sense="topple", patient=row[1:], agent=row[:1]))
    return replace(reading, frames=tuple(frames))


def _row(frame: EventFrame, layout: Layout) -> tuple[str, ...]:
    """The things of a frame as they stand in a row, from the left or the front; () for none."""
    told = frame.timing == "in_turn" and frame.sense in _OVER and len(frame.patient) > 2
    free = not (frame.agent or frame.negated or frame.places or frame.counted)
    known = all(layout.has(name) and layout.carrier(name) for name in frame.patient)
    if not told or not free or not known or any(layout.rolls(name) for name in frame.patient):
        return ()
    spots = {name: layout.position(name) for name in frame.patient}
    across, away = (np.ptp([spot[k] for spot in spots.values()]) for k in (0, 1))
    axis = int(away > across)
    row = tuple(sorted(spots, key=lambda name: float(spots[name][axis])))
    near = (layout.gap(one, after) < layout.height(one) for one, after in pairwise(row))
    return row if all(near) else ()
