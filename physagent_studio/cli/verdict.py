"""What `physagent run` says in the end: the verdict, what is not sure, what fails, the clip."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer

from physagent_studio.agent.by_hand import waits_for
from physagent_studio.cli import output
from physagent_studio.language.tokens.spelling import instead_of
from physagent_studio.program.timing import length_in_words
from physagent_studio.records import LoopState, Round
from physagent_studio.session.standing import IN_DOUBT
from physagent_studio.studio.panels.words import speaker

HOW = " (in the studio), or give its row in pixels with --horizon ROW"
"""Where on the command line the ends of the horizon are said."""
ENDED = {"budget": "all rounds are used up", "stuck": "there is no further idea"}
"""Outcomes that do not say by themselves why a loop ended."""


def is_plain(report: dict[str, Any]) -> bool:
    """Whether every clause is tested, every word understood, and nothing in it doubted."""
    return not report["untested"] and not report["not_understood"] and not report["doubts"]


def tell(report: dict[str, Any], state: LoopState, *, asked: bool, verbose: bool) -> None:
    """Prints what a run amounts to. asked: it waits for a word on a mask. verbose: all checks."""
    best = state.best or state.current
    speak = speaker(best.program) if best is not None else str
    verdict = _verdict(report, state, speak, asked=asked)
    typer.echo(verdict)
    _listed("not sure:", [speak(text) for text in _unsure(report)])
    checks = best.assessment.checks if best is not None and best.assessment else ()
    failing = [one.text for one in checks if one.demanded and not one.ok]
    told = dict.fromkeys(speak(text) for text in (*report["diagnosis"], *failing))
    _listed("fails:", [text for text in told if text not in verdict])
    if report.get("left_out"):
        _listed("of the configuration not taken over:", report["left_out"])
    if verbose:
        output.print_checks(checks)
    elif checks and not asked:
        held = sum(one.ok for one in checks if one.demanded)
        hold = "holds" if held == 1 else "hold"
        typer.echo(f"{output.count(held, 'check')} {hold} (--verbose lists them)")
    if best is not None and best.proposal is not None and best.proposal.question:
        # What is wrong has been said; what a person can do has not.
        typer.echo(speak(best.proposal.question).rpartition(". ")[2])
    for picture in report.get("pictures", ()):
        typer.echo(f"its candidates: {picture}")
    if not asked and not waits_for(state):
        typer.echo(_where(report, best))


def _verdict(
    report: dict[str, Any], state: LoopState, speak: Callable[[str], str], *, asked: bool
) -> str:
    """One sentence: whether it happens, and what it took to know."""
    session = report["session"]
    if asked:
        return (
            "waiting for your word, for a mask is more likely wrong than right: physagent studio"
            f" {session};{_again(report)} or run again with --yes to go on as it is"
        )
    if waiting := waits_for(state):
        return f"waiting for {waiting}: physagent studio {session}"
    took = (
        f"({output.count(report['rounds'], 'round')},"
        f" {output.count(report['simulations'], 'simulation')}, {report['seconds']:.1f} s)"
    )
    if report["realised"]:
        return f"realised{'' if is_plain(report) else f', {IN_DOUBT}'} {took}"
    outcome = report["outcome"]
    why = speak(report["diagnosis"][0]) if report["diagnosis"] else ENDED.get(outcome, outcome)
    return f"not realised ({outcome}): {why} {took}"


def _again(report: dict[str, Any]) -> str:
    """What to say of boxes where some of what is asked about has none."""
    if not any(one["helps"].startswith("draw a box") for one in report["doubts"]):
        return ""
    return (
        ' or run again with a box around it (--object "name@x0,y0,x1,y1", in a case.yaml `box: [x0,'
        " y0, x1, y1]`),"
    )


def _unsure(report: dict[str, Any]) -> list[str]:
    """What is doubted, untested and not understood, each said once."""
    words = report["not_understood"]
    return [
        *(
            f"{one['text']}{HOW if one['kind'] == 'camera' else ''}"
            for one in report["doubts"]
            if one["kind"] != "word"
        ),
        *(f"not understood: “{word}”: {instead_of(word)}" for word in words),
        *(f"not tested: {text}" for text in report["untested"] if text not in words),
        *(
            f"{use['model']} is not used: {use['failed']}"
            for use in report["learned"]
            if use["failed"]
        ),
    ]


def _where(report: dict[str, Any], best: Round | None) -> str:
    """How long the clip is and at what pace, and where it is seen."""
    session = report["session"]
    look = f"look at it: physagent studio {session}"
    if best is None or best.rollout is None:
        return look
    shown = f"clip: {length_in_words(best.program.clip)}"
    return f"{shown}\n{look} · video: physagent render {session} --out clip.mp4"


def _listed(head: str, lines: list[str]) -> None:
    if lines:
        typer.echo("\n".join((head, *(f"  - {line}" for line in lines))))
