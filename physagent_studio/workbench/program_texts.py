"""Programs as text from strangers: a long one is parsed in a limited process."""

from physagent_studio.errors import InputError
from physagent_studio.jobs import Limits, within
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program

HARMLESS = 20_000
"""Characters that are parsed here and now, in a fifth of a second."""
MAX_PARTS = 30_000
"""Lines and commas of a text; each costs the parser some 30 µs, and a hundred things have 3,000."""
LIMITS = Limits(seconds=0.9, memory=192 * 2**20)
"""What parsing may take; a program of a hundred things takes a third of it."""


def read_program(text: str) -> PhysicalProgram:
    """`load_program` under limits; raises `ProgramError`, or `InputError` at a limit."""
    if len(text) <= HARMLESS:
        return load_program(text)
    if text.count("\n") + text.count(",") > MAX_PARTS:
        raise InputError(f"the program is too long (at most {MAX_PARTS} lines and list entries)")
    return within(LIMITS, "the program cannot be read", load_program, text)
