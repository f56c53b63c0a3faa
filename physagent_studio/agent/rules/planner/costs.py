"""What a candidate run costs, in units that do not depend on the machine.

One unit is a clip of a few rigid bodies; grains, cloth and soft bodies have many times their
degrees of freedom. Search budgets are counted in these units, so that a search takes about as
long whatever the scene is made of, and does the same on a fast machine and on a slow one.
"""

from __future__ import annotations

from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.bodies import (
    Breakable,
    Cloth,
    Granular,
    Liquid,
    Plastic,
    Rope,
    Soft,
)
from physagent_studio.program.scene.state import SceneObject


def cost_of(program: PhysicalProgram) -> float:
    """Units of one run of the program, at least 1."""
    freedoms = sum(_freedoms(item) for item in program.scene.objects)
    unit_steps = 24 * 320  # 1000..100000: of degrees of freedom: four rigid bodies for a usual clip
    return max(freedoms * program.clip.steps / unit_steps, 1.0)


def _freedoms(item: SceneObject) -> int:
    match item.body:
        case Granular(grains=grains) | Liquid(grains=grains):
            return 6 * grains
        case Cloth(cells=cells):
            return 3 * (cells + 1) ** 2
        case Soft() | Plastic():
            return 100
        case Rope():
            return 120
        case Breakable(cuts=cuts):
            return 6 * cuts[0] * cuts[1] * cuts[2]
    return 6
