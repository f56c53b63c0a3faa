"""Event frames → contract: what each clause demands of a rollout."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from physagent_studio.agent.rules.contract.intents import met, prevented
from physagent_studio.agent.rules.contract.living import way_into_reach
from physagent_studio.agent.rules.contract.moments import denied, events
from physagent_studio.agent.rules.contract.senses import SENSES
from physagent_studio.agent.rules.contract.senses.beside import beside
from physagent_studio.agent.rules.contract.senses.common import touch
from physagent_studio.agent.rules.contract.sequence import (
    OVER,
    afterwards,
    farther,
    matched,
    over_then_on,
)
from physagent_studio.agent.rules.contract.specs import SPEC, Context, Spec, any_of, before, spec
from physagent_studio.agent.rules.contract.statements import Statements
from physagent_studio.agent.rules.contract.untold import untold
from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import Layout, place_name
from physagent_studio.knowledge import kind_of
from physagent_studio.language import EventFrame, Place, Reading
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.contract import Contract
from physagent_studio.program.program import Clip

_GIVING_WAY = words_of("topple fall collapse flip lean lose_balance knock_over break crush")
_GOES = words_of("move roll slide fly jump fall push pull drift")
_LATER = _GIVING_WAY | {"stop", "rest", "settle"}
_BLOWS = words_of("hit push kick fall land knock throw")
"""What happens to a thing because something hits it."""
_MET = ("against", "on", "atop")
"""Relations to what a thing meets there."""
_BY_ITSELF = words_of("fall leave slip jump bounce rise land flip spin break reach enter descend")
"""What is denied of everything else where only one thing does it."""
_TAKEN_OFF = words_of(
    "fall leave slip slide roll move push pull lift rise jump fly throw flip topple knock kick"
)
"""What happens to a thing on a stack without the rest of it."""
_ONLY_WHERE = words_of("on off from atop above over")
"""Relations to what a thing stands on that do not say that anything happens to that."""
_COMING_DOWN = words_of("fall leave slip descend topple land")


def contract_of(reading: Reading, layout: Layout, steps: int = Clip().steps) -> Contract:
    """The contract of a prompt over a scene; the same events in other words give the same.

    steps: of the clip.
    """
    draft = _Draft(layout, reading, steps)
    for index, frame in enumerate(reading.frames):
        draft.add(index, frame)
    for frame in reading.frames:
        draft.leave_alone(frame)
    return Contract.model_validate(
        {
            "clauses": [
                *({"id": c.id, "text": c.text[:4000] or c.id} for c in reading.clauses[:48]),
                *untold(reading, layout, draft.told.rows)[:16],
            ],
            "statements": draft.told.rows[:256],
            "not_understood": [word[:200] for word in reading.not_understood[:64]],
        }
    )


@dataclass
class _Draft:
    """What the frames of a reading demand, told one after the other."""

    layout: Layout
    reading: Reading
    steps: int
    told: Statements = field(default_factory=Statements)

    def add(self, index: int, frame: EventFrame) -> None:
        """Adds the statements of one frame, tied to its clause."""
        build: Callable[[Context], Sequence[Spec]] | None = SENSES.get(frame.sense)
        if build is None:
            return
        if self._until(index, frame):
            return
        subjects = frame.patient or self._everyone(frame)
        groups = [self._demanded(index, frame, subject) for subject in subjects]
        if prevented(self.reading, index) and frame.sense not in ("reach", "approach"):
            self._never(index, frame, groups)
        elif frame.negated and frame.link != "before":
            self._none_of(index, groups, frame.clause)
        elif frame.counted and len(groups) > 1:
            self._count_group(groups, frame)
        elif frame.any_one and len(groups) > 1:
            self._any_group(self._matched(index, frame, groups) or groups, frame.clause)
            told = [found[0] for group in groups if (found := events(group))]
            if len(told) == len(groups):
                self._sequel(index, frame, [[any_of(*told)]])
        else:
            for spec in (one for group in groups for one in group):
                self.told.state(spec, frame.clause)
            self._order(index, frame, groups)
            self._sequel(index, frame, groups)
            self._no_other(index, frame)
            self._in_time(frame, groups)

    def leave_alone(self, frame: EventFrame) -> None:
        """ "The top one falls off": what it stood on, of which nothing is told, stays there."""
        if frame.sense not in _TAKEN_OFF or frame.agent or frame.negated or frame.any_one:
            return
        told = {name for f in self.reading.frames for name in (*f.patient, *f.agent)}
        told |= {p.name for f in self.reading.frames for r, p in f.places if r not in _ONLY_WHERE}
        below = self.layout.carrier(frame.patient[0]) if len(frame.patient) == 1 else None
        while below is not None and self.layout.state.object(below) is not None:
            if below in told:
                return
            reach = round(SPEC.calm_share * self.layout.size(below), 3)
            calm = {"subject": below, "distance": reach, "tilt": SPEC.calm_degrees}
            self.told.state(Spec("stays", calm), frame.clause)
            below = self.layout.carrier(below)

    def _demanded(self, index: int, frame: EventFrame, subject: str) -> list[Spec]:
        """What the verb demands of one object, and what is said beside it."""
        frame = _beside_itself(frame, subject)
        context = self._context(index, frame, subject)
        found = list(SENSES[frame.sense](context))
        if frame.agent and not frame.negated and not any(_touches(one, frame) for one in found):
            # "Sinks the red ball", "spins the plate": it touches what it moves.
            found += touch(context)
        if frame.by and self.layout.has(frame.by):
            _, there = way_into_reach(self.layout, frame.by, subject)
            near = spec("moves", frame.by, toward=subject, distance=there)
            found += [before(near, event) for event in events(found)[:1]]
        if self._turned_first(index, frame) and self.layout.has(subject):
            found = farther(found, round(0.8 * self.layout.height(subject), 3))
        return [*found, *(one for one in beside(context) if one not in found)]

    def _turned_first(self, index: int, frame: EventFrame) -> bool:
        """Whether it is told that it falls over and goes on."""
        frames = self.reading.frames
        if index > 0 and over_then_on(frames[index - 1], frame):
            return True
        between = index > 1 and over_then_on(frames[index - 2], frames[index - 1])
        return between and over_then_on(frames[index - 2], frame)

    def _until(self, index: int, frame: EventFrame) -> bool:
        """ "Stands still until the ball hits it": it does so first, and not for ever."""
        following = self.reading.frames[index + 1 : index + 2]
        still = frame.sense in ("stay", "rest", "be") and not frame.negated
        if not still or not following or following[0].link != "until":
            return False
        build = SENSES.get(following[0].sense)
        for subject in frame.patient:
            first = {
                "subject": subject,
                "distance": 0.05,
                "tilt": 15.0,
                "to_step": SPEC.still_steps,
            }
            self.told.state(Spec("stays", first), frame.clause)
            other = (*following[0].patient, subject)[0]
            told = list(build(self._context(index + 1, following[0], other))) if build else []
            for event in events(told)[:1]:
                moved = Spec("moves", {"subject": subject, "distance": 0.05})
                early = Spec("all_of", {}, (Spec("before", {}, (moved, event)),))
                self.told.state(early.opposite(), frame.clause)
        return True

    def _context(self, index: int, frame: EventFrame, subject: str) -> Context:
        return Context(frame, subject, index, self.reading, self.layout, SENSES, self.steps)

    def _no_other(self, index: int, frame: EventFrame) -> None:
        """ "Only the cup falls": nothing that is not spoken of does."""
        if not frame.only or frame.agent or frame.sense not in _BY_ITSELF:
            return
        told = {*frame.patient}
        for one in self.reading.frames:
            # What strikes it may come down itself: only what is struck is spoken of.
            told |= set(one.agent)
            alike = one.sense == frame.sense or {one.sense, frame.sense} <= _COMING_DOWN
            told |= set(one.patient) if alike and not one.negated and one is not frame else set()
        told |= {row["subject"] for row in self.told.rows if row["kind"] == "stays"}
        for other in (item.name for item in self.layout.state.objects if item.name not in told):
            alone = replace(frame, patient=(other,), only=False)
            context = self._context(index, alone, other)
            for event in events(list(SENSES[frame.sense](context)))[:1]:
                self.told.state(event.opposite(), frame.clause)

    def _never(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "Stops before it touches the cup": that does not happen."""
        for agent in frame.agent:
            for other in frame.patient:
                self.told.state(
                    Spec("stops_before", {"subject": agent, "before": other}), frame.clause
                )
        for first in (group[0] for group in groups if group):
            self.told.state(first.opposite(), frame.clause)

    def _order(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "X before Y", "Y after X": both are demanded, and which of them comes first."""
        at = index + 1 if frame.leads else index - 1
        main = self.reading.frames[at] if 0 <= at < len(self.reading.frames) else None
        build = SENSES.get(main.sense) if main is not None else None
        told = any(one.kind == "before" for group in groups for one in group)
        if main is None or build is None or main.negated or told or not main.patient:
            return
        blow = frame.link == "as" and (frame.sense == "hit" or bool(met(frame)))
        blow |= frame.link in ("because", "since") and frame.sense in _BLOWS
        caused = blow and main.sense in _GIVING_WAY and not frame.leads
        if frame.link not in ("before", "after", "once") and not caused:
            return
        told_of = [list(build(self._context(at, main, name))) for name in main.patient]
        earlier = next((specs for specs in told_of if events(specs)), told_of[0])
        mine = next((s for s in events(groups[0] if groups else []) if s not in earlier), None)
        other = next((s for s in events(earlier) if s != mine), None)
        if mine is not None and other is not None:
            pair = (other, mine) if frame.link == "before" else (mine, other)
            order = Spec("before", {}, pair)
            if caused and main.sense == "break":
                # What shatters as it is hit does so within the control step of the blow.
                order = Spec("before", {}, pair[::-1]).opposite()
            self.told.state(order, frame.clause)

    def _sequel(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "First … then … finally": in that order."""
        main = self.reading.frames[index - 1] if index else None
        over = self._turned_first(index, frame)
        told = frame.sequel or over
        if over and not frame.sequel and main is not None and main.sense not in OVER:
            # "Tips over, rolls to the edge and drops": it tipped over before all of that.
            index, main = index - 1, self.reading.frames[index - 2]
        if main is None or not told or main.negated or main.any_one or main.counted:
            return
        if main.sense not in SENSES or frame.link not in ("then", "once"):
            return
        earlier = [s for name in main.patient[:1] for s in self._demanded(index - 1, main, name)]
        later = list(groups[0] if groups else [])
        below = self.layout.carrier(frame.patient[0]) if over else None
        if frame.sense in _COMING_DOWN and below not in (None, self.layout.ground()):
            # It falls over where it stands, and not only in the air.
            later = [Spec("leaves", {"subject": frame.patient[0], "other": below}), *later]
        order = afterwards(earlier, later, goes_on=over)
        if order is not None:
            self.told.state(order, frame.clause)

    def _matched(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> list[list[Spec]]:
        """What "the other" does, or the one itself goes on to do, with what the one does."""
        main = self.reading.frames[index - 1] if index else None
        if main is None or set(main.patient) != set(frame.patient) or main.negated:
            return []
        if not main.any_one or main.sense not in SENSES:
            return []
        first = [self._demanded(index - 1, main, name) for name in frame.patient]
        return [list(way) for way in matched(main, frame, first, groups)]

    def _in_time(self, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "One after another", "at the same time"."""
        if not frame.timing:
            return
        told = [(events(group) or group)[0] for group in groups if group]
        row = self._passed_on(frame, told) if frame.timing == "in_turn" else []
        if len(told := row or told) > 1:
            wave = frame.timing == "in_turn" and (bool(row) or len(told) > 3)
            fields = {"apart": self._wave_seconds(frame)} if wave else {}
            fields |= {"ordered": True} if row else {}
            self.told.state(Spec(frame.timing, fields, tuple(told)), frame.clause)

    def _passed_on(self, frame: EventFrame, told: Sequence[Spec]) -> list[Spec]:
        """A row that goes over from the one that brings down the others, the nearer ones sooner."""
        known = all(self.layout.has(name) for name in (*frame.agent, *frame.patient))
        if len(frame.agent) != 1 or not known or any(s.kind != "topples" for s in told):
            return []
        (first,) = frame.agent
        row = {s.fields["subject"]: s for s in told}
        kind = kind_of(first)
        alike = kind is not None and all(kind_of(name) is kind for name in row)
        if first in row or len(row) < 2 or not alike:
            # What only strikes the first of them does not fall with them.
            return []
        struck = replace(told[0], fields={**told[0].fields, "subject": first})
        away = {name: self.layout.position(name) - self.layout.position(first) for name in row}
        return [struck, *(row[n] for n in sorted(row, key=lambda n: float(away[n] @ away[n])))]

    def _wave_seconds(self, frame: EventFrame) -> float:
        """A row of dominoes goes down as a wave: closer after one another than two things do, and
        the closer the smaller they are, as they fall the sooner."""
        heights = [self.layout.height(n) for n in frame.patient if self.layout.has(n)]
        waves = [SPEC.wave_share * mech.time_to_fall(height) for height in heights]
        return round(min(waves, default=SPEC.max_wave_s), 4)

    def _everyone(self, frame: EventFrame) -> tuple[str, ...]:
        """A wind that names nobody blows on whatever the prompt speaks of; what loses its
        support is what is said to fall."""
        if frame.sense == "withdrawn":
            told = ("lose_support", "fall", "land", "topple")
            falling = [f for f in self.reading.frames if f.sense in told]
            return tuple(dict.fromkeys(n for f in falling for n in f.patient))
        if frame.sense != "wind":
            return ()
        named = {n: None for f in self.reading.frames for n in f.patient}
        return tuple(named) or tuple(item.name for item in self.layout.state.objects)

    def _none_of(self, index: int, groups: list[list[Spec]], clause: str) -> None:
        frame = self.reading.frames[index]
        following = self.reading.frames[index + 1 : index + 2]
        # "Does not move until …" speaks of the beginning.
        first = bool(following) and following[0].link in ("until", "before")
        # So does "does not move at first, then it rolls".
        goes = bool(following) and following[0].patient == frame.patient and frame.sense == "move"
        first |= goes and following[0].sense in _GOES and not following[0].negated
        if bool(following) and following[0].link == "until" and frame.sense in _LATER:
            # "Does not topple until the ball hits it": that it does so later is not tested.
            return
        touched = self._touched(index, frame)
        for one in (part for group in groups for part in denied(group, touched)):
            if one.kind == "moves" and not {"direction", "toward"} & set(one.fields):
                still = {"subject": one.fields["subject"], "distance": 0.05, "tilt": 15.0}
                still |= {"to_step": SPEC.still_steps} if first else {}
                self.told.state(Spec("stays", still), clause)
            else:
                self.told.state(one.opposite(), clause)

    def _touched(self, index: int, frame: EventFrame) -> bool | None:
        """Whether an earlier clause has the agent touch it; None where nothing acts on it."""
        if not frame.agent:
            return None
        met = (f for f in self.reading.frames[:index] if not f.negated)
        return any(
            (set(f.agent) & set(frame.agent) and set(f.patient) & set(frame.patient))
            or (
                # "Comes to rest against the cup without knocking it over", "lands on it".
                set(f.patient) & set(frame.agent)
                and any(to in _MET and at.name in frame.patient for to, at in f.places)
            )
            for f in met
        )

    def _any_group(self, groups: list[list[Spec]], clause: str) -> None:
        of = self.told.joined(groups, clause)
        if of:
            self.told.put({"kind": "any_of", "of": of}, f"any_{of[0]}", clause)

    def _count_group(self, groups: list[list[Spec]], frame: EventFrame) -> None:
        """ "At least two of the pins fall"."""
        of = self.told.joined(groups, frame.clause)
        if of:
            high = len(of) if frame.most is None else frame.most
            count = {"kind": "count_of", "of": of, "low": frame.least, "high": high}
            self.told.put(count, f"count_{of[0]}", frame.clause)


def landmarks_needed(reading: Reading) -> tuple[Place, ...]:
    """Places of the prompt that have to become landmarks of the scene, once each."""
    found: dict[str, Place] = {}
    for place in reading.places():
        if place.kind == "landmark" or (place.kind == "support" and place.part):
            found.setdefault(place_name(place), place)
    return tuple(found.values())


def _beside_itself(frame: EventFrame, subject: str) -> EventFrame:
    """ "One of the two rolls into the other": into the one that it is not."""
    others = [name for name in frame.patient if name != subject]
    if not frame.any_one or len(others) != 1:
        return frame
    rows = tuple(
        (relation, replace(place, name=others[0]) if place.name == subject else place)
        for relation, place in frame.places
    )
    return replace(frame, places=rows)


def _touches(spec: Spec, frame: EventFrame) -> bool:
    """Whether a demand holds that something that acts touches something."""
    mine = spec.kind == "contacts" and spec.fields.get("subject") in (*frame.agent, *frame.patient)
    return mine or any(_touches(part, frame) for part in spec.parts)
