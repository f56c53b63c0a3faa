"""What a hand presses together and lets go again."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.program.actions import Action
from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.materials import density_of


@dataclass(frozen=True, slots=True)
class SqueezingSettings:
    """How far and how long a thing is pressed together."""

    middle_strain: float = 0.08  # share, 0.03..0.3: of its height, pressed together
    # count, 2..8: of steps in which the hand presses harder and harder: at once, it would be a blow
    stage_count: int = 4
    stage_steps: int = 12  # steps, 5..30: of each of them
    press_share: float = 0.4  # 0.2..0.6: of the clip, for which it is pressed


SQUEEZING = SqueezingSettings()


def is_squeezed(task: Task) -> bool:
    """Whether it is soft, stands on something, and nothing else deforms it."""
    item = task.layout.state.object(task.name)
    soft = item is not None and isinstance(item.body, Soft)
    alone = not task.intent.struck_by and not task.intent.hits
    return soft and alone and task.layout.carrier(task.name) is not None


def squeeze(task: Task) -> list[Action]:
    """Pressed down on what carries it: all of it is drawn down, so that half of the strain that a
    force on its top would give is that of its middle."""
    item = task.layout.state.object(task.name)
    if item is None or not isinstance(item.body, Soft):
        return []
    stress = item.body.young * SQUEEZING.middle_strain
    pull = 2 * stress / (density_of(item) * max(task.layout.height(task.name), 0.01))
    pull = max(pull - mech.G, mech.G) / SQUEEZING.stage_count
    force = act.toward_or_along(pull, way="down", quantity="acceleration")
    steps, wait = round(SQUEEZING.press_share * task.clip.steps), SQUEEZING.stage_steps
    return [
        act.push(
            task.name, force, start=task.delay + k * wait, duration=steps - k * wait,
            label=f"squeeze_{k + 1}",
        )
        for k in range(SQUEEZING.stage_count)
    ]  # fmt: skip
