"""Before the first program is written: what the case marks stands in for it, edits wait, and what
was found by words gives way to a hand."""

from collections.abc import Callable

from physagent_studio.program.scene.state import Grounding, SceneObject, SceneState
from physagent_studio.records import Case, Scene
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


Spot = tuple[float, float]


def disproved(state: SceneState, shown: Scene | None, name: str, said: Grounding) -> set[str]:
    """Things whose guessed place a person now says to be another's.

    A click inside `name` that lies in the mask that a guess has given to another thing: that
    thing is somewhere else, so its guess is no place outside of `name`. shown: what was
    reconstructed from the guesses; without it nothing is known to be wrong.
    """
    if shown is None:
        return set()
    out = set()
    for item in state.objects:
        mask = shown.masks.get(item.name)
        if item.name == name or not item.grounding.proposed or mask is None:
            continue
        inside = [(int(click.y), int(click.x)) for click in said.points if click.label]
        if any(y < mask.shape[0] and x < mask.shape[1] and mask[y, x] for y, x in inside):
            out.add(item.name)
    return out


def without_stale(grounding: Grounding, stale: set[Spot]) -> Grounding:
    """A grounding without the places outside of it that only a guess had called another thing."""
    kept = tuple(c for c in grounding.points if c.label or (c.x, c.y) not in stale)
    return grounding if kept == grounding.points else grounding.model_copy(update={"points": kept})


def stale_spots(case: Case | None, state: SceneState) -> set[Spot]:
    """Guessed places, pixels, of things that a person has marked elsewhere since.

    A mask that was taken keeps them among its clicks, so that it stays as it was seen; whoever
    marks that thing again begins without them.
    """
    spots: set[Spot] = set()
    for name, guess in () if case is None else case.objects:
        item = state.object(name)
        if guess.proposed and item is not None:
            here = {(click.x, click.y) for click in item.grounding.points if click.label}
            spots |= {(click.x, click.y) for click in guess.points if click.label} - here
    return spots
