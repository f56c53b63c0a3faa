"""YAML as plain data with lines; the rules are those of programs."""

from __future__ import annotations

import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange.plain_yaml import read_yaml


def test_lines_of_places():
    document = read_yaml("a:\n  b:\n  - 1\n  - 2\nc: x\n", "f.yaml")
    assert document.line(("a", "b", 1)) == 4
    assert document.line(("c",)) == 5
    assert document.line(("a", "b", 7, "gone")) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\na: 2", r"f\.yaml, line 2: the key is given twice"),
        ("a: [1", r"f\.yaml, line 1: is not valid YAML"),
        ("? [1]\n: 2", r"line 1: a key must be a word"),
        ("a: &x {b: 1}\nc:\n  <<: *x", r"line 1: anchors and aliases are not allowed"),
        ("[" * 3000 + "]" * 3000, "nested too deeply"),
        ("a: \x00", r"line 1: holds a character"),
        ("a: !!python/object:os.system {}", r"line 1: tags are not allowed"),
        ("a: .inf", r"line 1: \.inf is not a finite number"),
    ],
)
def test_refusals(text, message):
    with pytest.raises(InputError, match=message):
        read_yaml(text, "f.yaml")
