"""Programs as text and back; edits and their inverses; hunks one by one."""

import itertools

from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from physagent_studio.errors import ProgramError
from physagent_studio.program import apply, apply_with_inverse
from physagent_studio.program.text.diff import diff
from physagent_studio.program.text.document import dump_program, load_program
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
@given(programs, programs)
def test_a_diff_leads_from_one_program_to_the_other(before, after):
    hunks = diff(before, after)
    assert apply(before, [edit for hunk in hunks for edit in hunk.edits]) == after
    assert (not hunks) == (before == after)


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
