"""The frozen values that cross rooms.

`judgement` has what a round is and holds (checks, assessments, proposals, decisions),
`loop_state` the rounds of a session, `scene` and `rollout` what is reconstructed and simulated,
`doubts` what is left open; `session.session` writes them to disk.
"""

from physagent_studio.records.case import Case, Image
from physagent_studio.records.doubts import Doubt, doubts_about, doubts_of
from physagent_studio.records.judgement import (
    CRITERIA,
    Assessment,
    Check,
    Criterion,
    Decision,
    Evidence,
    Hunk,
    Lesson,
    Memory,
    MemoryEntry,
    Mismatch,
    Override,
    Preview,
    Proposal,
    RolloutEvidence,
    Round,
    SceneEvidence,
)
from physagent_studio.records.loop_state import LoopState
from physagent_studio.records.rollout import CONTACT_DTYPE, ActionSpan, Alarm, Release, Rollout
from physagent_studio.records.scene import (
    Candidate,
    Finding,
    LearnedUse,
    Mesh,
    Scene,
    Shading,
    ShapeOffer,
)
