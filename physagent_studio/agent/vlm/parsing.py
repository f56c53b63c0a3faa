"""A model's reply as JSON: bounded, no NaN, no doubled keys, prose around it forgiven."""

from __future__ import annotations

import json
import re
from typing import Any

from physagent_studio.agent.vlm.failures import Invalid

MOST_CHARACTERS = 400_000
_FENCE = re.compile(r"```[a-zA-Z]*\s*\n(.*?)```", re.DOTALL)


def parse_object(text: str) -> dict[str, Any]:
    """The JSON object in a reply; raises `Invalid` with what is wrong and where."""
    if len(text) > MOST_CHARACTERS:
        raise Invalid(f"the reply has {len(text)} characters; at most {MOST_CHARACTERS} are read")
    if not text.strip():
        raise Invalid("the reply is empty; one JSON object is wanted")
    try:
        data = _decoded(text)
    except RecursionError:
        raise Invalid("the reply is nested too deeply") from None
    if not isinstance(data, dict):
        raise Invalid(f"the reply is a JSON {type(data).__name__}; one JSON object is wanted")
    return data


def _decoded(text: str) -> Any:
    decoder = json.JSONDecoder(parse_constant=_no_constant, object_pairs_hook=_no_doubles)
    body = text.strip()
    fenced = _FENCE.search(body)
    if not body.startswith("{") and fenced:
        body = fenced.group(1).strip()
    start = body.find("{")
    if start < 0:
        raise Invalid("the reply holds no JSON object; answer with one JSON object and no prose")
    try:
        return decoder.raw_decode(body, start)[0]
    except json.JSONDecodeError as error:
        raise Invalid(
            f"the reply is not valid JSON: {error.msg} at line {error.lineno}, "
            f"column {error.colno}; perhaps it was cut off"
        ) from None
    except ValueError as error:
        # Numbers with thousands of digits.
        raise Invalid(f"the reply is not valid JSON: {str(error)[:200]}") from None


def _no_constant(name: str) -> Any:
    raise Invalid(f"{name} is not a number in JSON; every number is finite")


def _no_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise Invalid(f"the key '{key[:60]}' stands twice in one object")
        found[key] = value
    return found
