"""What is measured on: many balls that drift, the demo, and a session of many rounds."""

from __future__ import annotations

from physagent_studio.program import EventProgram, PhysicalProgram, SceneObject, SceneState, Support
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene import state as shapes
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.records import LoopState
from physagent_studio.session import Store


def drifting(count: int) -> PhysicalProgram:
    """Balls that drift without weight, so that every one has another pose on every frame."""
    names = [f"ball_{n}" for n in range(count)]
    objects = tuple(
        SceneObject(
            name=name,
            shape=shapes.Sphere(radius=0.05),
            position=((n % 10) * 0.2 - 0.9, 1.5 + (n // 10) * 0.2, 1.0),
            support=AIR,
            material="rubber",
        )
        for n, name in enumerate(names)
    )
    drift = tuple(SetVelocity(id=f"go_{name}", name=name, velocity=(0.3, 0, 0)) for name in names)
    floor = Support(name="floor", shape=shapes.Floor(), material="wood")
    return PhysicalProgram(
        scene=SceneState(objects=objects, supports=(floor,), gravity=(0.0, 0.0, 0.0)),
        event=EventProgram(prompt="Balls drift to the right.", actions=drift),
    )


def lengthen(store: Store, session_id: str, rounds: int) -> None:
    """Makes a session of one round into one of many: a chain of rounds with its programs."""
    session = store.open(session_id)
    state: LoopState = session.load()
    first = state.rounds[0]
    chain = [first]
    for number in range(2, rounds + 1):
        prompt = f"{first.program.event.prompt} ({number})"
        event = first.program.event.model_copy(update={"prompt": prompt})
        program = first.program.model_copy(update={"event": event})
        update = {
            "id": f"r{number}",
            "number": number,
            "parent": chain[-1].id,
            "program": program,
        }
        chain.append(first.model_copy(update=update))
    longer = state.model_copy(update={"rounds": tuple(chain), "head": chain[-1].id})
    session.save(longer, checkpoint="many rounds")
    session.close()
