"""The reflection loop: `advance` takes a state to the next, one phase at a time.

Reconstruct, judge (stage 1); simulate, judge (stage 2); propose; decide; revise. Awaiting a
decision is a stored state, so it survives a restart. A stage-1 failure consumes a round and
never simulates. Every state that `advance` returns can be persisted and continued from.
"""

from physagent_studio.agent.by_hand import turn_of
from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.memory import changed_among, memory_of
from physagent_studio.agent.previews import preview_of, trial_of, without_run
from physagent_studio.agent.reviewer import POLICIES
from physagent_studio.agent.roles import Situation
from physagent_studio.errors import ProgramError
from physagent_studio.program import PhysicalProgram, apply
from physagent_studio.records import (
    Decision,
    LoopState,
    Proposal,
    RolloutEvidence,
    Round,
    SceneEvidence,
)

EASING = "easing"
"""Factor of a proposal that only makes gentler what holds."""
REFUSALS = 5
"""Proposals of one round that a policy turns down before it stops asking for more."""


def advance(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    """The next state; the same object where a person has to act first or all is done."""
    if turn_of(state) and not (state.phase == "generate" and state.draft):
        return state
    if state.phase == "generate":
        return _generate(state, crew, bench)
    if state.phase == "reconstruct":
        return _stage_one(state, crew, bench)
    if state.phase == "simulate":
        return _stage_two(state, crew, bench)
    if state.phase == "judge":
        return after_verdict(state)
    if state.phase == "propose":
        return _propose(state, crew, bench)
    if state.phase == "ease":
        return _ease(state, crew, bench)
    if state.phase == "decide":
        return _review(state)
    return state


def _generate(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    program = state.draft or crew.generator.first(
        bench.case, lambda scene: bench.reconstruct(scene, None)
    )
    author = "person" if state.draft else "generator"
    return add_round(state, program, author, None)


def add_round(
    state: LoopState, program: PhysicalProgram, author: str, origin: Decision | None
) -> LoopState:
    """A new round below the head that will run `program`."""
    number = max((item.number for item in state.rounds), default=0) + 1
    parent = state.current
    new = Round(
        id=f"r{number}",
        number=number,
        parent=parent.id if parent else None,
        program=program,
        author=author,
        origin=origin,
        # The scene of the round before is what a partial reconstruction starts from.
        scene=parent.scene if parent else None,
    )
    return state.model_copy(
        update={
            "rounds": (*state.rounds, new),
            "head": new.id,
            "phase": "reconstruct",
            "outcome": "running",
            "draft": None,
        }
    )


def _stage_one(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    current = _head(state)
    before = bench.get_scene(current.scene) if current.scene else None
    scene = bench.reconstruct(current.program.scene, before)
    program = current.program.model_copy(update={"scene": scene.state})
    evidence = SceneEvidence(program, scene, bench.view(scene))
    assessment = crew.verifier.judge(evidence, program.event.prompt)
    judged = current.model_copy(
        update={"program": program, "scene": bench.put_scene(scene), "assessment": assessment}
    )
    return _judged(replace_round(state, judged))


def _stage_two(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    current = _head(state)
    scene = bench.get_scene(_key(current.scene))
    rollout = bench.simulate(current.program, scene)
    checks = bench.measure(current.program, rollout, scene)
    frames = bench.evidence(scene, rollout)
    evidence = RolloutEvidence(current.program, scene, rollout, checks, frames)
    assessment = crew.verifier.judge(evidence, current.program.event.prompt)
    judged = current.model_copy(
        update={
            "rollout": bench.put_rollout(rollout),
            "frames": bench.put_frames(frames) if frames else None,
            "assessment": assessment,
            "simulations": current.simulations + 1,
        }
    )
    return _judged(replace_round(state, judged))


def _judged(state: LoopState) -> LoopState:
    """Goes on by the verifier's verdict, or waits for that of a person in its role."""
    return _to(state, "judge") if "verifier" in state.by_hand else after_verdict(state)


def after_verdict(state: LoopState) -> LoopState:
    """Where the verdict on the head leads: to the event, to a repair, or to the end."""
    if _head(state).scene_holds:
        return _to(state, "simulate")
    if _head(state).passed:
        return _to(state, "ease") if _is_to_be_eased(state) else _to(state, "done", "realised")
    if len(state.path()) >= state.budget:
        return _to(state, "done", "budget")
    return _to(state, "propose")


def _is_to_be_eased(state: LoopState) -> bool:
    """Whether a pass is made gentler: once, where nobody is asked and a round is left."""
    current = _head(state)
    eased = current.proposal is not None or any(
        item.proposal is not None and item.proposal.factor == EASING for item in state.path()
    )
    spoken = current.author == "person" or current.override is not None
    left = len(state.path()) < state.budget
    return state.policy != "ask" and not eased and not spoken and not state.by_hand and left


def _ease(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    """The one easing step after a pass; what it proposes is decided on like a repair."""
    if crew.director is None:
        return _to(state, "done", "realised")
    current = _head(state)
    situation = _situation(state, bench)
    proposal = crew.director.ease(situation)
    if not proposal.hunks:
        used = current.simulations + proposal.simulations
        changed = current.model_copy(update={"simulations": used})
        return _to(replace_round(state, changed), "done", "realised")
    preview = preview_of(current.program, proposal, situation.try_out, bench)
    changed = current.model_copy(
        update={
            "proposal": proposal,
            "preview": preview,
            "simulations": current.simulations + proposal.simulations + 1,
        }
    )
    return _to(replace_round(state, changed), "decide")


def _situation(state: LoopState, bench: Bench) -> Situation:
    """What a planner or a director works from at the head."""
    current = _head(state)
    assert current.assessment is not None
    scene = bench.get_scene(_key(current.scene))
    return Situation(
        case=bench.case,
        program=current.program,
        scene=scene,
        rollout=bench.get_rollout(current.rollout) if current.rollout else None,
        assessment=current.assessment,
        memory=memory_of(state),
        try_out=trial_of(scene, bench),
        ahead=bench.ahead(scene),
        look=lambda changed: bench.reconstruct(changed, scene),
    )


def _propose(state: LoopState, crew: Crew, bench: Bench) -> LoopState:
    current = _head(state)
    situation = _situation(state, bench)
    assert current.assessment is not None
    trial = situation.try_out
    proposal = crew.planner.propose(situation)
    contradiction = current.assessment.contradiction
    if contradiction:
        proposal = proposal.model_copy(update={"contradiction": contradiction})
    if current.assessment.stage == "reconstruction":
        # What fails in the picture is repaired in the picture: nothing is simulated on it.
        preview = without_run(current.program, proposal)
    else:
        preview = preview_of(current.program, proposal, trial, bench)
    if preview.program is not None:
        touched = changed_among(state.pinned, current.program, preview.program)
        proposal = proposal.model_copy(update={"touches_pinned": touched})
    used = proposal.simulations + (1 if preview.rollout else 0)
    proposed = current.model_copy(
        update={
            "proposal": proposal,
            "preview": preview,
            "decision": None,
            "simulations": current.simulations + used,
        }
    )
    return _to(replace_round(state, proposed), "decide")


def offer(state: LoopState, proposal: Proposal, bench: Bench, decision: Decision) -> LoopState:
    """Puts a proposal before whoever decides, in place of the planner's own.

    An open proposal is turned down with `decision`.
    """
    current = _head(state)
    trial = trial_of(bench.get_scene(_key(current.scene)), bench)
    preview = preview_of(current.program, proposal, trial, bench)
    rejected = current.rejected
    if current.proposal is not None:
        decision = decision.model_copy(update={"before": current.program.hash})
        rejected = (*rejected, (current.proposal, decision))
    used = proposal.simulations + (1 if preview.rollout else 0)
    offered = current.model_copy(
        update={
            "proposal": proposal,
            "preview": preview,
            "decision": None,
            "rejected": rejected,
            "simulations": current.simulations + used,
        }
    )
    return _to(replace_round(state, offered), "decide")


def _review(state: LoopState) -> LoopState:
    current = _head(state)
    assert current.proposal is not None
    assert current.preview is not None
    decision = POLICIES[state.policy].decide(current.proposal, current.preview)
    if decision is None:
        return state
    refused = sum(said.author == decision.author for _, said in current.rejected)
    if decision.kind == "reject" and refused >= REFUSALS:
        decision = decision.model_copy(update={"kind": "stop"})
    return decide(state, decision)


def decide(state: LoopState, decision: Decision) -> LoopState:
    """Carries out a decision on the head's proposal, whoever made it.

    Raises `ProgramError` (and changes nothing) where the decided edits do not apply.
    """
    current = _head(state)
    decision = decision.model_copy(
        update={"before": current.program.hash, "evidence": current.evidence}
    )
    if _is_easing(current) and decision.kind in ("stop", "skip", "reject"):
        return _to(_decided(state, decision), "done", "realised")
    if decision.kind == "stop":
        return _to(_decided(state, decision), "done", "stuck" if _is_stuck(current) else "stopped")
    if decision.kind in ("reject", "hint", "skip"):
        rejected = current.rejected
        if current.proposal is not None:
            rejected = (*rejected, (current.proposal, decision))
        hints = (*state.hints, decision.reason) if decision.kind == "hint" else state.hints
        changed = current.model_copy(
            update={"rejected": rejected, "proposal": None, "preview": None, "decision": decision}
        )
        state = replace_round(state, changed).model_copy(update={"hints": hints})
        return _to(state, "propose")
    if not decision.edits:
        raise ProgramError(())
    revised = apply(current.program, decision.edits)
    decision = decision.model_copy(update={"after": revised.hash})
    author = "planner" if decision.kind in ("accept", "accept_hunks") else "person"
    return add_round(_decided(state, decision), revised, author, decision)


def _is_easing(current: Round) -> bool:
    return current.proposal is not None and current.proposal.factor == EASING


def _is_stuck(current: Round) -> bool:
    return current.proposal is not None and not current.proposal.hunks


def _decided(state: LoopState, decision: Decision) -> LoopState:
    return replace_round(state, _head(state).model_copy(update={"decision": decision}))


def _head(state: LoopState) -> Round:
    current = state.current
    assert current is not None, "only `generate` runs without a round"
    return current


def _key(key: str | None) -> str:
    assert key is not None, "stage 1 has stored its scene"
    return key


def _to(state: LoopState, phase: str, outcome: str = "running") -> LoopState:
    return state.model_copy(update={"phase": phase, "outcome": outcome})


def replace_round(state: LoopState, changed: Round) -> LoopState:
    """The state with the round of that id replaced."""
    rounds = tuple(changed if item.id == changed.id else item for item in state.rounds)
    return state.model_copy(update={"rounds": rounds})
