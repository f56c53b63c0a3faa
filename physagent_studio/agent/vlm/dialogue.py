"""Asks until a reply is valid JSON: the model gets the exact message back, at most twice."""

import json
import re
from collections.abc import Callable
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Answer, Invalid, NoAnswer, Question, Turn, prompt
from physagent_studio.agent.vlm.schema import strict_schema, without_nulls
from physagent_studio.errors import ProgramError
from physagent_studio.program.text.problems import problems_of

Form = TypeVar("Form", bound=BaseModel)
Result = TypeVar("Result")
AGAIN = 2
"""How often the model is asked again after a reply that was not accepted."""

MOST_QUOTED = 20_000
MOST_PROBLEMS = 20


def converse(
    line: Line,
    purpose: str,
    turns: tuple[Turn, ...],
    form: type[Form],
    check: Callable[[Form], Result],
) -> Result:
    """What `check` makes of the first valid reply.

    check: turns the reply into what is wanted; raises `Invalid` or `ProgramError` with the
    message that the model shall read.

    Raises:
        NoAnswer: no reply was valid; carries the last problem.
        VlmError: nothing can be sent, or nothing comes back.
        Cancelled: the person cancelled.
    """
    question = Question(purpose, turns, form.__name__, strict_schema(form))
    problem = ""
    for _ in range(AGAIN + 1):
        answer = Answer("")
        try:
            answer = line.ask(question)
            return check(_read(answer, form))
        except Invalid as error:
            problem = str(error)
        except ProgramError as error:
            problem = _listed([str(item) for item in error.problems] or [str(error)])
        said = (answer.text or answer.refusal)[:MOST_QUOTED] or "(nothing)"
        question = question.again(said, prompt("again", problem=problem))
    raise NoAnswer(f"no valid reply to {purpose} after {AGAIN + 1} attempts: {problem}")


def _read(answer: Answer, form: type[Form]) -> Form:
    if answer.refusal:
        raise Invalid(f"the request was refused: {answer.refusal[:300]}")
    if answer.finish == "content_filter":
        raise Invalid("the reply was withheld by the server's content filter")
    if answer.finish == "length":
        raise Invalid("the reply was cut off at the token limit; answer more briefly")
    data = without_nulls(parse_object(answer.text), form)
    try:
        return form.model_validate(data)
    except ValidationError as error:
        raise Invalid(_listed([str(item) for item in problems_of(error, data)])) from None


def _listed(problems: list[str]) -> str:
    shown = "\n".join(f"- {text}" for text in problems[:MOST_PROBLEMS])
    left = len(problems) - MOST_PROBLEMS
    return shown + (f"\n- and {left} more" if left > 0 else "")


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
