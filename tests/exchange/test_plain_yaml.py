"""YAML as plain data, by the 1.2 rules, with lines, and bounded."""

from __future__ import annotations

import math

import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange.plain_yaml import read_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e3", 1000.0),
        ("12:30:45", "12:30:45"),
        ("no", "no"),
        ("0o17", "0o17"),
        ("010", 10),
        ("'1'", "1"),
        ("true", True),
        ("~", None),
        ("-.5", -0.5),
        ("2020-01-01", "2020-01-01"),
        ("[1, [2.5, x]]", [1, [2.5, "x"]]),
    ],
)
def test_scalars_have_no_surprises(text, value):
    found = read_yaml(f"a: {text}", "f.yaml").data["a"]
    assert found == value
    assert type(found) is type(value)


def test_special_floats_are_read_and_left_to_the_reader_of_numbers():
    data = read_yaml("[.nan, -.inf]", "f.yaml").data
    assert math.isnan(data[0])
    assert data[1] == -math.inf


def test_lines_of_places():
    document = read_yaml("a:\n  b:\n  - 1\n  - 2\nc: x\n", "f.yaml")
    assert document.line(("a", "b", 1)) == 4
    assert document.line(("c",)) == 5
    assert document.line(("a", "b", 7, "gone")) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\na: 2", r"f\.yaml, line 2: 'a' stands here twice"),
        ("a: [1", r"f\.yaml, line 1: this is no valid YAML"),
        ("? [1]\n: 2", r"line 1: a key must be plain text"),
        ("a: &x {b: 1}\nc:\n  <<: *x", r"line 3: a key must be plain text"),
        ("[" * 3000 + "]" * 3000, "nested too deeply"),
        ("a: \x00", "no valid YAML"),
        ("a: !!python/object:os.system {}", r"line 1: a tag"),
    ],
)
def test_refusals(text, message):
    with pytest.raises(InputError, match=message):
        read_yaml(text, "f.yaml")


def test_alias_bomb_is_refused():
    rows = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    rows += [f"a{i}: &a{i} [{', '.join(['*a' + str(i - 1)] * 10)}]" for i in range(1, 9)]
    with pytest.raises(InputError, match="too much"):
        read_yaml("\n".join(rows), "f.yaml")
