"""What a viewer must be able to see: checks of kind `view`, always on.

They speak of the picture, from outlines through the camera (`picture`): is it in the frame, slow
enough to be followed, long enough to be seen, as the photograph at the start and as told at the
end? What needs drawn silhouettes comes as `Drawn`. No check where there is no camera or no run.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.outcome import bounded
from physagent_studio.contract.picture import Sight, sight_of
from physagent_studio.contract.track import Window
from physagent_studio.contract.words import number
from physagent_studio.program.actions import FixObject
from physagent_studio.program.contract import Contacts, Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene import Floor
from physagent_studio.program.timing import SLOWEST
from physagent_studio.records.judgement import Check
from physagent_studio.records.rollout import Rollout

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

INSIDE = 0.5
"""Least part of a subject's outline that is in the frame."""
STEP, FALLING_STEP = 0.04, 0.08
"""Farthest step from frame to frame, parts of the width; in the frames of a blow or a fall."""
NOTICED = 0.0006
"""Least step from frame to frame that is seen as motion, parts of the width: half a pixel."""
FALL_FILLS = 0.2
"""The same of a fall in the slowest motion there is."""
FILLS, RESTS_BY = 0.45, 0.9
"""Least part of the clip that the motion fills, and by when what comes to rest does so."""
BESIDE = 3
"""Frames that show each of two things before they meet, and after."""
COVERS, JUMP = 0.93, 1.0
"""Least overlap of the drawn solid with its mask, and farthest jump as it takes over, pixels."""
SETTLED = 0.1
"""Part of the clip at its end for which what stops is at rest."""
TOUCHING = 2.0
"""Widest gap between what is drawn to stand on something and that, pixels."""
OFF_AXIS, TIPPED = 20.0, 45.0
"""Degrees that what rolls on wheels may go off its axis, and tilt (a ramp tilts it as well)."""
LEAST_SHIFT = 0.012
"""Least way in the picture that is noticed, parts of its diagonal."""
STILL = frozenset(("stays", "upright", "rests_on"))
MOVING = frozenset(("moves", "falls", "topples", "leaves", "rotates", "flips", "sways", "breaks"))
STOPPING = frozenset(("stops", "stops_before", "covers", "rests_on"))
DROPPING = frozenset(("falls", "leaves", "descends_slowly", "lands_in"))
TIMED = frozenset(
    ("contacts", "falls", "moves", "passes_over", "flips", "rotates", "path_bends", "reverses")
)


@dataclass(frozen=True, slots=True)
class Drawn:
    """How an object is drawn at its first pose: overlap with its mask (IoU), how far its middle
    lies from the mask's, pixels, and the gap below it to what it stands on, pixels."""

    overlap: float
    jump: float
    gap: float | None = None


def view_checks(
    facts: Facts, checks: tuple[Check, ...], drawn: Mapping[str, Drawn] | None = None
) -> tuple[Check, ...]:
    """All view checks of a run; `checks` are those of its contract."""
    program = facts.program
    names = tuple(n for n in facts.rollout.objects if n in acting_objects(program))
    if program.scene.camera is None or not facts.complete:
        return ()
    found = [*_begins(facts, drawn or {})]
    if not names:
        return tuple(found)
    found.append(_in_time(facts, checks))
    found += [_inside(facts, name) for name in names]
    found += _paces(facts, names)
    if not nothing_happens(program):
        found += [_something(facts, names), _fills(facts, names)]
    found += [*_meetings(facts), *_ends(facts, names), *_amounts(facts), *_on_wheels(facts, names)]
    return tuple(found)


def view_check(
    rule: str, subject: str, text: str, margin: float, *, measured: float | None = None,
    threshold: float | None = None, unit: str = "", step: int | None = None,
) -> Check:  # fmt: skip
    """A check of kind `view`; `{answer}` in its text becomes yes or no."""
    ok = margin >= 0
    return Check(
        id=f"view.{rule}.{subject}"[:64] if subject else f"view.{rule}",
        text=text.format(answer="yes" if ok else "no"),
        ok=ok,
        measured=measured,
        threshold=threshold,
        unit=unit,
        margin=bounded(margin),
        step=step,
        kind="view",
        always_on=True,
    )


def subject_of(check: Check, rollout: Rollout) -> str:
    """The object that a view check is about; "" where it is about the whole."""
    told = check.id.split(".", 2)[2] if check.id.count(".") > 1 else ""
    return max((n for n in rollout.objects if told.startswith(n)), key=len, default="")


