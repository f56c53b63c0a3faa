"""Programs as text: strict YAML in, readable YAML out, older versions brought up to this one.

Within a version fields are only added, and what a program does not say has its default: so far all
programs that were ever written are of version 1.
"""

import json
import re
from collections.abc import Callable, Mapping
from typing import Any

import yaml
from pydantic import ValidationError

from physagent_studio.errors import Problem, ProgramError
from physagent_studio.program.program import PhysicalProgram, unsigned_zeros
from physagent_studio.program.text.json_schema import Location, fields_at, json_schema, tags_at
from physagent_studio.program.text.problems import problems_of
from physagent_studio.program.text.yaml_nodes import Node, parse


def load_program(text: str) -> PhysicalProgram:
    """The program that a YAML text describes.

    Raises `ProgramError` with path, 1-based line and what is allowed for everything that is
    wrong. JSON is YAML, so a JSON text is read as well.
    """
    return program_of(parse(text))


def program_of(root: Node) -> PhysicalProgram:
    """The program of a parsed text."""
    data = root.plain()
    if not isinstance(data, dict):
        message = "a program is a mapping with scene, event, clip and contract"
        raise ProgramError((Problem("", message, "", root.line + 1),))
    return validate_data(data, root.lines())


def validate_data(data: Any, lines: Mapping[Location, int] | None = None) -> PhysicalProgram:
    """The program of plain data, taken strictly: no text for a number, no number for a word.

    Data of an older version is brought to the present one first.
    """
    data = brought_up(data, (lines or {}).get(("version",)))
    try:
        # Strict JSON mode: lists for tuples, whole numbers for floats, and nothing else bent.
        return PhysicalProgram.model_validate_json(json.dumps(_whole(data)), strict=True)
    except ValidationError as error:

        def fields(location: Location) -> tuple[str, ...]:
            return fields_at(location, data)

        def tags(location: Location) -> tuple[str, ...]:
            return tags_at(location, data)

        raise ProgramError(problems_of(error, data, lines, fields, tags)) from error


