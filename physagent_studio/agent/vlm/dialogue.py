"""Asks until a reply is valid: the model gets the exact message back, at most twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from physagent_studio.agent.vlm.failures import Invalid, NoAnswer
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Answer, Question, Turn
from physagent_studio.agent.vlm.parsing import parse_object
from physagent_studio.agent.vlm.prompting import prompt
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
