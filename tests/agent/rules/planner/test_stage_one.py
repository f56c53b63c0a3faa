"""Stage 1 repairs: the failed factor alone, chosen by looking, never by simulating."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.agent.rules.planner.stage_one import repair_likeness
from physagent_studio.program import PhysicalProgram, SceneState, apply
from physagent_studio.program.edits import SetField
from physagent_studio.records import (
    Candidate,
    Finding,
    Memory,
    MemoryEntry,
    Mismatch,
    Scene,
    SceneEvidence,
    ShapeOffer,
)
from tests.agent.rules.scenes import STAGES

STAGE = STAGES["lane"]
PROMPT = "The bowling ball rolls toward the middle pin and hits it."
MASK = np.ones((4, 4), bool)


def finding(kind: str, name: str, subject: str, measured: float, least: float) -> Finding:
    ok = measured >= least
    text = f"{name} of {subject} is {measured:.2f}"
    return Finding(name, subject, measured, least, "", ok, kind, text)  # type: ignore[arg-type]


def scene_of(state: SceneState, fits: Callable[[SceneState], float]) -> Scene:
    """The true geometry; how well the middle pin's mask fits is told by `fits`."""
    scene = STAGE.reconstruct(state)
    offered = tuple(Candidate(MASK, 0.9 - 0.1 * n, "test") for n in range(4))
    found = (
        finding("mask", "reprojection", "left_pin", 0.92, 0.8),
        finding("mask", "reprojection", "middle_pin", fits(state), 0.8),
    )
    return replace(scene, findings=found, candidates=MappingProxyType({"middle_pin": offered}))


def chosen(state: SceneState) -> int:
    item = state.object("middle_pin")
    assert item is not None
    return item.grounding.candidate


def situation(fits: Callable[[SceneState], float], memory: Memory | None = None) -> Situation:
    case = STAGE.case(PROMPT)
    program = RuleGenerator().first(case, STAGE.reconstruct)
    scene = scene_of(program.scene, fits)
    assessment = RuleVerifier().judge(SceneEvidence(program, scene, None), PROMPT)
    assert not assessment.passed

    def never(candidate: PhysicalProgram) -> Trial:
        raise AssertionError("stage 1 must not simulate")

    return Situation(
        case,
        program,
        scene,
        None,
        assessment,
        memory or Memory(),
        never,
        look=lambda state: scene_of(state, fits),
    )


def test_the_best_mask_is_found_by_looking() -> None:
    now = situation(lambda state: (0.1, 0.2, 0.9, 0.3)[chosen(state)])
    proposal = RulePlanner().propose(now)
    assert proposal.factor == "mask candidate"
    assert proposal.simulations == 0
    assert chosen(apply(now.program, proposal.edits).scene) == 2


def test_only_that_object_changes() -> None:
    now = situation(lambda state: (0.1, 0.2, 0.9, 0.3)[chosen(state)])
    changed = apply(now.program, RulePlanner().propose(now).edits)
    for before, after in zip(now.program.scene.objects, changed.scene.objects, strict=True):
        assert (before == after) == (before.name != "middle_pin")
    assert changed.event == now.program.event
    assert changed.contract == now.program.contract
    assert changed.scene.supports == now.program.scene.supports


def test_nothing_better_means_a_question() -> None:
    proposal = RulePlanner().propose(situation(lambda state: 0.1))
    assert not proposal.hunks
    assert "middle_pin" in proposal.question


def test_a_pinned_grounding_is_left_alone() -> None:
    memory = Memory(pinned=("scene.objects.middle_pin",))
    now = situation(lambda state: (0.1, 0.2, 0.9, 0.3)[chosen(state)], memory)
    assert not RulePlanner().propose(now).hunks


def test_what_was_tried_is_not_tried_again() -> None:
    fits = situation(lambda state: (0.1, 0.2, 0.9, 0.3)[chosen(state)])
    first = RulePlanner().propose(fits)
    entry = MemoryEntry(
        round="r2",
        factor="mask candidate",
        rationale="",
        edits=first.edits,
        decided="accept",
        reason="",
        margins_before={},
        margins_after={},
    )
    again = RulePlanner().propose(replace(fits, memory=Memory(entries=(entry,))))
    assert again.edits != first.edits


