"""`physagent study`: serves the page of a study until it is interrupted, then says what came out."""

from __future__ import annotations

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
