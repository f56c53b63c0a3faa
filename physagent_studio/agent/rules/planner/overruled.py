"""What a person says against a rollout that held: new demands, or a wish for more or less.

Who overrules a pass knows something that the contract does not ask for. Words that can be
read as an event become statements, so that from then on they are measured like the prompt's;
words of degree ("faster", "more to the left") turn the number that they speak of.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.contract.compile import contract_of
from physagent_studio.agent.rules.generator import stock_in
from physagent_studio.agent.rules.planner.factors import bias_of, may_change
from physagent_studio.agent.rules.planner.parameters import action_knobs, material_knobs
from physagent_studio.agent.rules.planner.trials import Candidate, Search
from physagent_studio.agent.rules.planner.wording import proposal, summary_of
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.errors import StudioError
from physagent_studio.language import read
from physagent_studio.program.contract import Contract, Statement
from physagent_studio.program.edits import AddItem, Edit, apply
from physagent_studio.records import Proposal

REACHES = (1.0, 2.0, 3.0)
"""How far a wished-for number is turned, in strides of its knob; the least that changes it."""


def as_the_person_says(situation: Situation, search: Search) -> Proposal:
    """A proposal from a person's newest words, or a question that asks for some."""
    words = situation.memory.hints[-1] if situation.memory.hints else ""
    program, runs = situation.program, search.runs
    if demanded := _demands(situation, words):
        said = f"You said “{words}”. It becomes part of what the event demands."
        summary = f"demand as well: {words}"
        return proposal(
            program, said, demanded, summary=summary, factor="contract", confidence=0.8,
            simulations=runs,
        )  # fmt: skip
    if (wished := _wished(situation, search)) is not None:
        held = "what is demanded still holds" if wished.score.holds else "it costs some demands"
        said = f"You said “{words}”: {summary_of(program, wished.edits)}; {held}."
        sure, factor = 0.7 if wished.score.holds else 0.4, wished.turned[0][0].factor
        return proposal(
            program, said, wished.edits, factor=factor, confidence=sure, simulations=search.runs
        )
    asked = "What should be different? For example: faster, later, or “the block stays upright”."
    return proposal(
        program, "everything that is demanded holds", simulations=search.runs, question=asked
    )


def _demands(situation: Situation, words: str) -> tuple[Edit, ...]:
    """Edits that add what the words demand beyond the contract; none where they are no event.

    They are read after the prompt, so that "it" means what it would mean there.
    """
    prompt = situation.program.event.prompt
    stock = stock_in(situation.case, situation.program.scene)
    layout = Layout(situation.program.scene)
    if not words or not read(words, stock).frames:
        return ()
    both = read(f"{prompt.rstrip(' .')}. {words}", stock)
    before, after = read(prompt, stock), contract_of(both, layout)
    if len(both.not_understood) > len(before.not_understood):
        return ()
    known = _plain(situation.program.contract)
    fresh = [s for s in after.statements if _key(s.model_dump(mode="json")) not in known]
    edits = tuple(_added(situation.program.contract, fresh, words))
    try:
        apply(situation.program, edits)
    except StudioError:
        return ()  # It speaks of a place that the scene does not have.
    return edits


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


def _wished(situation: Situation, search: Search) -> Candidate | None:
    """The knob that the words name, turned their way: as little as what is demanded allows."""
    bias = bias_of(situation)
    program = situation.program
    turnable = (*action_knobs(program), *material_knobs(program))
    named = [k for k in turnable if bias.rank(k) == 0 and may_change(situation, k.edits(k.value))]
    # What a person has set comes last; a pin is not even asked.
    named.sort(key=lambda k: k.path in situation.memory.verified)
    fallback: Candidate | None = None
    for knob in named[:4]:
        for reach in REACHES:
            found = search.turn([(knob, knob.shifted(bias.signs(knob)[0] * reach))])
            if found is not None and found.score.holds:
                return found
            fallback = fallback or found
    return fallback
