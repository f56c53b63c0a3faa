"""What a word on the command line means: a case, a session, a program or an image."""

from __future__ import annotations

import math
from pathlib import Path

from physagent_studio.errors import InputError
from physagent_studio.exchange import load_case
from physagent_studio.program import Click
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


def parse_objects(words: tuple[str, ...]) -> dict[str, tuple[Click, ...]]:
    """`name@x,y` (inside) and `name@x,y,0` (outside) to clicks per name; `name` alone has none."""
    clicks: dict[str, tuple[Click, ...]] = {}
    for word in words:
        if "@" not in word and word.strip():
            clicks.setdefault("_".join(word.split()), ())
            continue
        name, _, place = word.rpartition("@")
        numbers = place.split(",")
        try:
            x, y = float(numbers[0]), float(numbers[1])
            label = int(numbers[2]) if len(numbers) > 2 else 1
        except (ValueError, IndexError):
            raise _bad_object(word) from None
        if not name.strip() or label not in (0, 1) or not math.isfinite(x + y):
            raise _bad_object(word)
        key = "_".join(name.split())
        clicks[key] = (*clicks.get(key, ()), Click(x=x, y=y, label=1 if label else 0))
    return clicks


def _bad_object(word: str) -> InputError:
    return InputError(
        f'--object "{word}" is not of the form "name@x,y" with x and y in pixels, or a name alone'
    )
