"""Trying a proposal out before anybody decides on it; not a round."""

from collections.abc import Callable
from functools import partial

from physagent_studio.agent.crew import Bench
from physagent_studio.agent.roles import Trial
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.program import PhysicalProgram, SceneState, apply
from physagent_studio.records import Preview, Proposal, Scene


def trial_of(scene: Scene, bench: Bench) -> Callable[[PhysicalProgram], Trial]:
    """How a candidate program is tried on a scene."""

    def run(program: PhysicalProgram, changed: Scene) -> Trial:
        rollout = bench.simulate(program, changed)
        return Trial(rollout, bench.measure(program, rollout, changed))

    return partial(try_on, scene, bench.reconstruct, run)


def try_on(
    scene: Scene,
    reconstruct: Callable[[SceneState, Scene], Scene],
    run: Callable[[PhysicalProgram, Scene], Trial],
    program: PhysicalProgram,
) -> Trial:
    """Runs a candidate on a scene, which is reconstructed anew where the candidate changes it."""
    if program.scene == scene.state:
        return run(program, scene)
    changed = reconstruct(program.scene, scene)
    return run(program.model_copy(update={"scene": changed.state}), changed)


def tried(try_out: Callable[[PhysicalProgram], Trial], program: PhysicalProgram) -> Trial | None:
    """What a candidate does; None where it cannot run."""
    try:
        return try_out(program)
    except Cancelled:
        raise
    except StudioError:
        return None


def without_run(program: PhysicalProgram, proposal: Proposal) -> Preview:
    """Whether the edits of a stage 1 proposal apply; the next round shows what they do."""
    if not proposal.hunks:
        return Preview(program=None)
    try:
        return Preview(program=apply(program, proposal.edits))
    except StudioError as error:
        return Preview(program=None, problem=str(error))


def preview_of(
    program: PhysicalProgram,
    proposal: Proposal,
    trial: Callable[[PhysicalProgram], Trial],
    bench: Bench,
) -> Preview:
    """Tries a proposal out, for the eyes of whoever decides; not a round."""
    if not proposal.hunks:
        return Preview(program=None)
    try:
        revised = apply(program, proposal.edits)
        ran = trial(revised)
    except Cancelled:
        raise
    except StudioError as error:
        return Preview(program=None, problem=str(error))
    return Preview(
        program=revised,
        checks=ran.checks,
        passed=all(check.ok for check in ran.checks if check.demanded),
        rollout=bench.put_rollout(ran.rollout),
    )
