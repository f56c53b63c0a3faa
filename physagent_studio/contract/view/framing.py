"""Is it in the picture, for as long as it has something to do there?"""

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.picture import Sight
from physagent_studio.contract.track import Window
from physagent_studio.contract.view.basics import (
    DROPPING,
    INSIDE,
    height_of,
    said,
    sight_in,
    view_check,
)
from physagent_studio.contract.words import number
from physagent_studio.program.scene.state import Floor
from physagent_studio.program.statements import Contacts
from physagent_studio.records.judgement import Check

BEHIND_CAMERA = 0.01
"""Margin of what is out of the picture there, and so beyond no border of it."""
PARTLY = (0.15, 0.85)
"""Least and greatest part of it that is within, of what has left it in part."""
LEAVES = 0.4
"""Part of the clip for which what leaves the picture is at least seen in it."""
BESIDE = 3
"""Frames that show each of two things before they meet, and after."""
STIRRED, STOPPED = 0.25, 0.5
"""What is struck stirs by so much of its own size, or what strikes loses so much of its speed; that
alone does where what strikes is the heavier one, and cannot be stopped by the blow."""


def inside(facts: Facts, name: str) -> Check:
    """At least half of its outline is in the frame, as long as it has something to do there."""
    sight = sight_in(facts, name)
    until = needed_until(facts, name, sight)
    share = sight.share[: until + 1]
    out = np.flatnonzero(share < INSIDE)
    least = float(share.min())
    if not len(out):
        ends = until + 1 < len(sight.share) and (sight.share[until + 1 :] < INSIDE).any()
        how_long = f" up to frame {until}, as it leaves it there" if ends else ""
        text = f"{name} is in the picture{how_long}: at least {number(100 * least, '%')} of it"
        text += ": {answer}"
        margin = (least - INSIDE) / INSIDE
        return view_check("inside", name, text, margin, measured=least, threshold=INSIDE)
    first = int(out[0])
    text = f"{name} is in the picture: {{answer}}, from frame {first} on less than half of it"
    margin = -len(out) / len(sight.share) - 0.1 * min(_distance_out(facts, sight, until), 5.0)
    step = int(facts.rollout.frame_steps()[first])
    return view_check(
        "inside", name, text, margin, measured=least, threshold=INSIDE, step=step
    )  # fmt: skip


def gone(facts: Facts, name: str) -> Check:
    """What the sentence has leave the picture is out of it at the end, all of it.

    A rim that stays at the border is seen for as long as it stays; the margin is how far beyond the
    border it is, or how much of its width is still within, over its own size.
    """
    sight, camera = sight_in(facts, name), facts.program.scene.camera
    assert camera is not None
    low, high = sight.outline[-1].min(axis=0), sight.outline[-1].max(axis=0)
    beyond = float(np.concatenate([low - camera.size, -high]).max())
    size = max(float((high - low).max()), 1.0)
    left = float(sight.share[-1])
    margin = beyond / size if left > 0 or beyond > 0 else BEHIND_CAMERA
    text = f"{name} has left the picture at the end: {{answer}}"
    return view_check("gone", name, text, margin, measured=left, threshold=0.0)


def partly_gone(facts: Facts, name: str) -> Check:
    """What the sentence has leave the picture in part is cut by its border at the end."""
    left = float(sight_in(facts, name).share[-1])
    low, high = PARTLY
    text = (
        f"{name} has left the picture in part at the end: {number(100 * left, '%')} of it is "
        f"within, {number(100 * low)} to {number(100 * high, '%')}: {{answer}}"
    )
    near = min(left - low, high - left)
    return view_check("gone", name, text, near / (high - low), measured=left, threshold=low)