# --- who it is about -------------------------------------------------------------------------


def acting_objects(program: PhysicalProgram) -> frozenset[str]:
    """Objects that the contract or the schedule says something happens to."""
    named = {
        str(getattr(s, "subject", ""))
        for s in program.contract.statements
        if s.kind not in STILL and not s.negated
    }
    moved = {a.name for a in program.event.actions if not isinstance(a, FixObject)}
    return frozenset(named | moved)


def nothing_happens(program: PhysicalProgram) -> bool:
    """Whether all that is demanded is that things stay as they are."""
    statements = program.contract.statements
    return bool(statements) and all(
        s.kind in STILL or (s.negated and s.kind in MOVING) for s in statements
    )


def _said(program: PhysicalProgram, name: str, kinds: Iterable[str]) -> list[Statement]:
    """What the contract says of an object, of these kinds and not denied."""
    return [
        s
        for s in program.contract.statements
        if s.kind in kinds and not s.negated and getattr(s, "subject", "") == name
    ]


def _sight(facts: Facts, name: str) -> Sight:
    found = sight_of(facts, name)
    assert found is not None, "there is a camera"
    return found


# --- in the picture --------------------------------------------------------------------------


def _inside(facts: Facts, name: str) -> Check:
    """At least half of its outline is in the frame, as long as it has something to do there."""
    sight = _sight(facts, name)
    until = _needed(facts, name, sight)
    share = sight.share[: until + 1]
    out = np.flatnonzero(share < INSIDE)
    least = float(share.min())
    if not len(out):
        text = f"{name} is in the picture: at least {number(100 * least, '%')} of it: {{answer}}"
        margin = (least - INSIDE) / INSIDE
        return view_check("inside", name, text, margin, measured=least, threshold=INSIDE)
    first = int(out[0])
    text = f"{name} is in the picture: {{answer}}, from frame {first} on less than half of it"
    margin = -len(out) / len(sight.share) - 0.1 * min(_distance_out(facts, sight, until), 5.0)
    step = int(facts.rollout.frame_steps()[first])
    return view_check(
        "inside", name, text, margin, measured=least, threshold=INSIDE, step=step
    )  # fmt: skip


def _distance_out(facts: Facts, sight: Sight, until: int) -> float:
    """How far its middle gets from the frame, in widths of the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    middle, size = sight.centre[: until + 1], np.array(camera.size, float)
    return float(np.maximum(-middle, middle - size).max() / size[0])


def _needed(facts: Facts, name: str, sight: Sight) -> int:
    """The last frame on which it has to be seen.

    What falls where the floor is not in the picture has been seen once it fell by its own height.
    """
    last = facts.rollout.frames - 1
    out = np.flatnonzero(sight.share < INSIDE)
    if not len(out) or not _said(facts.program, name, DROPPING):
        return last
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    path = facts.rollout.positions[rows, facts.rollout.objects.index(name)]
    if _sees(facts, path[out[0]]):
        return last
    drop = np.maximum.accumulate(path[:, 2]) - path[:, 2]
    seen = np.flatnonzero((drop >= _height(facts, name)) & (sight.share >= INSIDE))
    return int(seen[0]) if len(seen) else last


def _sees(facts: Facts, place: FloatArray) -> bool:
    """Whether the floor below a place (3,) is in the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    floors = [s.shape.height for s in facts.program.scene.supports if isinstance(s.shape, Floor)]
    pixel, depth = camera.project(np.array([[place[0], place[1], min(floors, default=0.0)]]))
    inside = (pixel[0] >= 0) & (pixel[0] <= camera.size)
    return bool(inside.all() and depth[0] > 0)


def _height(facts: Facts, name: str) -> float:
    placed = facts.track(name, Window(0, 0)).placed
    up = np.array([[0.0, 0.0, 1.0]])
    return float((placed.support(up) - placed.support(-up))[0, 2])


# --- readable --------------------------------------------------------------------------------


