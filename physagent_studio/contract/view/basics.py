"""What all view checks share: whom they are about, how one is made; and how fast was told."""

from collections.abc import Iterable

import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.motion import airborne
from physagent_studio.contract.picture import Sight, sight_of
from physagent_studio.contract.track import Window, bounded
from physagent_studio.contract.words import number
from physagent_studio.program.actions import FixObject
from physagent_studio.program.contract import Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.statements import Airborne
from physagent_studio.records.judgement import Check
from physagent_studio.records.rollout import Rollout

INSIDE = 0.5
"""Least part of a subject's outline that is in the frame."""
NOTICED = 0.0006
"""Least step from frame to frame that is seen as motion, parts of the width: half a pixel."""
STILL = frozenset(("stays", "upright", "rests_on"))
MOVING = frozenset(("moves", "falls", "topples", "leaves", "rotates", "flips", "sways", "breaks"))
STOPPING = frozenset(("stops", "stops_before", "covers", "rests_on"))
DROPPING = frozenset(("falls", "leaves", "descends_slowly", "lands_in"))
TIMED = frozenset(
    ("contacts", "falls", "moves", "passes_over", "flips", "rotates", "path_bends", "reverses")
)


VIEW_CODES = {
    "inside": "framing", "pace": "pace", "fills": "pace", "meeting": "pace", "in_time": "pace",
    "ends": "not_stopped", "something": "not_visible", "calm": "stirs", "wheels": "heading",
    "amount": "pace", "place": "pace", "tossed": "pace", "gone": "falls_short",
    "act": "falls_short", "breaks": "framing", "apart": "not_broken",
    "alone": "overshoots", "footing": "toppled", "lean": "misses",
}  # fmt: skip
"""Code of a failed view check, by its rule: the second word of its id."""


def view_code(check: Check) -> str:
    """The stable word that planners know a failed view check by."""
    return VIEW_CODES.get(check.id.split(".")[1], "unlike_the_photo")


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


def said(program: PhysicalProgram, name: str, kinds: Iterable[str]) -> list[Statement]:
    """What the contract says of an object, of these kinds and not denied."""
    return [
        s
        for s in program.contract.statements
        if s.kind in kinds and not s.negated and getattr(s, "subject", "") == name
    ]


def sight_in(facts: Facts, name: str) -> Sight:
    """One object in the picture of a scene that has a camera."""
    found = sight_of(facts, name)
    assert found is not None, "there is a camera"
    return found


REACH = 1.5
"""Farthest that the middle of what only tips over goes, over how high it reached above where it
comes down: lying down takes it half its height and half its width, and what is round rolls on a
little."""
_IN_PLACE = frozenset(("topples", "upright", "moves", "rests_on", "stays", "stops"))


OFF_GROUND = 0.15
"""Longest time that what only tips over is off what it stands on, s: tossed it looks flung."""


