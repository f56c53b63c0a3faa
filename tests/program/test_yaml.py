"""YAML 1.2 without surprises."""

import pytest

from physagent_studio.errors import ProgramError
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import dump_flow, dump_program, dump_value, load_program
from physagent_studio.program.text.yaml_nodes import MAX_CHARACTERS, parse


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"),
        ("on", "on"),
        ("yes", "yes"),
        ("12:30:45", "12:30:45"),
        ("2001-01-01", "2001-01-01"),
        ("0x1F", "0x1F"),
        ("0o17", "0o17"),
        ("1_000", "1_000"),
        ("1e3", 1000.0),
        ("-.5", -0.5),
        ("+3", 3),
        ("3.", 3.0),
        ("0", 0),
        ("-0", 0),
        ("true", True),
        ("null", None),
        ("~", None),
        ("", None),
        ("'null'", "null"),
        ("'1'", "1"),
    ],
)
def test_what_a_plain_word_means(text, value):
    found = parse(f"a: {text}\n").plain()
    assert found == {"a": value}
    assert isinstance(found, dict)
    assert type(found["a"]) is type(value)


WORDS = ["no", "1e3", "007", "12:30", "0x1", "null", "~", "", ".inf", "-", "a: b", "# x", " x", "é"]


@pytest.mark.parametrize("word", WORDS)
def test_words_come_back_as_words(word):
    for dumped in (dump_value({"a": word}), f"{{a: {dump_flow(word)}}}"):
        assert parse(dumped).plain() == {"a": word}


@pytest.mark.parametrize("number", [0.1, 1e-7, 1e22, -1.5e-300, 123456789.123456789, 3, -0.0])
def test_numbers_come_back_to_the_bit(number):
    assert parse(dump_value({"a": number})).plain() == {"a": number}


def test_size_is_bounded_before_anything_is_read():
    with pytest.raises(ProgramError, match="characters"):
        parse("#" * (MAX_CHARACTERS + 1))


def test_an_alias_bomb_is_refused_at_once():
    bomb = "a: &a [x, x]\n" + "\n".join(f"{c}: &{c} [*a, *a]" for c in "bcdefgh")
    with pytest.raises(ProgramError, match="anchors and aliases"):
        parse(bomb)


def test_json_is_read_as_well():
    program = PhysicalProgram()
    assert load_program(program.model_dump_json()) == program


def test_defaults_are_left_out_and_read_back():
    text = dump_program(PhysicalProgram())
    assert text.startswith("version: 1\n")
    assert load_program(text) == PhysicalProgram()
