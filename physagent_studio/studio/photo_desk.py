"""What the photo's tools look for: candidate masks, and ways along edges."""

from __future__ import annotations

from typing import Any

from physagent_studio.program import Grounding
from physagent_studio.reconstruction.live_edge import LiveEdge
from physagent_studio.reconstruction.segmentation import EmbeddedSegmenter, apart, choose
from physagent_studio.reconstruction.segmentation_stack import METHOD, companions
from physagent_studio.records import Candidate, Image
from physagent_studio.studio.panels.photo import path_of

Groundings = list[tuple[str, Grounding]]


class PhotoDesk:
    """What the tools keep between two questions: candidates of the last clicks, the last anchor.

    Used by the finder's thread alone.
    """

    def __init__(self) -> None:
        self._image: Image | None = None
        self._offers: dict[str, tuple[Grounding, tuple[Candidate, ...]]] = {}
        self._stack: tuple[Groundings, dict[str, tuple[Candidate, ...]]] = ([], {})
        self._edge: LiveEdge | None = None

    def masks(self, image: Image, name: str, said: Groundings) -> dict[str, Any]:
        """The masks on offer for a name, best first, its strokes applied.

        candidate: what the grounding has to say to mean a mask. layer: whether the mask is a layer
        of a stack, which all clicks on the stack give together, and the grounding means of itself.
        """
        grounding = dict(said)[name]
        offers = self._offers_of(image, name, said)
        shape = (image.shape[0], image.shape[1])
        masks = []
        for index, offer in enumerate(offers):
            chosen = grounding.model_copy(update={"candidate": index})
            mask = choose({name: offers}, [(name, chosen)], shape, image)[name]
            layer = offer.method == METHOD
            own = index - (offers[0].method == METHOD)
            masks.append(
                {
                    "path": path_of(mask),
                    "score": round(offer.score, 3),
                    "candidate": max(own, 0),
                    "layer": layer,
                }
            )
        return {"name": name, "masks": masks}

    def _offers_of(self, image: Image, name: str, said: Groundings) -> tuple[Candidate, ...]:
        """Candidates from a thing's own clicks, led by its layer where it is one of a stack."""
        beside = companions(said, name)
        needed = {key: own for key, own in apart(said) if key == name or key in beside}
        known = self._offers if self._image is image else {}
        self._image, self._offers = image, {}
        for key, own in needed.items():
            before = known.get(key)
            if before is None or before[0] != own:
                before = (own, EmbeddedSegmenter().candidates(image, key, own))
            self._offers[key] = before
        offers = {key: found for key, (_, found) in self._offers.items()}
        if not beside:
            return offers[name]
        stack = [(key, own) for key, own in said if key in beside]
        if self._stack[0] != stack or known.keys() != offers.keys():
            self._stack = (stack, EmbeddedSegmenter().together(image, stack, offers))
        return self._stack[1][name]

    def way(self, image: Image, start: tuple[float, float], end: tuple[float, float]) -> Any:
        """The way along edges, as points."""
        if self._edge is None or self._edge.image is not image:
            self._edge = LiveEdge(image)
        return {"points": [[round(x, 1), round(y, 1)] for x, y in self._edge.way(start, end)]}
