"""What `physagent study` and `physagent judge` do: people, a model or VBench compare clips."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path

from physagent_studio.benchmark.study.answers import read_answers
from physagent_studio.benchmark.study.figures import summary
from physagent_studio.benchmark.study.server import QUESTION, StudyServer
from physagent_studio.benchmark.study.trials import study_of


def figures_of(folder: Path) -> list[str]:
    """The figures of the answers so far, lines of Markdown."""
    study_of(folder)
    return summary(read_answers(folder))


def ask(folder: Path, seed: int, port: int, question: str, *, browser: bool) -> None:
    """Asks raters on loopback until Ctrl+C; every answer is kept as it comes."""
    study = study_of(folder, seed)
    with StudyServer(study, port, question or QUESTION) as server:
        print(f"study: {server.address}  (Ctrl+C ends it; every answer is kept)", flush=True)
        if browser:
            webbrowser.open(server.address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


def judged(folder: Path, seed: int, frames: int) -> list[str]:
    """The figures of a model's grades; says on standard error what has been judged."""
    from physagent_studio.benchmark.judge import agreement
    from physagent_studio.benchmark.judge.judging import judge, line_from_environment

    found = []
    for one in judge(study_of(folder, seed), line_from_environment(), frames):
        found.append(one)
        print(f"{one.clip}: {one.preferred or 'equal'}, {one.reason}", file=sys.stderr, flush=True)
    return agreement.summary(found)


def vbench_of(folder: Path, python: str) -> list[str]:
    """VBench's scores of the methods in a folder."""
    from physagent_studio.benchmark.judge.vbench import summary as table
    from physagent_studio.benchmark.judge.vbench import vbench_scores

    return table(vbench_scores(study_of(folder), python or sys.executable))
