"""The prompts: text files beside this module, filled in a single pass."""

from __future__ import annotations

import re
from importlib.resources import files

_SLOT = re.compile(r"\{\{(\w+)\}\}")


def prompt(name: str, **values: str) -> str:
    """The prompt file `name` with its `{{slots}}` filled.

    One pass: a slot that stands in a filled-in text (a person's sentence) stays as it is.
    """
    text = (files("physagent_studio.agent.vlm") / "prompts" / f"{name}.md").read_text(
        encoding="utf-8"
    )
    wanted = set(_SLOT.findall(text))
    if wanted != set(values):
        raise KeyError(f"prompt {name} has the slots {sorted(wanted)}, not {sorted(values)}")
    return _SLOT.sub(lambda slot: values[slot[1]], text).strip()


def quoted(text: str) -> str:
    """A person's words or a picture's text, fenced, so that they read as data.

    The fence is stripped from the text itself, so nothing in it can close it early.
    """
    return f"<<<DATA\n{text.replace('<<<', '<').replace('>>>', '>').strip()}\nDATA>>>"
