"""What a viewer must be able to see: checks of kind `view`, always on.

They speak of the picture, from outlines through the camera (`picture`): is it in the frame, slow
enough to be followed, long enough to be seen, as the photograph at the start and as told at the
end? `framing`, `pace`, `staging`, `footing` and `amounts` (no faster than the verb, along its own
wheels) measure it. What needs drawn silhouettes comes as `Drawn`. No check where there is no camera
or no run.
"""

from collections.abc import Mapping

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.view.basics import (
    INSIDE,
    acting_objects,
    amounts,
    in_place,
    nothing_happens,
    on_wheels,
    subject_of,
    view_code,
)
from physagent_studio.contract.view.bystanders import leaves_alone
from physagent_studio.contract.view.footing import falls_as_told, keeps_its_footing
from physagent_studio.contract.view.framing import (
    breaks_in_sight,
    gone,
    inside,
    meetings,
    partly_gone,
)
from physagent_studio.contract.view.pace import (
    FALL_FILLS,
    FALLING_STEP,
    FILLS,
    STEP,
    Pacing,
    come_down,
    fills,
    in_time,
    paces,
    pacing_of,
    something,
)
from physagent_studio.contract.view.staging import COVERS, Drawn, begins, comes_apart, ends, touches
from physagent_studio.records.judgement import Check


def view_checks(
    facts: Facts, checks: tuple[Check, ...], drawn: Mapping[str, Drawn] | None = None
) -> tuple[Check, ...]:
    """All view checks of a run; `checks` are those of its contract."""
    program = facts.program
    names = tuple(n for n in facts.rollout.objects if n in acting_objects(program))
    if program.scene.camera is None or not facts.complete:
        return ()
    found = [*begins(facts, drawn or {})]
    if not names:
        return tuple(found)
    found.append(in_time(facts, checks))
    found += [inside(facts, name) for name in names]
    found += paces(facts, names)
    if not nothing_happens(program):
        found += [something(facts, names), fills(facts, names)]
    found += [*touches(facts, names), *comes_apart(facts, names)]
    found += breaks_in_sight(facts, names)
    found += [gone(facts, name) for name in names if name in program.contract.leaving]
    found += [partly_gone(facts, name) for name in names if name in program.contract.partly]
    found += [
        *meetings(facts),
        *ends(facts, names),
        *come_down(facts, names),
        *amounts(facts),
        *on_wheels(facts, names),
    ]
    found += [*in_place(facts, names), *leaves_alone(facts, names)]
    found += [*keeps_its_footing(facts, names), *falls_as_told(facts, names)]
    return tuple(found)
