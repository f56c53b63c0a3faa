"""The shapes that a mask may be, best first, kept with the scene so that one key switches them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.scene import Scene, ShapeOffer


def ranking(
    state: SceneState,
    masks: Mapping[str, BoolArray],
    fresh: Mapping[str, Sequence[ShapeOffer]],
    previous: Scene | None,
) -> dict[str, tuple[ShapeOffer, ...]]:
    """The offers of every object, best first.

    fresh: what was fitted now, all kinds or one that was asked for. What an earlier scene knew of
    a mask that is the same is kept, so that switching to one shape forgets no other.
    """
    out: dict[str, tuple[ShapeOffer, ...]] = {}
    for item in state.objects:
        offers = {offer.kind: offer for offer in _before(item.name, masks, previous)}
        offers |= {offer.kind: offer for offer in fresh.get(item.name, ())}
        if offers:
            order = sorted(offers.values(), key=lambda offer: (-offer.merit, offer.kind))
            out[item.name] = tuple(order)
    return out


def ranked(state: SceneState, masks: Mapping[str, BoolArray], previous: Scene | None) -> set[str]:
    """The objects whose shapes an earlier scene has ranked, for the masks that they have now."""
    return {item.name for item in state.objects if _before(item.name, masks, previous)}


def _before(
    name: str, masks: Mapping[str, BoolArray], previous: Scene | None
) -> tuple[ShapeOffer, ...]:
    if previous is None or name not in previous.masks or name not in masks:
        return ()
    same = np.array_equal(previous.masks[name], masks[name])
    return previous.shapes.get(name, ()) if same else ()
