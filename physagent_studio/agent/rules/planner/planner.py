"""P: maps a mismatch to factors, finds numbers by search, proposes the smallest change."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.asked import Understood, keeping, understood
from physagent_studio.agent.rules.planner.costs import cost_of
from physagent_studio.agent.rules.planner.directing import VIEW, direct
from physagent_studio.agent.rules.planner.factors import Bias, bias_of, may_change, relevant_knobs
from physagent_studio.agent.rules.planner.overruled import (
    following,
    heard,
    what_is_asked,
    with_words,
)
from physagent_studio.agent.rules.planner.parameter_search import along_one, cross_entropy
from physagent_studio.agent.rules.planner.parameters import Knob
from physagent_studio.agent.rules.planner.repairs import goes_in_turn, structural
from physagent_studio.agent.rules.planner.stage_one import repair_likeness, repair_scene
from physagent_studio.agent.rules.planner.trials import Candidate, Score, Search
from physagent_studio.agent.rules.planner.wording import (
    apart_from_pace,
    proposal,
    question_for,
    rationale_of,
)
from physagent_studio.program.edits import Edit
from physagent_studio.records import Proposal


@dataclass(frozen=True, slots=True)
class PlannerSettings:
    """When a search goes on, and what it may cost."""

    min_gain_share: float = 0.02  # 0..0.2: of the margins, that is worth a proposal
    many_unseen: int = 3  # checks, 2..6: of the view that fail, from which the director comes first
    # checks, 1..6: that fail at most, where all numbers are shaken before a search is given up
    max_shaken_failing: int = 4
    shaken_runs: int = 24  # count, 8..60: of runs then
    shaken_strides: float = 0.5  # strides, 0.2..1.5: by which each number is changed then
    max_shaken_count: int = 6  # count, 2..10: of numbers
    min_runs: int = 6  # count, 2..20: that a search may always make, however dear they are
    dear_units: float = 5.0  # cost, 2..20: of a run, from which it is dear


PLANNER = PlannerSettings()


class _Ways:
    """What may be changed: worked out once, however often a search is played through."""

    def __init__(self, situation: Situation) -> None:
        """directed: changes of the schedule; structural: repairs. knobs: what is turned;
        knobs_after: in a candidate."""
        self.structural = cache(lambda: (*structural(situation),))
        self.knobs = cache(partial(relevant_knobs, situation))
        self.directed = cache(lambda: (*direct(situation),))
        self.knobs_after = cache(partial(_knobs_after, situation))


def _knobs_after(situation: Situation, best: Candidate) -> list[Knob]:
    return relevant_knobs(replace(situation, program=best.program), verified=False)[:4]


class RulePlanner:
    """Searches by simulation; deterministic: the same situation gives the same proposal."""

    def __init__(self, limit: int = 60) -> None:
        """limit: most runs of one proposal, where a run costs one unit (`costs`)."""
        self.limit = min(limit, 200)

    def propose(self, situation: Situation) -> Proposal:
        """Edits of just the failed factor; without hunks and with a question where it is stuck."""
        words = heard(situation)
        told = understood(situation.program, words) if words else Understood()
        made = self._proposed(keeping(situation, told.kept), told, words)
        return with_words(situation, made, told, words)

    def _proposed(self, situation: Situation, told: Understood, words: str) -> Proposal:
        if situation.assessment.stage == "reconstruction":
            return repair_scene(situation)
        search = self._search(situation)
        followed = following(situation, search, told, words) if words else None
        if followed is not None:
            return followed
        if situation.assessment.passed:
            return what_is_asked(situation, search)
        if (shaped := repair_likeness(situation)) is not None:
            return shaped
        if not situation.program.contract.statements and not situation.program.event.actions:
            # Nothing that the sentence says is known to be brought about.
            return _stuck(situation, search)
        if {m.code for m in situation.assessment.diagnosis} == {"unlike_the_photo"}:
            # No schedule mends how a thing is drawn: a person chooses another mask or shape.
            return _stuck(situation, search)
        best = search.carry_out(partial(self._searched, situation, _Ways(situation)))
        start = search.start()
        if best is not None and _worth(best.score, start.score):
            return _proposal(situation, start, best, search)
        if start.score.failing <= PLANNER.max_shaken_failing:
            search = self._last_search(situation)
            best = search.carry_out(partial(self._shaken, situation))
            if best is not None and _worth(best.score, start.score):
                return _proposal(situation, search.start(), best, search)
        return _stuck(situation, search)

    def _last_search(self, situation: Situation) -> Search:
        """A budget for what is tried last, where little is missing: the same in every round."""
        cost = cost_of(situation.program)
        runs = max(int(PLANNER.shaken_runs / cost), PLANNER.min_runs)
        return Search(situation, min(runs, self.limit), dear=cost > PLANNER.dear_units)

    def _shaken(self, situation: Situation, search: Search) -> Candidate | None:
        """All numbers changed a little at once: what bumps into things comes out otherwise then."""
        knobs = relevant_knobs(situation, verified=False)[: PLANNER.max_shaken_count]
        if not knobs:
            return None
        return cross_entropy(
            search, knobs, seed=_seed(situation), bias=bias_of(situation).signs,
            spread=PLANNER.shaken_strides, population=PLANNER.shaken_runs // 2, rounds=2,
        )  # fmt: skip

    def _search(self, situation: Situation) -> Search:
        """A budget of units: what the first proposals did not find is worth less and less."""
        cost = cost_of(situation.program)
        units = self.limit / (1 + 0.5 * len(situation.memory.entries))
        least = min(self.limit, PLANNER.min_runs)
        return Search(situation, max(int(units / cost), least), dear=cost > PLANNER.dear_units)

    def _searched(self, situation: Situation, ways: _Ways, search: Search) -> Candidate | None:
        """Factor after factor, then several together, then other actions, verified facts last."""
        bias = bias_of(situation)
        for verified in (False, True):
            knobs = ways.knobs(verified)
            if not knobs:
                continue
            found = self._rounds(situation, ways, search, knobs, bias, verified)
            if found is not None and _worth(found.score, search.start().score):
                return found
        return search.best

    def _rounds(
        self,
        situation: Situation,
        ways: _Ways,
        search: Search,
        knobs: list[Knob],
        bias: Bias,
        verified: bool,
    ) -> Candidate | None:
        codes = {m.code for m in situation.assessment.diagnosis}
        unseen = sum(m.code in VIEW for m in situation.assessment.diagnosis)
        if not verified and (codes <= set(VIEW) or unseen >= PLANNER.many_unseen):
            found = self._restructured(situation, ways, search, bias, ways.directed())
            if found is not None:
                return found
            best, failing = search.best, search.start().score.failing
            if best is not None and best.score.failing <= failing / 2:
                return best
        idle = bool(codes & {"does_not_move", "no_cause", "not_reversed"})
        # Of a group that does not fall over no single number is to blame.
        falls = {m.subject for m in situation.assessment.diagnosis if m.code == "not_toppled"}
        idle |= len(falls) > 1
        # A row that goes as one was struck too hard for any small change to tell.
        idle |= "wrong_order" in codes and goes_in_turn(situation)
        if idle and not verified:
            found = self._restructured(situation, ways, search, bias, ways.structural())
            if found is not None:
                return found
        singles: list[tuple[Score, Knob]] = []
        for knob in knobs[:6]:
            found = along_one(search, knob, bias.signs(knob), runs=7)
            if found is not None:
                if found.score.holds:
                    return found
                singles.append((found.score, knob))
        if not idle and not verified:
            changes = (*ways.structural(), *ways.directed())
            found = self._restructured(situation, ways, search, bias, changes)
            if found is not None:
                return found
        return self._together(situation, search, singles, bias)

    def _restructured(
        self,
        situation: Situation,
        ways: _Ways,
        search: Search,
        bias: Bias,
        changes: Iterable[tuple[Edit, ...]],
    ) -> Candidate | None:
        """Tries changes of the schedule, then turns the numbers of what helped most."""
        best: Candidate | None = None
        for edits in changes:
            found = search.run(edits) if may_change(situation, edits) else None
            if found is not None and (best is None or found.score < best.score):
                best = found
            if best is not None and best.score.holds:
                return best
        if best is None or best.score.holds or not _worth(best.score, search.start().score):
            return best if best is not None and best.score.holds else None
        for knob in ways.knobs_after(best):
            found = along_one(search, knob, bias.signs(knob), first=best.edits, runs=6)
            if found is not None and found.score.holds:
                return found
        return search.best if search.best is not None and search.best.score.holds else None

    def _together(
        self,
        situation: Situation,
        search: Search,
        singles: list[tuple[Score, Knob]],
        bias: Bias,
    ) -> Candidate | None:
        """The two or three knobs that helped most, from the best structure found so far."""
        singles.sort(key=lambda row: row[0])
        chosen = _spread([knob for _, knob in singles])
        if len(chosen) < 2:
            return search.best
        found = cross_entropy(
            search, chosen, seed=_seed(situation), bias=bias.signs, population=8, rounds=4
        )
        return found if found is not None and found is search.best else search.best


def _spread(knobs: Sequence[Knob]) -> list[Knob]:
    """At most three knobs, of different fields."""
    chosen: list[Knob] = []
    for knob in knobs:
        if all(knob.path != other.path for other in chosen):
            chosen.append(knob)
    return chosen[:3]


def _seed(situation: Situation) -> int:
    digest = hashlib.sha256(situation.program.hash.encode()).digest()
    return int.from_bytes(digest[:4], "big")


def _worth(new: Score, old: Score) -> bool:
    if new.failing != old.failing:
        return new.failing < old.failing
    return new.shortfall < old.shortfall - PLANNER.min_gain_share * max(old.shortfall, 0.05)


def _proposal(situation: Situation, start: Candidate, best: Candidate, search: Search) -> Proposal:
    verified = situation.memory.verified
    paths = [getattr(edit, "path", "") for edit in best.edits]
    touches = any(path == v or path.startswith(f"{v}.") for path in paths for v in verified)
    gained = start.score.failing - best.score.failing
    factor = best.turned[0][0].factor if best.turned else "action"
    confidence = (
        0.9 if best.score.holds else 0.4 + 0.4 * max(gained, 0) / max(start.score.failing, 1)
    )
    return proposal(
        situation.program,
        rationale_of(situation, start, best),
        *_grouped(best),
        factor=factor,
        confidence=round(confidence, 2),
        simulations=search.runs,
        touches_verified=touches,
    )


def _grouped(best: Candidate) -> list[tuple[Edit, ...]]:
    """One hunk per edit, so that each can be accepted by itself; another pace is one as a whole."""
    paced, others = apart_from_pace(best.edits)
    return [*([paced] if paced else []), *((edit,) for edit in others)]


def _stuck(situation: Situation, search: Search) -> Proposal:
    rationale = f"no change of one to three factors made it better ({search.runs} tried)"
    asked = question_for(situation)
    return proposal(situation.program, rationale, simulations=search.runs, question=asked)
