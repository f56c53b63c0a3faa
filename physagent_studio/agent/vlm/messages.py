"""What is said to a model, what comes back and what can go wrong, whatever the wire format."""

from __future__ import annotations

import functools
import hashlib
import json
import re
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any, Literal

from physagent_studio.errors import StudioError
from physagent_studio.records import Image


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture in a message. pixels: (H, W, 3) uint8 RGB."""

    pixels: Image
    label: str

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of shape and pixels, so that it does not depend on an encoder's version."""
        head = json.dumps(self.pixels.shape).encode()
        return hashlib.sha256(head + self.pixels.tobytes()).hexdigest()


Part = str | Picture


@dataclass(frozen=True, eq=False, slots=True)
class Turn:
    """One message of the conversation."""

    role: Literal["system", "user", "assistant"]
    parts: tuple[Part, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Question:
    """A conversation that wants a reply of a certain form.

    purpose: what it is for, such as `planner.propose`. schema: JSON Schema of the reply.
    """

    purpose: str
    turns: tuple[Turn, ...]
    form: str
    schema: dict[str, Any]

    def key(self, model: str, *, pictures: bool = True) -> str:
        """SHA-256 of everything that is said; without pictures, of the words alone."""
        turns = [
            [turn.role, [_said(part) for part in turn.parts if pictures or isinstance(part, str)]]
            for turn in self.turns
        ]
        content = [model, self.form, self.schema, turns, pictures]
        text = json.dumps(content, sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()

    def again(self, answer: str, problem: str) -> Question:
        """The same question after a reply that was not accepted, with the reason."""
        turns = (*self.turns, Turn("assistant", (answer,)), Turn("user", (problem,)))
        return Question(self.purpose, turns, self.form, self.schema)


def _said(part: Part) -> list[str]:
    return ["text", part] if isinstance(part, str) else ["picture", part.label, part.digest]


@dataclass(frozen=True, slots=True)
class Usage:
    """Tokens of one call; estimated: the server did not say."""

    input: int = 0
    output: int = 0
    estimated: bool = False


@dataclass(frozen=True, slots=True)
class Answer:
    """A reply. finish: the server's finish_reason. refusal: its words where it refused."""

    text: str
    finish: str = "stop"
    refusal: str = ""
    usage: Usage = field(default_factory=Usage)


class VlmError(StudioError):
    """Root: the model gave nothing that can be used. The roles turn it into a legal outcome."""


class BudgetSpent(VlmError):
    """A limit on calls, tokens or money is reached; nothing more is sent."""


class Unreachable(VlmError):
    """The server cannot be reached, refuses the request, or keeps failing after the retries."""


class NoAnswer(VlmError):
    """The model was asked again as often as is allowed and its reply is still not valid."""


class TapeMiss(VlmError):
    """Replaying, and this call was not recorded."""


class Invalid(VlmError):
    """One reply that is not accepted; `str(error)` is the exact message the model gets back."""


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
