"""What was found by words gives way to a hand: guesses that a click disproves, and what is left of
guesses that were taken back."""

from __future__ import annotations

from physagent_studio.program.scene.state import Grounding, SceneState
from physagent_studio.records import Case, Scene

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