def in_place(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What tips over, and does no more and is struck by nothing, comes down where it stood, and
    is not tossed."""
    found = []
    for name in names:
        own = [s for s in facts.program.contract.statements if name in _named(s) and not s.negated]
        told = {s.kind for s in own if not _meets_the_ground(s, facts)}
        if "topples" not in told or not told <= _IN_PLACE:
            continue
        above = _over_its_end(facts, name)
        reach = REACH * above
        places = facts.track(name, facts.whole()).positions[:, :2]
        far = float(np.linalg.norm(places - places[0], axis=1).max())
        text = (
            f"{name} comes down where it stood: "
            f"{number(far, 'm')} ≤ {number(reach, 'm')}: {{answer}}"
        )
        found.append(
            view_check("place", name, text, (reach - far) / reach, measured=far, threshold=reach,
                       unit="m")
        )  # fmt: skip
        if above < 1.1 * height_of(facts, name):
            found.append(_not_tossed(facts, name))
    return found


def _meets_the_ground(statement: Statement, facts: Facts) -> bool:
    other = getattr(statement, "other", "")
    return statement.kind == "contacts" and facts.program.scene.support(other) is not None


def _not_tossed(facts: Facts, name: str) -> Check:
    """It keeps touching something as it tips over from level ground."""
    off = Airborne(id="tossed", subject=name, seconds=OFF_GROUND)
    longest = airborne(off, facts, facts.whole()).value or 0.0
    text = (
        f"{name} is off the ground for at most {number(OFF_GROUND, 's')} as it tips over: "
        f"{number(longest, 's')}: {{answer}}"
    )
    return view_check("tossed", name, text, (OFF_GROUND - longest) / OFF_GROUND,
                      measured=longest, threshold=OFF_GROUND, unit="s")  # fmt: skip


def _named(statement: Statement) -> tuple[str, ...]:
    return tuple(str(getattr(statement, field, "")) for field in ("subject", "other"))


def _over_its_end(facts: Facts, name: str) -> float:
    """How high its top is at first above its lowest point at the end, m: its own height, and for
    what stood on others theirs as well."""
    up = np.array([[0.0, 0.0, 1.0]])
    first = facts.track(name, Window(0, 0)).placed
    last = facts.track(name, Window(facts.last, facts.last)).placed
    above = float(first.support(up)[0, 2] - last.support(-up)[0, 2])
    return max(above, height_of(facts, name))


def height_of(facts: Facts, name: str) -> float:
    """How high an object is at first, m."""
    placed = facts.track(name, Window(0, 0)).placed
    up = np.array([[0.0, 0.0, 1.0]])
    return float((placed.support(up) - placed.support(-up))[0, 2])


OFF_AXIS, TIPPED = 20.0, 45.0
"""Degrees that what rolls on wheels may go off its axis, and tilt (a ramp tilts it as well)."""


def amounts(facts: Facts) -> list[Check]:
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


def _met_something(facts: Facts, name: str) -> BoolArray:
    """(S + 1,) the steps from which on it has touched another object."""
    touched = np.zeros(len(facts.whole()), bool)
    for other in facts.rollout.objects:
        if other != name:
            touched |= facts.touching(name, other, facts.whole())
    return np.logical_or.accumulate(touched)


def on_wheels(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What rolls on wheels goes along its axis, front first, and stays upright."""
    found = []
    for name in names:
        item = facts.program.scene.object(name)
        wheels = None if item is None else item.wheels
        if wheels is None or (wheels.grip is not None and wheels.grip <= wheels.rolling):
            continue
        track = facts.track(name, facts.whole())
        if said(facts.program, name, ("topples", "flips", "rotates", "reverses")):
            continue
        turned = track.placed.matrices @ track.placed.matrices[0].T
        angle = np.radians(wheels.heading)
        # Seen from above: the heading says nothing of the slope on which it may begin.
        front = (turned @ np.array([np.cos(angle), np.sin(angle), 0.0]))[:, :2]
        goes = track.velocities[:, :2]
        speed = np.linalg.norm(goes, axis=1)
        moves = speed > max(0.05, 0.1 * float(speed.max()))
        if said(facts.program, name, ("leaves",)):
            # What shall come off what it is on tips over the edge and may tumble from there.
            off = facts.is_clear(name, facts.whole()) | (track.tilt() > OFF_AXIS)
            moves &= ~np.logical_or.accumulate(off)
        if not moves.any():
            continue
        along = np.einsum("ti,ti->t", front, goes) / np.maximum(
            np.linalg.norm(front, axis=1) * speed, 1e-9
        )
        either = _met_something(facts, name)
        if name in facts.program.contract.backwards:
            # What has backed up may drive on, once it has come to a stand.
            along = -along
            either |= np.logical_or.accumulate(np.logical_or.accumulate(moves) & ~moves)
        # What it meets may send it back.
        along = np.where(either, np.abs(along), along)
        off = np.degrees(np.arccos(np.clip(along, -1, 1)))
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
