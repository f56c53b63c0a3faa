"""Whatever a browser sends becomes a bounded value or a sentence, never anything else."""

from __future__ import annotations

import json
import math
import re
from importlib.resources import files
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_studio.errors import InputError
from physagent_studio.program import SetField
from physagent_studio.studio.commands import asking, read_letter
from physagent_studio.studio.commands.asking import Asked


def read(text: str) -> Asked:
    return read_letter(text)[0]


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ('{"do":"play"}', {"on": None, "once": False}),
        ('{"do":"scrub","frame":3,"seen":7}', {"frame": 3}),
        ('{"do":"step","all":true}', {"all": True}),
        ('{"do":"overrule","passed":true}', {"passed": True, "words": ""}),
        ('{"do":"round","id":null}', {"id": None}),
    ],
)
def test_what_is_known_comes_with_its_values(text: str, values: dict[str, Any]) -> None:
    assert read(text).form.model_dump() == values


def test_edits_are_the_programs_own_models() -> None:
    text = '{"do":"edit","edits":[{"op":"set","path":"a.b","value":[1,2,3]}],"ticket":4}'
    found = read(text)
    assert dict(found.form)["edits"] == (SetField(path="a.b", value=[1, 2, 3]),)
    assert found.ticket == 4


def test_a_page_that_presents_or_watches_is_told_what_it_may() -> None:
    may = {do: known.may for do, known in asking._KNOWN.items()}
    assert {do for do, one in may.items() if one == "follow"} == {"viewer", "look", "bookmark"}
    page = (files("physagent_studio.studio") / "pages/wire.js").read_text()
    listed = re.search(r"const LOOKING = new Set\((.+?)\)", page)
    assert listed is not None
    assert set(json.loads(listed[1])) == {do for do, one in may.items() if one != "change"}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "nonsense",
        "[1]",
        "null",
        "{}",
        '{"do":"format_disk"}',
        '{"do":"scrub","frame":-1}',
        '{"do":"scrub","frame":1e9}',
        '{"do":"scrub","frame":NaN}',
        '{"do":"scrub","frame":"NaN"}',
        '{"do":"speed","factor":Infinity}',
        '{"do":"speed","factor":1e9}',
        '{"do":"budget","rounds":1000000}',
        '{"do":"play","on":true,"update_cb":[]}',
        '{"do":"edit","edits":[{"op":"set","path":"a","value":NaN}]}',
        '{"do":"edit","edits":[{"op":"exec","path":"a"}]}',
        '{"do":"viewer","token":"../../etc"}',
        '{"do":"new","photo":"","prompt":"x","objects":[["a/b",[]]]}',
        "[" * 100_000,
        '{"do": "scrub", "frame": 1' + "0" * 10_000 + "}",
    ],
)
def test_refused_with_a_sentence(text: str) -> None:
    with pytest.raises(InputError) as refused:
        read(text)
    assert 5 < len(str(refused.value)) < 500


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=12), inner, max_size=4)
    ),
    max_leaves=12,
)
kinds = st.sampled_from(
    ["play", "scrub", "speed", "loop", "select", "show", "decide", "edit", "text", "budget", "new"]
)


@settings(max_examples=300, deadline=None)
@given(kind=kinds, rest=st.dictionaries(st.sampled_from(
    ["on", "frame", "factor", "start", "end", "kind", "name", "what", "edits", "text", "rounds",
     "proposal", "objects", "photo", "prompt"]), json_values, max_size=6))  # fmt: skip
def test_any_value_is_bounded_or_refused(kind: str, rest: dict[str, Any]) -> None:
    try:
        intent = read(json.dumps({"do": kind, **rest}))
    except InputError:
        return
    for number in _numbers(intent.form.model_dump(mode="json", exclude={"edits"})):
        assert math.isfinite(number)
        assert abs(number) <= 2**53


def _numbers(value: Any) -> list[float]:
    if isinstance(value, bool):
        return []
    if isinstance(value, int | float):
        return [value]
    if isinstance(value, dict):
        return [n for part in value.values() for n in _numbers(part)]
    return [n for part in value for n in _numbers(part)] if isinstance(value, list) else []


def test_likes_and_ground_lines_are_asked_for() -> None:
    for text in (
        '{"do": "like", "ticket": 1}',
        '{"do": "alike", "name": "domino", "boxes": [[1, 2, 30, 40]]}',
        '{"do": "hold", "name": "apple", "how": "hangs"}',
        '{"do": "ground", "name": "apple", "end": [3, 4]}',
        '{"do": "raise", "name": "apple", "height": 1.5}',
    ):
        assert read(text).do in text
    for text in (
        '{"do": "hold", "name": "apple", "how": "sinks"}',
        '{"do": "raise", "name": "apple", "height": -1}',
    ):
        with pytest.raises(InputError):
            read(text)