def _whole(data: Any) -> Any:
    """Plain data in which a number such as 1e3 is the whole number that it is, and −0 is 0."""
    if isinstance(data, dict):
        return {key: _whole(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_whole(value) for value in data]
    if isinstance(data, float) and data.is_integer() and abs(data) < 2**53:
        return int(data)
    return data


# --- writing ----------------------------------------------------------------------------------

_FIRST = ("version", "id", "name", "kind", "operator")
_KEPT = {"version", "kind", "operator", "start_step", "duration", "clip"}
_FLOW_WIDTH = 88
_CORE_WORDS = re.compile(
    # What this reader, or one that follows YAML 1.1, takes for something other than a word.
    r"""^(?:~|null|Null|NULL|true|True|TRUE|false|False|FALSE
    |yes|Yes|YES|no|No|NO|on|On|ON|off|Off|OFF
    |[-+]?[0-9][0-9_.,:eExXoO+-]*|[-+]?\.[0-9][0-9eE+-]*|0[xXoO][0-9a-fA-F_]+
    |[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)|=|<<)$""",
    re.VERBOSE,
)

_OTHER_BREAKS = re.compile("[\r\x85\u2028\u2029]")
"""Line breaks that a reader would turn into something else."""


def dump_program(program: PhysicalProgram) -> str:
    """A readable YAML text; `load_program` gives the same program back.

    Defaults are left out but for those that say what a thing is or when it acts.
    """
    data = unsigned_zeros(_trimmed(program.model_dump(mode="json"), program))
    ordered = {key: data.get(key, {}) for key in ("version", "clip", "scene", "event", "contract")}
    kept = {key: value for key, value in ordered.items() if value not in ({}, [])}
    return "".join(dump_entry(key, value) for key, value in kept.items())


def dump_value(value: Any) -> str:
    """Block YAML of plain data, small collections in flow style, ending with a newline."""
    text = yaml.dump(
        value,
        Dumper=_Dumper,
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=False,
        width=10**9,
    )
    # The end mark that follows a bare scalar.
    return text[:-4] if text.endswith("\n...\n") else text


def dump_entry(key: str, value: Any) -> str:
    """Block YAML of one key with its value, ending with a newline."""
    text = dump_value(value)
    if isinstance(value, dict) and not _is_small(value):
        text = "".join(f"  {line}\n" for line in text.splitlines())
    between = "\n" if isinstance(value, dict | list) and not _is_small(value) else " "
    return f"{dump_flow(key)}:{between}{text}"


def dump_flow(value: Any) -> str:
    """Flow YAML of plain data, for a place inside a line."""
    text = yaml.dump(
        [value],
        Dumper=_FlowDumper,
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=True,
        width=10**9,
    )
    return text.strip()[1:-1]


def _trimmed(data: Any, model: Any) -> Any:
    """Dumped data without what is left at its default, what names a thing first."""
    if isinstance(data, list):
        return [_trimmed(item, part) for item, part in zip(data, model, strict=True)]
    if not isinstance(data, dict) or not hasattr(type(model), "model_fields"):
        return data
    kept: dict[str, Any] = {}
    fields = type(model).model_fields
    for key in sorted(data, key=lambda name: _FIRST.index(name) if name in _FIRST else 99):
        value = getattr(model, key)
        if key in _KEPT or fields[key].is_required() or value != fields[key].default:
            kept[key] = _trimmed(data[key], value)
    return kept


class _Dumper(yaml.SafeDumper):
    """Our own scalars and flow style; no aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


# The resolvers of YAML 1.1 go; a plain word is one that the reader takes for a word.
_Dumper.yaml_implicit_resolvers = {}
_Dumper.add_implicit_resolver("tag:physagent:not-a-word", _CORE_WORDS, None)


def _string(dumper: yaml.SafeDumper, value: str) -> yaml.ScalarNode:
    style = None
    if not value or _CORE_WORDS.match(value):
        style = "'"
    elif _OTHER_BREAKS.search(value):
        style = '"'
    elif "\n" in value:
        style = "|"
    return dumper.represent_scalar("tag:yaml.org,2002:str", value, style=style)


def _plain_scalar(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    # The tag of the resolver above, so that the emitter writes it without quotes or tag.
    return dumper.represent_scalar("tag:physagent:not-a-word", text)


def _mapping(dumper: yaml.SafeDumper, value: dict[str, Any]) -> yaml.MappingNode:
    return dumper.represent_mapping(
        "tag:yaml.org,2002:map", value.items(), flow_style=_is_small(value)
    )


def _sequence(dumper: yaml.SafeDumper, value: list[Any]) -> yaml.SequenceNode:
    return dumper.represent_sequence("tag:yaml.org,2002:seq", value, flow_style=_is_small(value))


def _is_small(value: Any) -> bool:
    """Whether a collection fits on a line and holds nothing deep."""
    if not value:
        return True
    if isinstance(value, dict) and ("id" in value or "name" in value):
        return False
    return _depth(value) <= 3 and len(repr(value)) <= _FLOW_WIDTH and not _has_text(value)


def _depth(value: Any) -> int:
    if isinstance(value, dict):
        return 1 + max((_depth(part) for part in value.values()), default=0)
    if isinstance(value, list):
        return 1 + max((_depth(part) for part in value), default=0)
    return 0


def _has_text(value: Any) -> bool:
    """Whether it holds a string that is more than a word."""
    if isinstance(value, dict):
        return any(_has_text(part) for part in value.values())
    if isinstance(value, list):
        return any(_has_text(part) for part in value)
    return isinstance(value, str) and not re.fullmatch(r"[\w\-]{0,64}", value)


_Dumper.add_representer(str, _string)
_Dumper.add_representer(float, lambda dumper, value: _plain_scalar(dumper, repr(value)))
_Dumper.add_representer(int, lambda dumper, value: _plain_scalar(dumper, str(value)))
_Dumper.add_representer(
    bool, lambda dumper, value: _plain_scalar(dumper, "true" if value else "false")
)
_Dumper.add_representer(type(None), lambda dumper, _: _plain_scalar(dumper, "null"))
_Dumper.add_representer(dict, _mapping)
_Dumper.add_representer(list, _sequence)


class _FlowDumper(_Dumper):
    """Everything in flow style."""


_FlowDumper.add_representer(
    dict,
    lambda dumper, value: dumper.represent_mapping(
        "tag:yaml.org,2002:map", value.items(), flow_style=True
    ),
)
_FlowDumper.add_representer(
    list,
    lambda dumper, value: dumper.represent_sequence(
        "tag:yaml.org,2002:seq", value, flow_style=True
    ),
)


VERSION = 1
FROM: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""By version: plain data of a program of the next one."""


def brought_up(data: Any, line: int | None = None) -> Any:
    """Plain data of the present version; what is no program of an older one is left as it is.

    line: where its text names the version. Raises ProgramError for a program of a newer version.
    """
    version = data.get("version", VERSION) if isinstance(data, dict) else VERSION
    if type(version) is not int:
        return data
    if version > VERSION:
        message = f"the program is of version {version}, which a newer physagent has written"
        raise ProgramError((Problem("version", message, f"1 … {VERSION}", line),))
    while version < VERSION and version in FROM:
        data = FROM[version](data) | {"version": version + 1}
        version += 1
    return data
