"""What each fixed expression and turn of phrase of the reader is worth.

`python -m tests.agent.rules.ledger` leaves out one after another, reads this folder's sentences
again and prints how many are read otherwise. docs/ledger-words.md keeps what it printed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import yaml

from physagent_studio.agent.rules.generator import stock_of
from physagent_studio.language import Inventory, read
from physagent_studio.language.syntax import idioms, rewriting
from physagent_studio.language.tokens import expressions
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES
from tests.agent.rules.varied_scenes import VARIED

HERE = Path(__file__).parent
PLACES = {**STAGES, **EVERYDAY, **VARIED}
RULES = ("_out_of_sight", "where_it_is", "_performed", "_amounts", "_unable", "counted_from")

Sentence = tuple[str, Inventory, bool]
"""A prompt, what there is, and whether it was written before anything read it."""


def sentences() -> Iterator[Sentence]:
    """All sentences of this folder that speak of a place."""
    for name in ("varied", "everyday", "wordings"):
        for row in yaml.safe_load((HERE / f"{name}.yaml").read_text(encoding="utf-8")):
            yield row["prompt"], stock_of(PLACES[row["stage"]].case(row["prompt"])), False
    for place, rows in yaml.safe_load((HERE / "fresh.yaml").read_text(encoding="utf-8")).items():
        for prompt in rows:
            yield prompt, stock_of(PLACES[place].case(prompt)), True


def changed(
    every: list[Sentence], before: list[str], said: tuple[str, ...] = ("",)
) -> tuple[int, int]:
    """How many sentences are read otherwise now, and how many of those are the fresh ones.

    said: what they have to hold for that.
    """
    other = [
        fresh
        for (prompt, stock, fresh), was in zip(every, before, strict=True)
        if any(words in prompt.lower() for words in said) and _told(prompt, stock) != was
    ]
    return len(other), sum(other)


def _told(prompt: str, stock: Inventory) -> str:
    reading = read(prompt, stock)
    frames = [(replace(one, manner=frozenset()), sorted(one.manner)) for one in reading.frames]
    return f"{frames}{reading.not_understood}"


def rows() -> Iterator[tuple[str, int, int]]:
    """Each turn with how many sentences it changes, and how many fresh ones."""
    every = list(sentences())
    before = [_told(prompt, stock) for prompt, stock, _ in every]
    for name in RULES:
        with patch.object(idioms, name, lambda tokens, nouns: tokens):
            yield name.strip("_").replace("_", " "), *changed(every, before)
    with patch.object(rewriting, "_excepted", lambda tokens, nouns: tokens):
        yield "excepted", *changed(every, before)
    table = expressions.FIXED
    for plain in dict.fromkeys(one for _, one in table):
        said = tuple(" ".join(words) for words, one in table if one == plain)
        with patch.object(expressions, "FIXED", tuple(row for row in table if row[1] != plain)):
            yield f"{', '.join(said)} → {plain}", *changed(every, before, said)


if __name__ == "__main__":
    print("| turn | sentences changed | of the fresh ones |\n|---|---|---|")
    for turn, count, fresh in sorted(rows(), key=lambda row: -row[1]):
        print(f"| {turn} | {count} | {fresh} |")
