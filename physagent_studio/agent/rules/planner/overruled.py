"""What a person says to the planner: followed where it is certain, else put back as a question.

Words of degree ("later", "too fast") turn the number that they speak of; words that can be read
as an event become statements, so that from then on they are measured like the prompt's. What was
understood is said in a line, and what could be meant is offered.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.contract.compile import contract_of
from physagent_studio.agent.rules.generator import stock_in
from physagent_studio.agent.rules.planner.asked import Understood, suggested
from physagent_studio.agent.rules.planner.factors import may_change
from physagent_studio.agent.rules.planner.trials import Candidate, Search
from physagent_studio.agent.rules.planner.wording import proposal, summary_of
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.errors import StudioError
from physagent_studio.language import read
from physagent_studio.program.contract import Contract, Statement
from physagent_studio.program.edits import AddItem, Edit, apply
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records import Case, Proposal

OBLIGED = re.compile(
    r"\b(?:has|have|needs?|ought|got|(?:is|are|was|were)( not)? (?:supposed|meant|allowed)) to\b",
    re.IGNORECASE,
)
"""Other ways to say "must"."""
DENIED = re.compile(
    r"[,.;!]*(?: and| but)?\s+(?:it|that|this|they|which)(?:(?:'s| is| was) (?:wrong|not right)"
    r"|(?: should| must| may| shall)(?: not|n't)(?: be| have| happen)*)\W*$",
    re.IGNORECASE,
)
"""After what happens: that it must not."""
PART = re.compile(r"[,.;!?]+\s*|\bbut\b", re.IGNORECASE)
WISHED = re.compile(r"^(?:demand|let|make|have)\b|\b(?:must|should|shall|may)\b", re.IGNORECASE)
"""What says that something is to be so; without it words may as well be a complaint."""
DEMAND = "demand that "
"""Begins words that are a demand and nothing else."""


def heard(situation: Situation) -> str:
    """The newest words of a person that no proposal has answered yet."""
    memory = situation.memory
    passed = situation.assessment.passed
    return memory.said or (memory.hints[-1] if passed and memory.hints else "")


def following(
    situation: Situation, search: Search, told: Understood, words: str
) -> Proposal | None:
    """A proposal that does what a person said; None where that is not certain."""
    found = _turned(situation, search, told)
    program, runs = situation.program, search.runs
    if found is not None:
        said = f"You said “{words}”: {summary_of(program, found.edits)}; "
        sure, factor = 0.7 if found.score.holds else 0.4, found.turned[0][0].factor
        return proposal(
            program, f"{said}{_so_far(situation, found)}.", found.edits, factor=factor,
            confidence=sure, simulations=runs,
        )  # fmt: skip
    if told.heard:
        return None
    if demanded := is_wished(words) and demands(situation.case, program, words):
        words = words.removeprefix(DEMAND)
        said = f"You said “{words}”. It becomes part of what the event demands."
        summary = f"demand as well: {words}"
        return proposal(
            program, said, demanded, summary=summary, factor="contract", confidence=0.8,
            simulations=runs,
        )  # fmt: skip
    return None


def _so_far(situation: Situation, found: Candidate) -> str:
    if found.score.holds:
        return "what is demanded still holds" if situation.assessment.passed else "all holds then"
    if situation.assessment.passed:
        return "it costs some demands"
    failing = found.score.failing
    return f"{failing} {'check' if failing == 1 else 'checks'} would still fail"


def what_is_asked(situation: Situation, search: Search) -> Proposal:
    """Where all holds and nobody said what else should be: a question."""
    asked = "What should be different? For example: faster, or “the block must stay upright”."
    return proposal(
        situation.program, "everything that is demanded holds", simulations=search.runs,
        question=asked,
    )  # fmt: skip


def with_words(situation: Situation, made: Proposal, told: Understood, words: str) -> Proposal:
    """The proposal with what was understood of the words, or what they could mean."""
    if not words:
        return made
    demand = made.factor == "contract"
    line = told.line or (f"a new demand, “{words.removeprefix(DEMAND)}”" if demand else "")
    meant = told.meant
    look = ("Look at the photo", "")
    max_said = 80  # letters, 40..200: a button holds no more
    if not line:
        near = suggested(situation.program, words)
        meant = meant or ((*near.meant, look) if near.photo else near.meant)
        if demands(situation.case, situation.program, words):
            meant = ((f"Demand it: {words}"[:max_said], f"{DEMAND}{words}"), *meant)
    if told.photo:
        meant = (look, *meant)
    return made.model_copy(update={"understood": line, "meant": meant})


def is_wished(words: str) -> bool:
    """Whether words say that something is to be so, and not only that it is."""
    return WISHED.search(_obliged(words)) is not None


def _obliged(words: str) -> str:
    return OBLIGED.sub(r"must\1", words)


def demands(case: Case, program: PhysicalProgram, words: str) -> tuple[Edit, ...]:
    """Edits that add what the words demand beyond the contract; none where they are no event.

    They are read after the prompt, so that "it" means what it would mean there.
    """
    prompt = program.event.prompt
    stock = stock_in(case, program.scene)
    layout = Layout(program.scene)
    words, denied = DENIED.subn("", words.removeprefix(DEMAND))
    words = _obliged(words)
    if words and not read(words, stock).frames:
        words = f"it {words}"  # "Slides forward"
    told = _told_before(words)
    before, both = (read(f"{prompt.rstrip(' .')}. {more}", stock) for more in (told, words))
    if len(both.not_understood) > len(before.not_understood) or both.frames == before.frames:
        return ()
    known = _plain(program.contract) | _plain(contract_of(before, layout, program.clip.steps))
    after = contract_of(both, layout, program.clip.steps).statements
    fresh = [s for s in after if _key(s.model_dump(mode="json")) not in known]
    if denied:
        if len(fresh) != 1 or fresh[0].negated:
            return ()
        fresh = [fresh[0].model_copy(update={"negated": True, "id": f"not_{fresh[0].id}"[:64]})]
    edits = tuple(_added(program.contract, fresh, words))
    try:
        apply(program, edits)
    except StudioError:
        return ()  # It speaks of a place that the scene does not have.
    return edits


def _told_before(words: str) -> str:
    """Of words that ask for something, what they only tell before they do: "it wobbles, but it must
    stand" does not ask for the wobbling."""
    parts = PART.split(words)
    first = next((at for at, part in enumerate(parts) if is_wished(part.strip())), 0)
    return ". ".join(part.strip() for part in parts[:first])


