"""Reading what the command line is given; light, so that `validate` answers at once."""

from pathlib import Path

from physagent_studio.errors import InputError, ProgramError
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program

MAX_PROGRAM_BYTES = 4_000_000


def read_program(path: Path) -> PhysicalProgram:
    """The program in a file."""
    try:
        if path.stat().st_size > MAX_PROGRAM_BYTES:
            raise InputError(f"{path} is larger than {MAX_PROGRAM_BYTES // 1_000_000} MB")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not UTF-8 text (byte {error.start})") from error
    try:
        return load_program(text)
    except ProgramError as error:
        raise ProgramError(error.problems, source=str(path)) from None
