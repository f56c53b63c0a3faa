"""What a word on the command line means: a case, a session, a program or an image."""

from __future__ import annotations

import math
from pathlib import Path

from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case
from physagent_studio.program import Click, Grounding
from physagent_studio.records import Case
from physagent_studio.session import Store
from physagent_studio.workbench.engine import AgentName
from physagent_studio.workbench.naming import case_in_words, with_proposals

IMAGES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
PROGRAMS = (".yaml", ".yml")


def agent_name(word: str) -> AgentName:
    """The agent that the word names."""
    if word == "rules" or word == "vlm":
        return word
    raise InputError(f"--agent {word} is not known (rules, vlm)")


def is_session(target: str, store: Store) -> bool:
    """Whether the word names a session rather than something on the disk."""
    path = Path(target)
    return not path.exists() and not path.suffix and "/" not in target


def case_of(
    target: str, event: str | None, prompt: str, objects: tuple[str, ...], *, ask: bool = True
) -> Case:
    """The case in a folder, or around an image; unclicked things are found by their words.

    ask: raise `Unclear` where it is not clear where one is; otherwise the likeliest place counts.
    """
    path = Path(target)
    if not path.exists():
        raise InputError(f"{target} does not exist (a case folder or an image is needed)")
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


def parse_objects(words: tuple[str, ...]) -> dict[str, Grounding]:
    """What each name is tied to: `name@x,y` a click inside the thing, `name@x,y,0` one outside,
    `name@x0,y0,x1,y1` a box around it, and `name` alone nothing."""
    marks: dict[str, Grounding] = {}
    for word in words:
        name, at, place = word.rpartition("@") if "@" in word else (word, "", "")
        key = "_".join(name.split())
        if not key:
            raise _bad_object(word)
        said = marks.get(key, Grounding())
        marks[key] = _with_mark(said, word, place) if at else said
    return marks


def _with_mark(said: Grounding, word: str, place: str) -> Grounding:
    """The grounding with a word's two to four numbers added. Raises InputError for any others."""
    try:
        numbers = [float(one) for one in place.split(",")]
        if len(numbers) == 4:
            if said.box is not None:
                raise InputError(f'--object "{word}" is a second box for one thing; it takes one')
            return Grounding(points=said.points, box=_corners(word, numbers))
        x, y, label = numbers if len(numbers) == 3 else (*numbers, 1.0)
        click = Click.model_validate({"x": x, "y": y, "label": int(label)})
        if label != click.label:
            raise ValueError(label)
    except (ValueError, OverflowError):
        raise _bad_object(word) from None
    return Grounding(points=(*said.points, click), box=said.box)


def _corners(word: str, numbers: list[float]) -> tuple[float, float, float, float]:
    """A box from any two opposite corners: left, top, right, bottom, pixels."""
    if not all(math.isfinite(one) for one in numbers):
        raise ValueError(numbers)
    left, right = sorted(numbers[::2])
    top, bottom = sorted(numbers[1::2])
    if left == right or top == bottom:
        raise InputError(
            f'--object "{word}" is an empty box, {right - left:g} px wide and {bottom - top:g} px'
            " high; its two corners must differ in x and in y"
        )
    return left, top, right, bottom


def _bad_object(word: str) -> InputError:
    return InputError(
        f'--object "{word}" is not of the form "name@x,y" (a click) or "name@x0,y0,x1,y1" (two'
        " corners of a box) in pixels, or a name alone"
    )
