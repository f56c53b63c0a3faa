"""Before the first program is written: what the case marks stands in for it, and edits wait."""

from __future__ import annotations

from collections.abc import Callable

from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.workbench import Snapshot

Act = Callable[[], None]


def unwritten(snapshot: Snapshot) -> bool:
    """Whether there is a photo with a sentence, and nothing has been made of them yet."""
    case, state = snapshot.case, snapshot.state
    if case is None or case.image is None or not case.prompt.strip():
        return False
    return not state.rounds and state.draft is None


def marked(snapshot: Snapshot) -> SceneState:
    """The things in the photo: the program's, or those of the case until there is a program."""
    case = snapshot.case
    if case is None or not unwritten(snapshot):
        return snapshot.program.scene
    return SceneState(
        horizon=case.horizon,
        roll=case.roll,
        scale=case.scale,
        objects=tuple(SceneObject(name=name, grounding=said) for name, said in case.objects),
        supports=case.supports,
        landmarks=case.landmarks,
    )


class Waiting:
    """What a person did to a scene that is still being made; the studio's one thread uses it."""

    def __init__(self) -> None:
        self._acts: list[tuple[str | None, Act]] = []

    def add(self, session: str | None, act: Act) -> None:
        """Keeps what is to be done once the first program of a session is there."""
        self._acts.append((session, act))

    def due(self, snapshot: Snapshot) -> list[Act]:
        """What can be done now, in its order; what was meant for another session is forgotten.

        Where the making has ended without a program it is due too: it says itself what is missing.
        """
        own = [act for session, act in self._acts if session == snapshot.session_id]
        if unwritten(snapshot) and snapshot.busy is not None:
            return []
        self._acts.clear()
        return own
