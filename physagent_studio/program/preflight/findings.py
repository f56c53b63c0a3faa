"""What preflight says: a reason and a suggested edit for each finding."""

from __future__ import annotations

from typing import Literal

from physagent_studio.program.base import Frozen
from physagent_studio.program.edits import Edit

Code = Literal[
    "fixed_target", "past_end", "below_friction", "contradiction", "overlapping", "collision",
    "in_the_air", "not_on_support", "tunnelling", "cannot_act", "never_starts",
    "implausible_density", "implausible_size", "implausible_speed", "no_effect", "untestable",
    "unplaced",
]  # fmt: skip


class PreflightFinding(Frozen):
    """Something that will probably not do what was meant.

    path: the field it is about. message: what is wrong and why, in a sentence with figures.
    edits: a suggestion that settles it; empty where only a person can know what was meant.
    """

    code: Code
    path: str
    message: str
    edits: tuple[Edit, ...] = ()


def finding(code: Code, path: str, message: str, edits: tuple[Edit, ...]) -> PreflightFinding:
    """The finding with its parts in order."""
    return PreflightFinding(code=code, path=path, message=message, edits=edits)
