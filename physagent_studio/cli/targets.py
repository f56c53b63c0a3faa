"""What a word on the command line means: a case, a session, a program or an image."""

from dataclasses import replace
from pathlib import Path

from physagent_studio.cli.early import IMAGES, there
from physagent_studio.cli.marks import parse_objects
from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case
from physagent_studio.exchange.case_clicks import too_far
from physagent_studio.reconstruction import reduction_of
from physagent_studio.records import Case
from physagent_studio.workbench.naming import case_in_words, with_proposals

PROGRAMS = (".yaml", ".yml")


def case_of(
    target: str, event: str | None, prompt: str, objects: tuple[str, ...], *, ask: bool = True
) -> Case:
    """The case in a folder, or around an image; unclicked things are found by their words.

    ask: raise `Unclear` where it is not clear where one is; otherwise the likeliest place counts.
    """
    path = Path(target)
    there(path, "a case folder or an image")
    if path.is_dir() or path.name in ("case.yaml", "case.yml"):
        for option, given in (("--object", objects), ("--prompt", prompt.strip())):
            if given:
                raise InputError(
                    f"{option} goes with an image; the case {target} has its own: write them into"
                    " its case.yaml, or give its picture"
                )
        return with_proposals(load_case(path, event), ask=ask)
    if path.suffix.lower() in PROGRAMS:
        raise InputError(f"{target} is a program; use `physagent simulate` or `physagent studio`")
    if path.suffix.lower() not in IMAGES:
        raise InputError(f"{target} is neither a case folder nor a picture ({', '.join(IMAGES)})")
    if not prompt.strip():
        raise InputError('an image needs the event in words: --prompt "the ball falls"')
    return case_in_words(path, prompt, parse_objects(objects), ask=ask)


def with_horizon(case: Case, target: str, row: float | None) -> Case:
    """The case with the row of its horizon as `--horizon` says it, in pixels of the file."""
    if row is None:
        return case
    if case.image is None:
        raise InputError(f"--horizon goes with a photo; {target} has none")
    reduced = reduction_of(target) if Path(target).suffix.lower() in IMAGES else 1
    height = case.image.shape[0]
    if too_far(row / reduced, height):
        last = round(height * reduced) - 1
        raise InputError(
            f"--horizon {row:g} is too far from the picture, whose rows are 0 to {last}; "
            "ten heights above or below its middle are allowed"
        )
    return replace(case, horizon=row / reduced, roll=0.0)
