"""The physical program: scene state, actions, event program, contract schema, edits."""

from physagent_studio.program.actions import Action, After, Directed, OnContact, When, duration_of
from physagent_studio.program.base import Frozen
from physagent_studio.program.contract import Clause, Contract, Statement
from physagent_studio.program.edits import (
    AddItem,
    Edit,
    MoveItem,
    RemoveItem,
    SetField,
    apply,
    apply_with_inverse,
    value_at,
)
from physagent_studio.program.program import Clip, EventProgram, PhysicalProgram
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.materials import MATERIALS
from physagent_studio.program.scene.state import (
    Click,
    Grounding,
    Landmark,
    SceneObject,
    SceneState,
    Support,
)
