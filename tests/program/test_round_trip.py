"""Programs as text and back; edits and their inverses; hunks one by one."""

import difflib
import itertools
import re

from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from physagent_studio.errors import ProgramError
from physagent_studio.program import AddItem, MoveItem, apply, apply_with_inverse
from physagent_studio.program.text.diff import diff, diff_text
from physagent_studio.program.text.document import dump_program, load_program
from physagent_studio.program.text.text_edits import edit_text
from physagent_studio.program.text.yaml_nodes import parse
from tests.program.strategies import edits_of, programs

# Shrinking a program can take minutes; drop `phases` to look into a failure.
few = settings(max_examples=30, deadline=None, derandomize=True, phases=[Phase.generate])


@few
@given(programs)
def test_parsing_what_was_dumped_gives_the_same_program(program):
    text = dump_program(program)
    again = load_program(text)
    assert again == program
    assert again.hash == program.hash
    assert dump_program(again) == text


@few
@given(st.data())
def test_an_edit_and_its_inverse_lead_back(data):
    program = data.draw(programs)
    edits = []
    current = program
    for _ in range(data.draw(st.integers(1, 3))):
        edit = data.draw(edits_of(current))
        try:
            current = apply(current, [edit])
        except ProgramError:
            continue  # a second newcomer of the same name
        edits.append(edit)
    edited, inverse = apply_with_inverse(program, edits)
    assert edited == current
    assert apply(edited, inverse) == program


@few
@given(st.data())
def test_an_edit_of_a_text_changes_only_the_lines_it_concerns(data):
    program = data.draw(programs)
    text = commented(dump_program(program))
    assert load_program(text) == program
    edit = data.draw(edits_of(program))
    try:
        expected = apply(program, [edit])
    except ProgramError:
        return
    after = edit_text(text, [edit])
    assert load_program(after) == expected
    rows, left = text.split("\n"), set(after.split("\n"))
    first, last = concerned(text, edit)
    lost = [row for row in rows if "#c" in row and row not in left]
    assert not [row for row in lost if not first <= rows.index(row) <= last]
    kept = difflib.SequenceMatcher(None, rows, after.split("\n"), autojunk=False)
    changed = len(rows) - sum(block.size for block in kept.get_matching_blocks())
    moved = 0 if not isinstance(edit, MoveItem) else len(rows)
    assert changed <= last - first + 1 + moved


def commented(text: str) -> str:
    """A comment line of its own above each line with a key, but for blocks of running text."""
    if "|" in text:
        return text
    rows = []
    for number, row in enumerate(text.split("\n")):
        if re.match(r"\s*(- )?\w+:", row):
            indent = len(row) - len(row.lstrip())
            rows.append(f"{' ' * indent}#c{number}")
        rows.append(row)
    return "\n".join(rows)


def concerned(text: str, edit) -> tuple[int, int]:
    """First and last 0-based line that an edit may change: those of the value or item named, or
    of the flow collection or empty list around a new one.
    """
    node, missing = parse(text), False
    for part in edit.path.split("."):
        below = _part(node, part)
        missing = below is None
        if below is None:
            break
        node = below
    grown = isinstance(edit, AddItem) or missing
    if grown and not node.flow and node.children:
        return (0, -1)  # it only gains lines
    first = text.count("\n", 0, node.start)
    # The dash or key may stand on an earlier line than its value.
    return (first - 2, text.count("\n", 0, max(node.end - 1, node.start)))


def _part(node, part: str):
    if node.kind == "mapping":
        return node.get(part)
    for child in node.children:
        label = (child.get("id") or child.get("name")) if child.kind == "mapping" else None
        if label is not None and label.value == part:
            return child
    if node.kind == "sequence" and part.isdecimal() and int(part) < len(node.children):
        return node.children[int(part)]
    return None


@few
@given(programs, programs)
def test_a_diff_leads_from_one_program_to_the_other(before, after):
    hunks = diff(before, after)
    assert apply(before, [edit for hunk in hunks for edit in hunk.edits]) == after
    assert (not hunks) == (before == after)
    assert (diff_text(before, after) == "no change\n") == (before == after)


@few
@given(st.data())
def test_any_part_of_independent_hunks_applies(data):
    program = data.draw(programs)
    after = program
    for _ in range(3):
        try:
            after = apply(after, [data.draw(edits_of(after))])
        except ProgramError:
            continue
    hunks = diff(program, after)
    # An action on a newcomer needs the newcomer; all else is independent.
    names = {one.name for one in program.scene.objects}
    if any(one.name not in names for one in after.event.actions):
        return
    for count in range(len(hunks) + 1):
        for part in itertools.islice(itertools.combinations(hunks, count), 8):
            apply(program, [edit for hunk in part for edit in hunk.edits])