def _distance_out(facts: Facts, sight: Sight, until: int) -> float:
    """How far its middle gets from the frame, in widths of the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    middle, size = sight.centre[: until + 1], np.array(camera.size, float)
    return float(np.maximum(-middle, middle - size).max() / size[0])


def needed_until(facts: Facts, name: str, sight: Sight) -> int:
    """The last frame on which it has to be seen: that before it leaves, where it shall.

    What falls where the floor is not in the picture has been seen once it fell by its own height.
    """
    last = facts.rollout.frames - 1
    out = np.flatnonzero(sight.share < INSIDE)
    if len(out) and name in facts.program.contract.partly:
        return max(int(out[0]) - 1, 0)
    if len(out) and name in facts.program.contract.leaving:
        # Seen to go: on its way out it is seen for a good part of the clip.
        return min(int(out[0]) - 1, last) if out[0] >= LEAVES * last else round(LEAVES * last)
    if not len(out) or not said(facts.program, name, DROPPING):
        return last
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    path = facts.rollout.positions[rows, facts.rollout.objects.index(name)]
    at = int(rows[out[0]])
    lands = facts.touching_anything(name, Window(max(at - 1, 0), at)).any()
    peak = path[: out[0] + 1][::-1]
    # What flies out past a side goes on to fall where nobody looks: it had a floor to fall on.
    if lands or _sees(facts, path[out[0]]) or _sees(facts, peak[int(peak[:, 2].argmax())]):
        return last
    drop = np.maximum.accumulate(path[:, 2]) - path[:, 2]
    seen = np.flatnonzero((drop >= height_of(facts, name)) & (sight.share >= INSIDE))
    if not len(seen):
        return last
    if seen[0] >= out[0]:
        return int(seen[0])
    # What has come down within the picture does not roll out of it.
    landed = Window(int(rows[seen[0]]), at)
    return last if facts.touching_anything(name, landed).any() else int(seen[0])


def breaks_in_sight(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What comes apart is within the picture as it does so, unless the floor below its way is not
    to be seen anywhere."""
    found, first = [], {one.name: one.step for one in reversed(facts.rollout.releases)}
    for name in (n for n in names if n in first):
        frame = facts.rollout.frame_of(first[name])
        share = float(sight_in(facts, name).share[frame])
        path = facts.rollout.positions[: first[name] + 1, facts.rollout.objects.index(name)]
        if share < INSIDE and not any(_sees(facts, place) for place in path):
            continue
        text = (
            f"{name} is in the picture as it comes apart at frame {frame}: "
            f"{number(100 * share, '%')} of it: {{answer}}"
        )
        found.append(
            view_check("breaks", name, text, (share - INSIDE) / INSIDE, measured=share,
                       threshold=INSIDE, step=first[name])
        )  # fmt: skip
    return found


def _sees(facts: Facts, place: FloatArray) -> bool:
    """Whether the floor below a place (3,) is in the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    floors = [s.shape.height for s in facts.program.scene.supports if isinstance(s.shape, Floor)]
    pixel, depth = camera.project(np.array([[place[0], place[1], min(floors, default=0.0)]]))
    inside = (pixel[0] >= 0) & (pixel[0] <= camera.size)
    return bool(inside.all() and depth[0] > 0)


def meetings(facts: Facts) -> list[Check]:
    """Where one thing acts on another, the first is seen before they meet, the other after, and
    that they met is seen on one of them."""
    found, met = [], set()
    for statement in facts.program.contract.statements:
        if not isinstance(statement, Contacts) or statement.negated:
            continue
        one, other = statement.subject, statement.other
        known = facts.rollout.objects
        window = facts.window(statement.from_step, statement.to_step)
        if (one, other) in met or one not in known or other not in known or window is None:
            continue
        touching = np.flatnonzero(facts.touching(one, other, window))
        if not len(touching) or facts.touching(one, other, Window(0, 0)).any():
            continue
        met.add((one, other))
        step = window.first + int(touching[0])
        found += [_seen_to_meet(facts, one, other, step), _seen_to_act(facts, one, other, step)]
    return found


def _seen_to_meet(facts: Facts, one: str, other: str, step: int) -> Check:
    """Enough frames show the one before they meet at a step, and the other after."""
    frame = facts.rollout.frame_of(step)
    before = int((sight_in(facts, one).share[: frame + 1] >= INSIDE).sum())
    after = int((sight_in(facts, other).share[frame + 1 :] >= INSIDE).sum())
    fewest = min(before, after)
    text = (
        f"{one} is seen for {before} frames before it meets {other}, and {other} for "
        f"{after} after: {{answer}}"
    )
    return view_check(
        "meeting", f"{one}.{other}", text, (fewest - BESIDE) / BESIDE,
        measured=fewest, threshold=BESIDE, unit="frames", step=step,
    )  # fmt: skip


def _mass(facts: Facts, name: str) -> float:
    return float(facts.rollout.masses[facts.rollout.objects.index(name)])


def _seen_to_act(facts: Facts, one: str, other: str, step: int) -> Check:
    """The other stirs once they have met at a step, or the one is stopped or turned back by it."""
    frame = facts.rollout.frame_of(step)
    struck, striker = sight_in(facts, other), sight_in(facts, one).centre
    away = np.linalg.norm(struck.marks[frame:] - struck.marks[frame], axis=-1)
    stirred = float(away.max()) / max(float(struck.length[frame]), 1.0)
    back = max(frame - BESIDE, 0)
    came = (striker[frame] - striker[back]) / max(frame - back, 1)
    ahead = min(frame + 2 * BESIDE, len(striker) - 1)
    goes = (striker[ahead] - striker[frame]) / max(ahead - frame, 1)
    kept = float(came @ goes) / max(float(came @ came), 1e-9)
    # What meets a lighter thing is not stopped by it: if it stops, it does so by itself.
    heavier = _mass(facts, one) > _mass(facts, other)
    seen = stirred / STIRRED if heavier else max(stirred / STIRRED, (1 - kept) / STOPPED)
    text = (
        f"{one} is seen to act on {other}, which stirs by {number(100 * stirred, '%')} of its "
        f"size; {one} keeps {number(100 * kept, '%')} of its speed: {{answer}}"
    )
    return view_check(
        "act", f"{one}.{other}", text, seen - 1, measured=stirred, threshold=STIRRED, step=step
    )
