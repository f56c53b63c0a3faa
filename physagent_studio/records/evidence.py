"""`Evidence`: what a stage shows its verifier."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records.case import Image
from physagent_studio.records.judgement import Check
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class SceneEvidence:
    """Stage 1: the scene with its findings, and its rendered view beside the photo."""

    program: PhysicalProgram
    scene: Scene
    view: Image | None


@dataclass(frozen=True, eq=False, slots=True)
class RolloutEvidence:
    """Stage 2: measured facts and every third frame (x1, x4 … x79 of the paper).

    checks: the contract and the always-on physical checks, measured. frames: 27 images, or
    empty where nothing was rendered.
    """

    program: PhysicalProgram
    scene: Scene
    rollout: Rollout
    checks: tuple[Check, ...]
    frames: tuple[Image, ...] = ()


Evidence = SceneEvidence | RolloutEvidence
