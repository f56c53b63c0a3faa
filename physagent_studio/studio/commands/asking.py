"""What a browser may ask for: the studio's only door in.

Each is a function whose first two parameters are the studio and the browser's number; the others,
with their types and bounds, are the closed form that a message has to have. Whatever arrives is
text from a stranger: `read_letter` gives values of which every number is finite and inside its
bounds, or an `InputError` with a sentence.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, TypeVar, get_type_hints

from pydantic import BaseModel, Field, JsonValue, ValidationError, create_model

from physagent_studio.errors import InputError
from physagent_studio.program import Edit, Frozen

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

Id = Annotated[str, Field(min_length=1, max_length=200)]
Label = Annotated[str, Field(max_length=200)]
Frame = Annotated[int, Field(ge=0, le=10_000)]
Edits = Annotated[tuple[Edit, ...], Field(max_length=1000)]
Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]
Vector = tuple[Coordinate, Coordinate, Coordinate]
FieldPath = Annotated[str, Field(min_length=1, max_length=500)]
Ticket = Annotated[int, Field(ge=0, le=2**53)]
"""Comes back with the answer, so that the page knows what it is about."""
FileText = Annotated[str, Field(max_length=23_000_000)]
"""A file in base64."""

Act = TypeVar("Act", bound=Callable[..., None])
May = Literal["change", "look", "follow"]
"""Who may ask: what is to `look` a page that presents, what is to `follow` any viewer as well."""


@dataclass(frozen=True, slots=True)
class _Known:
    act: Callable[..., None]
    form: type[BaseModel]
    may: May


_KNOWN: dict[str, _Known] = {}


def asked(do: str, may: May = "change") -> Callable[[Act], Act]:
    """Has a function carried out for messages with that `do`."""

    def register(act: Act) -> Act:
        _KNOWN[do] = _Known(act, _form_of(act, 2), may)
        return act

    return register


def posted(do: str, command: type, may: May = "change") -> None:
    """Has a command of the workbench posted for such messages: its fields are their form."""

    def post(studio: Studio, browser: int, **values: Any) -> None:
        studio.workbench.post(command(**values))

    _KNOWN[do] = _Known(post, _form_of(command, 0), may)


def _form_of(act: Callable[..., Any], first: int) -> type[BaseModel]:
    hints = get_type_hints(act, localns={"Studio": object}, include_extras=True)
    fields: dict[str, Any] = {
        one.name: (hints[one.name], ... if one.default is one.empty else one.default)
        for one in list(inspect.signature(act).parameters.values())[first:]
    }
    return create_model(act.__name__, __base__=Frozen, **fields)


@dataclass(frozen=True, slots=True)
class Asked:
    """What one message asks for; values: as its form has them."""

    do: str
    may: May
    form: BaseModel

    @property
    def ticket(self) -> int | None:
        """The ticket that it carries."""
        return getattr(self.form, "ticket", None)

    def carry_out(self, studio: Studio, browser: int) -> None:
        """Does it; an `InputError` says why not."""
        values = {name: getattr(self.form, name) for name in type(self.form).model_fields}
        _KNOWN[self.do].act(studio, browser, **values)


def read_letter(text: str) -> tuple[Asked, int | None]:
    """What a browser's message asks, and the version of the document that it was made against.

    Raises:
        InputError: it is no JSON, not finite, out of bounds, or nothing that may be asked for.
    """
    try:
        data: JsonValue = _DECODER.decode(text)
        if not isinstance(data, dict):
            raise InputError("the page sent something that is no question")
        do, seen = data.pop("do", None), data.pop("seen", None)
        known = _KNOWN.get(do) if isinstance(do, str) else None
        if known is None:
            raise InputError(f"nothing here does '{str(do)[:80]}'")
        found = Asked(str(do), known.may, known.form.model_validate(data))
        return found, seen if type(seen) is int else None
    except ValidationError as error:
        raise InputError(_sentence(error)) from error
    except (ValueError, RecursionError) as error:
        raise InputError("the page sent something that is not JSON") from error


def _refuse_constant(name: str) -> NoReturn:
    raise InputError(f"{name} is not a number that can be used; give a finite number")


_DECODER = json.JSONDecoder(parse_constant=_refuse_constant)
"""One for all messages: a new one for each leaves names behind in the interpreter's own cache."""


def _sentence(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    where = ".".join(str(part) for part in first["loc"])
    text = first["msg"].removeprefix("Value error, ")
    return f"{where}: {text[0].lower()}{text[1:]}" if where else text
