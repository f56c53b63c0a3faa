"""What has to go with a thing that is deleted: whatever speaks of it."""

from __future__ import annotations

from physagent_studio.errors import EditError, ProgramError
from physagent_studio.program import Edit, PhysicalProgram, RemoveItem, SetField, apply

LISTS = ("event.actions", "contract.statements", "scene.landmarks")
"""Lists whose items are of no use without what they speak of."""
ROUNDS = 20
"""How often something else may turn out to speak of what goes."""


def removing(program: PhysicalProgram, path: str) -> tuple[Edit, ...]:
    """The edits that delete the item at a path, and before it what would speak of nothing.

    An object that stood on it then stands where it is. Raises ProgramError where the item cannot
    be deleted for another reason.
    """
    edits: list[Edit] = [RemoveItem(path=path)]
    for _ in range(ROUNDS):
        try:
            apply(program, edits)
        except EditError:
            raise
        except ProgramError as error:
            more = [edit for one in error.problems if (edit := _without(one.path, program))]
            fresh = [edit for edit in dict.fromkeys(more) if edit not in edits]
            if not fresh:
                raise
            edits = [*fresh, *edits]
        else:
            break
    return tuple(edits)


def _without(path: str, program: PhysicalProgram) -> Edit | None:
    """The edit that takes back what a problem at a path is about."""
    for listed in LISTS:
        if path.startswith(listed + "."):
            name = path.removeprefix(listed + ".").partition(".")[0]
            return RemoveItem(path=f"{listed}.{name}")
    if path.startswith("scene.objects.") and path.endswith(".support"):
        name = path.split(".")[2]
        return SetField(path=path, value=None) if program.scene.object(name) else None
    return None