def unlike(*offers: tuple[str, float]) -> Situation:
    """The middle pin is drawn unlike the photograph; other shapes cover so much of its mask."""
    now = situation(lambda state: 0.1)
    worst = Mismatch(code="unlike_the_photo", text="it is drawn otherwise", subject="middle_pin")
    shapes = {"middle_pin": tuple(ShapeOffer(kind, share, share) for kind, share in offers)}
    return replace(
        now,
        scene=replace(now.scene, shapes=MappingProxyType(shapes)),
        assessment=now.assessment.model_copy(
            update={"stage": "simulation", "diagnosis": (worst,), "passed": False}
        ),
    )


def test_what_is_drawn_otherwise_gets_the_likeliest_shape_that_covers_its_mask() -> None:
    now = unlike(("box", 0.91), ("inflated", 0.96), ("capsule", 0.98))
    proposal = RulePlanner().propose(now)
    assert proposal.factor == "primitive"
    assert proposal.simulations == 0
    item = apply(now.program, proposal.edits).scene.object("middle_pin")
    assert item is not None
    assert (item.form, item.shape, item.position) == ("inflated", None, None)


def test_where_no_shape_covers_it_the_next_mask_that_one_covers_is_taken() -> None:
    now = unlike(("box", 0.7), ("capsule", 0.71))

    def look(state: SceneState) -> Scene:
        best = (0.7, 0.8, 0.97, 0.99)[chosen(state)]
        shapes = {"middle_pin": (ShapeOffer("capsule", best, best),)}
        return replace(now.scene, shapes=MappingProxyType(shapes))

    proposal = RulePlanner().propose(replace(now, look=look))
    assert proposal.factor == "mask candidate"
    assert chosen(apply(now.program, proposal.edits).scene) == 2


def test_where_no_shape_covers_its_mask_a_person_is_asked() -> None:
    now = unlike(("box", 0.91), ("capsule", 0.92))
    assert repair_likeness(now) is None


def test_a_box_that_a_person_drew_is_not_left() -> None:
    """Mask 3 fits best, and lies outside of the box; mask 2 is the best within it."""
    now = situation(lambda state: (0.1, 0.3, 0.95, 0.2)[chosen(state)])
    inside, outside = np.zeros((2, 200, 200), bool)
    inside[50:100, 50:100], outside[120:180, 20:180] = True, True
    masks = [inside, inside, outside, inside]
    offers = tuple(Candidate(mask, 0.9 - 0.1 * n, "test") for n, mask in enumerate(masks))
    offered = MappingProxyType({"middle_pin": offers})
    box = SetField(path="scene.objects.middle_pin.grounding.box", value=[48.0, 48.0, 102.0, 102.0])
    for edits, taken in (((box,), 1), ((), 2)):
        program = apply(now.program, edits)

        def look(state: SceneState) -> Scene:
            return replace(
                scene_of(state, lambda s: (0.1, 0.3, 0.95, 0.2)[chosen(s)]), candidates=offered
            )

        boxed = replace(now, program=program, scene=look(program.scene), look=look)
        assert chosen(apply(program, RulePlanner().propose(boxed).edits).scene) == taken


def test_what_a_box_shows_becomes_a_board_when_nothing_else_is_left() -> None:
    """The run goes on then: nothing more about a board is demanded, it is doubted."""
    now = situation(lambda _state: 0.1)
    box = SetField(path="scene.objects.middle_pin.grounding.box", value=[1.0, 1.0, 3.0, 3.0])
    now = replace(now, program=apply(now.program, (box,)))
    proposal = RulePlanner().propose(now)
    changed = apply(now.program, proposal.edits)
    pin = changed.scene.object("middle_pin")
    assert pin is not None
    assert (pin.form, pin.shape, pin.position) == ("board", None, None)
    scene = scene_of(now.program.scene, lambda _state: 0.1)
    objects = tuple(
        o.model_copy(update={"form": "board"}) if o.name == pin.name else o
        for o in scene.state.objects
    )
    scene = replace(scene, state=scene.state.model_copy(update={"objects": objects}))
    assert RuleVerifier().judge(SceneEvidence(changed, scene, None), PROMPT).passed