def _plain(contract: Contract) -> set[str]:
    return {_key(s.model_dump(mode="json")) for s in contract.statements}


def _key(statement: dict[str, object]) -> str:
    return repr(sorted((k, v) for k, v in statement.items() if k not in ("id", "clause")))


def _added(contract: Contract, fresh: Sequence[Statement], words: str) -> Iterator[Edit]:
    if not fresh:
        return
    clause = _free("person", {c.id for c in contract.clauses})
    yield AddItem(path="contract.clauses", item={"id": clause, "text": words[:4000]})
    taken = {s.id for s in contract.statements}
    names: dict[str, str] = {}
    for statement in fresh:
        names[statement.id] = _free(statement.id, taken)
        taken.add(names[statement.id])
    for statement in fresh:
        data = statement.model_dump(mode="json", exclude_none=True)
        data |= {"id": names[data["id"]], "clause": clause}
        data |= {f: names.get(data[f], data[f]) for f in ("first", "second") if f in data}
        if "of" in data:
            data["of"] = [names.get(one, one) for one in data["of"]]
        yield AddItem(path="contract.statements", item=data)


def _free(name: str, taken: set[str]) -> str:
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name[:57]}_{number}"
    return found


def _turned(situation: Situation, search: Search, told: Understood) -> Candidate | None:
    """All that is certain, turned its way: as little as what is demanded allows."""
    free = [one for one in told.changes if may_change(situation, one.knob.edits(one.knob.value))]
    best: Candidate | None = None
    # strides, 0.5..5: by which a wished-for number is turned; the least that does
    reach_strides = (1.0, 2.0, 3.0)
    for reach in reach_strides if free else ():
        found = search.turn([(one.knob, one.knob.shifted(one.sign * reach)) for one in free])
        if found is not None and found.score.holds:
            return found
        if found is not None and (best is None or found.score < best.score):
            best = found
    return best
