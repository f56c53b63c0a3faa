"""The first program of a case with its scene, where no session keeps them."""

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.reconstruction import reconstruct
from physagent_studio.reconstruction.learned.at_hand import NOTHING, Learned
from physagent_studio.records import Case, Scene


def first_program(case: Case, learned: Learned = NOTHING) -> tuple[PhysicalProgram, Scene]:
    """The program that the rules write of a case, and the scene it runs in.

    The photo is looked at once: the scene that the program was planned from serves again. Raises
    what `reconstruct` raises.
    """
    found: list[Scene] = []

    def seen(state: SceneState) -> Scene:
        before = found[-1] if found else None
        found.append(reconstruct(case, state, previous=before, learned=learned))
        return found[-1]

    program = RuleGenerator().first(case, seen)
    return program, seen(program.scene)
