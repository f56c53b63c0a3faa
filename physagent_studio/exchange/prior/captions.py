"""What physically happens, a sentence for every twenty frames, for generators that take prompts
per segment: read off the rollout, not off the wish."""

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records.rollout import Rollout

CHUNK = 20
"""Frames that share a caption."""
_STILL = 0.05
"""m/s below which a thing stands still to the eye."""
_FREE = 0.5
"""Share of the steps without any contact from which on a thing is in the air."""
_TURNING = 1.0
"""rad/s from which on a thing that moves is seen to turn."""


def captions(rollout: Rollout) -> list[dict[str, object]]:
    """first, last: frames, both included. caption: what things do between them."""
    touched = _touches(rollout)
    began: set[tuple[int, int]] = {pair for step, pair in touched if step <= 1}
    found = []
    for first in range(0, rollout.frames, CHUNK):
        last = min(first + CHUNK, rollout.frames) - 1
        steps = slice(first * rollout.steps_per_frame, (last + 1) * rollout.steps_per_frame)
        now = [pair for step, pair in touched if steps.start <= step < steps.stop]
        fresh = [pair for pair in dict.fromkeys(now) if pair not in began]
        began |= set(fresh)
        said = [_doing(rollout, index, steps, now) for index in range(len(rollout.objects))]
        said += [f"the {_word(rollout, a)} hits the {_word(rollout, b)}" for a, b in fresh]
        text = "; ".join(one for one in said if one)
        text = text or "nothing moves"
        found.append({"first": first, "last": last, "caption": text[0].upper() + text[1:] + "."})
    return found


def _touches(rollout: Rollout) -> list[tuple[int, tuple[int, int]]]:
    """(step, (faster, other)) of every contact, what moves first."""
    found = []
    count = len(rollout.objects)
    speed = np.linalg.norm(rollout.velocities, axis=2)
    for row in np.unique(rollout.contacts[["step", "a", "b"]]):
        step, a, b = int(row["step"]), int(row["a"]), int(row["b"])
        before = max(step - 1, 0)
        fast = [speed[before, one] if one < count else -1.0 for one in (a, b)]
        found.append((step, (a, b) if fast[0] >= fast[1] else (b, a)))
    known: dict[frozenset[int], tuple[int, int]] = {}
    return [(step, known.setdefault(frozenset(pair), pair)) for step, pair in found]


def _doing(rollout: Rollout, index: int, steps: slice, now: list[tuple[int, int]]) -> str:
    """What one thing does; nothing where it stands still."""
    velocity = rollout.velocities[steps, index]
    velocity = velocity[np.isfinite(velocity).all(1)]
    if not len(velocity):
        return ""
    speed, name = np.linalg.norm(velocity, axis=1), _word(rollout, index)
    if speed.mean() < _STILL:
        return ""
    contacts = sum(index in pair for pair in now)
    air = contacts < (1 - _FREE) * len(velocity)
    way = velocity.mean(0)
    if speed[-1] < _STILL:
        return f"the {name} comes to rest"
    if air:
        return f"the {name} {'rises' if way[2] > _STILL else 'falls'}{_across(way)}"
    spin = np.linalg.norm(rollout.angular[steps, index], axis=1)
    verb = "rolls or tumbles" if np.nanmean(spin) > _TURNING else "slides"
    return f"the {name} {verb}{_across(way)}"


def _across(way: NDArray[np.float64]) -> str:
    """Where it goes as the camera sees it, by the larger part."""
    x, y = float(way[0]), float(way[1])
    if max(abs(x), abs(y)) < _STILL:
        return ""
    if abs(x) >= abs(y):
        return " to the right" if x > 0 else " to the left"
    return " away from the camera" if y > 0 else " towards the camera"


def _word(rollout: Rollout, index: int) -> str:
    return rollout.bodies[index].replace("_", " ")