def _paces(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """Nothing moves farther from one frame to the next than an eye follows."""
    found = []
    for name in facts.rollout.objects:
        steps = _sight(facts, name).steps
        allowed = np.where(_sudden(facts, name), FALLING_STEP, STEP)
        ratio = steps / allowed
        worst = int(ratio.argmax())
        if name not in names and ratio[worst] <= 1:
            continue
        limit = float(allowed[worst])
        figures = f"{100 * steps[worst]:.1f} % of the width per frame ≤ {100 * limit:.0f} %"
        found.append(
            view_check(
                "pace",
                name,
                f"{name} moves so that an eye can follow: {figures}: {{answer}}",
                1.0 - float(ratio[worst]),
                measured=float(steps[worst]),
                threshold=limit,
                unit="width",
                step=int(facts.rollout.frame_steps()[worst]),
            )
        )
    return found


def _sudden(facts: Facts, name: str) -> BoolArray:
    """(F − 1,) the frames in which it falls or flies freely, or something strikes it."""
    whole = facts.whole()
    free = ~facts.touching_anything(name, whole)
    struck = np.zeros(len(whole), bool)
    for other in facts.rollout.objects:
        if other != name:
            touching = facts.touching(name, other, whole)
            struck |= touching & ~np.concatenate([[True], touching[:-1]])
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    falls = np.array([free[a : b + 1].mean() > 0.5 for a, b in itertools.pairwise(rows)])
    blows = np.array([struck[a : b + 1].any() for a, b in itertools.pairwise(rows)])
    # A blow is seen on its own frame and on the next.
    return falls | blows | np.concatenate([[False], blows[:-1]])


def moving_frames(facts: Facts, names: tuple[str, ...]) -> BoolArray:
    """(F − 1,) between which frames any of the things is seen to move in the picture."""
    moving = np.zeros(facts.rollout.frames - 1, bool)
    for name in names:
        sight = _sight(facts, name)
        moving |= (sight.steps >= NOTICED) & (sight.share[1:] >= INSIDE)
    return moving


@dataclass(frozen=True, slots=True)
class Pacing:
    """When a viewer sees something, in frames. moving: how many of the clip's intervals show a
    motion; first, last: the first and the last of them, None where nothing moves; crossings: for
    each acting thing that gets out of the picture the frame from which less than half of it is
    seen; fastest: the farthest step, parts of the width; time_factor: of the clip."""

    moving: int
    first: int | None
    last: int | None
    crossings: tuple[tuple[str, int], ...]
    fastest: float
    time_factor: float


def pacing_of(facts: Facts) -> Pacing | None:
    """The pace of a run as a viewer sees it; None where there is no camera."""
    program = facts.program
    if program.scene.camera is None:
        return None
    acting = acting_objects(program)
    names = tuple(n for n in facts.rollout.objects if n in acting)
    moving = np.flatnonzero(moving_frames(facts, names))
    crossings = []
    for name in names:
        out = np.flatnonzero(_sight(facts, name).share < INSIDE)
        if len(out):
            crossings.append((name, int(out[0])))
    return Pacing(
        moving=len(moving),
        first=int(moving[0]) if len(moving) else None,
        last=int(moving[-1]) + 1 if len(moving) else None,
        crossings=tuple(crossings),
        fastest=max(
            (float(_sight(facts, n).steps.max()) for n in facts.rollout.objects), default=0.0
        ),
        time_factor=program.clip.time_factor,
    )


def _fills(facts: Facts, names: tuple[str, ...]) -> Check:
    """The motion that the sentence is about fills a good part of the clip."""
    moving = moving_frames(facts, names)
    share = float(moving.mean())
    least = _least_fill(facts, names)
    if share < least:
        text = f"the motion fills {100 * share:.0f} % of the clip ≥ {100 * least:.0f} %: {{answer}}"
        margin = (share - least) / least
        return view_check("fills", "", text, margin, measured=share, threshold=least)
    rests = [n for n in names if _said(facts.program, n, STOPPING)]
    ends = (int(np.flatnonzero(moving)[-1]) + 1) / len(moving)
    if rests and len(rests) == len(names) and ends > RESTS_BY:
        text = f"the motion is over by {100 * ends:.0f} % of the clip ≤ {100 * RESTS_BY:.0f} %"
        margin = (RESTS_BY - ends) / RESTS_BY
        return view_check(
            "fills", "", text + ": {answer}", margin, measured=ends, threshold=RESTS_BY
        )  # fmt: skip
    text = f"the motion fills {100 * share:.0f} % of the clip: {{answer}}"
    return view_check("fills", "", text, (share - least) / least, measured=share, threshold=least)


def _least_fill(facts: Facts, names: tuple[str, ...]) -> float:
    """Less in the slowest motion there is, where things fall: a fall lasts as long as it does."""
    slowest = facts.program.clip.time_factor <= SLOWEST + 1e-6
    falls = any(_said(facts.program, name, DROPPING) for name in names)
    return FALL_FILLS if slowest and falls else FILLS


def _meetings(facts: Facts) -> list[Check]:
    """Where one thing acts on another, the first is seen before they meet, the other after."""
    found, met = [], set()
    for statement in facts.program.contract.statements:
        if not isinstance(statement, Contacts) or statement.negated:
            continue
        one, other = statement.subject, statement.other
        if (one, other) in met:
            continue
        known = facts.rollout.objects
        window = facts.window(statement.from_step, statement.to_step)
        if one not in known or other not in known or window is None:
            continue
        touching = np.flatnonzero(facts.touching(one, other, window))
        if not len(touching) or facts.touching(one, other, Window(0, 0)).any():
            continue
        met.add((one, other))
        frame = facts.rollout.frame_of(window.first + int(touching[0]))
        before = int((_sight(facts, one).share[: frame + 1] >= INSIDE).sum())
        after = int((_sight(facts, other).share[frame + 1 :] >= INSIDE).sum())
        fewest = min(before, after)
        text = (
            f"{one} is seen for {before} frames before it meets {other}, and {other} for "
            f"{after} after: {{answer}}"
        )
        found.append(
            view_check(
                "meeting", f"{one}.{other}", text, (fewest - BESIDE) / BESIDE,
                measured=fewest, threshold=BESIDE, unit="frames",
                step=window.first + int(touching[0]),
            )
        )  # fmt: skip
    return found


def _something(facts: Facts, names: tuple[str, ...]) -> Check:
    """Some acting object visibly moves, turns or changes its shape inside the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    least = LEAST_SHIFT * float(np.hypot(*camera.size))
    best = 0.0
    for name in names:
        sight = _sight(facts, name)
        seen = sight.share > 0.25
        if seen.any():
            marks = sight.marks[seen]
            best = max(best, float(np.linalg.norm(marks - marks[0], axis=-1).max()))
    text = f"something visible happens: {best:.0f} px ≥ {least:.0f} px: {{answer}}"
    return view_check(
        "something",
        "",
        text,
        min(best / least - 1, 10.0),
        measured=best,
        threshold=least,
        unit="px",
    )


def _in_time(facts: Facts, checks: tuple[Check, ...]) -> Check:
    """Nothing decisive happens only in the last two frames."""
    rollout = facts.rollout
    last = rollout.steps - 2 * rollout.steps_per_frame
    negated = {s.id for s in facts.program.contract.statements if s.negated}
    steps = [
        c.step
        for c in checks
        if c.ok and c.demanded and c.kind in TIMED and c.id not in negated and c.step is not None
    ]
    latest = max(steps, default=0)
    frame = rollout.frame_of(latest)
    text = (
        f"the event is over before the last frames: {{answer}}, frame {frame} of {rollout.frames}"
    )
    return view_check(
        "in_time", "", text, (last - latest) / max(rollout.steps, 1), measured=float(frame),
        threshold=float(rollout.frame_of(last)), unit="frame", step=latest,
    )  # fmt: skip


# --- begins and ends -------------------------------------------------------------------------


def _begins(facts: Facts, drawn: Mapping[str, Drawn]) -> list[Check]:
    """The drawn things cover their masks, and nothing stirs before it has a reason to."""
    found = []
    for name, one in drawn.items():
        text = f"{name} is drawn as the photograph shows it: overlap {one.overlap:.2f}: {{answer}}"
        found.append(
            view_check(
                "begins", name, text, (one.overlap - COVERS) / COVERS,
                measured=one.overlap, threshold=COVERS, step=0,
            )
        )  # fmt: skip
    worst, who = 0.0, ""
    for name in facts.rollout.objects:
        if _may_stir(facts, name):
            continue
        marks = _sight(facts, name).marks[:3]
        shift = float(np.linalg.norm(marks - marks[0], axis=-1).max())
        worst, who = max((worst, who), (shift, name))
    text = "nothing stirs before its time: {answer}"
    if worst > JUMP:
        text += f", {who} moves by {worst:.1f} px in the first two frames"
    found.append(
        view_check(
            "calm", "", text, (JUMP - worst) / JUMP, measured=worst, threshold=JUMP, unit="px",
            step=0,
        )
    )  # fmt: skip
    return found


def _may_stir(facts: Facts, name: str) -> bool:
    """Whether an action, a fall that is told, or another thing that moves explains a motion."""
    first = Window(0, min(2 * facts.rollout.steps_per_frame, facts.last))
    if facts.acted_on(name)[first.rows].any() or _said(facts.program, name, DROPPING | {"deforms"}):
        return True
    if not facts.touching_anything(name, first).any():
        return True
    others = (o for o in facts.rollout.objects if o != name and facts.acted_on(o)[first.rows].any())
    return any(facts.touching(name, other, first).any() for other in others)


def _ends(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What stops is at rest for the last tenth; what shall go on moving still moves."""
    found = []
    last = max(round(SETTLED * facts.rollout.frames), 2)
    for name in names:
        steps = _sight(facts, name).steps[-last:]
        if _said(facts.program, name, STOPPING):
            most = float(steps.max())
            text = f"{name} is at rest at the end: {{answer}}"
            margin = (2 * NOTICED - most) / (2 * NOTICED)
            found.append(
                view_check("ends", name, text, max(margin, -3.0), measured=most,
                           threshold=2 * NOTICED, unit="width")
            )  # fmt: skip
        elif _said(facts.program, name, ("sways",)):
            most = float(steps.max())
            text = f"{name} still moves at the end: {{answer}}"
            found.append(
                view_check("ends", name, text, (most - NOTICED) / NOTICED, measured=most,
                           threshold=NOTICED, unit="width")
            )  # fmt: skip
    return found


# --- as much as told -------------------------------------------------------------------------


def _amounts(facts: Facts) -> list[Check]:
    """What something sets going is as fast as the verb and its size allow, while it stands on
    something: a fall is as fast as it is."""
    found = []
    for pace in facts.program.contract.paces:
        if not facts.is_object(pace.subject):
            continue
        # Level, since what lands is still as fast as it fell on the step that it touches down.
        level = facts.track(pace.subject, facts.whole()).velocities[:, :2]
        carried = facts.touching_anything(pace.subject, facts.whole())
        speed = np.where(carried, np.linalg.norm(level, axis=1), 0.0)
        most = float(speed.max())
        text = (
            f"{pace.subject} goes at most as fast as “{pace.verb}” says: "
            f"{number(most, 'm/s')} ≤ {number(pace.high, 'm/s')}: {{answer}}"
        )
        found.append(
            view_check(
                "amount", pace.subject, text, (pace.high - most) / max(pace.high, 1e-3),
                measured=most, threshold=pace.high, unit="m/s",
                step=int(speed.argmax()),
            )
        )  # fmt: skip
    return found


def _on_wheels(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What rolls on wheels goes along its axis, front first, and stays upright."""
    found = []
    for name in names:
        item = facts.program.scene.object(name)
        wheels = None if item is None else item.wheels
        if wheels is None or (wheels.grip is not None and wheels.grip <= wheels.rolling):
            continue
        track = facts.track(name, facts.whole())
        if _said(facts.program, name, ("topples", "flips", "rotates", "reverses")):
            continue
        turned = track.placed.matrices @ track.placed.matrices[0].T
        angle = np.radians(wheels.heading)
        front = turned @ np.array([np.cos(angle), np.sin(angle), 0.0])
        moves = track.speed > max(0.05, 0.1 * float(track.speed.max()))
        if not moves.any():
            continue
        along = np.abs(np.einsum("ti,ti->t", front, track.velocities)) / np.maximum(
            np.linalg.norm(front, axis=1) * track.speed, 1e-9
        )
        off = np.degrees(np.arccos(np.clip(along, 0, 1)))
        worst = float(np.quantile(off[moves], 0.9))
        tilt = float(track.tilt()[moves].max())
        text = (
            f"{name} rolls along its own axis: {number(worst, '°')} off ≤ {OFF_AXIS:.0f}°, "
            f"tilted by {number(tilt, '°')}: {{answer}}"
        )
        margin = min(1 - worst / OFF_AXIS, 1 - tilt / TIPPED)
        found.append(
            view_check("wheels", name, text, margin, measured=worst, threshold=OFF_AXIS, unit="°")
        )
    return found
