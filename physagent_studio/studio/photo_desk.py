"""What the photo's tools look for: candidate masks, and ways along edges."""

from __future__ import annotations

from typing import Any

from physagent_studio.program import Grounding
from physagent_studio.reconstruction.live_edge import LiveEdge
from physagent_studio.reconstruction.segmentation import EmbeddedSegmenter, apart, choose
from physagent_studio.records import Candidate, Image
from physagent_studio.studio.panels.photo import path_of

Groundings = list[tuple[str, Grounding]]


class PhotoDesk:
    """What the tools keep between two questions: candidates of the last clicks, the last anchor.

    Used by the finder's thread alone.
    """

    def __init__(self) -> None:
        self._said: tuple[object, ...] = ()
        self._offers: tuple[Candidate, ...] = ()
        self._edge: LiveEdge | None = None

    def masks(self, image: Image, name: str, said: Groundings) -> dict[str, Any]:
        """The masks on offer for a name, best first, its strokes applied."""
        grounding = dict(said)[name]
        alone = dict(apart(said))[name]
        key = (id(image), name, alone)
        if key != self._said:
            self._offers = EmbeddedSegmenter().candidates(image, name, alone)
            self._said = key
        shape = (image.shape[0], image.shape[1])
        masks = []
        for index, offer in enumerate(self._offers):
            chosen = grounding.model_copy(update={"candidate": index})
            mask = choose({name: self._offers}, [(name, chosen)], shape, image)[name]
            masks.append({"path": path_of(mask), "score": round(offer.score, 3)})
        return {"name": name, "masks": masks}

    def way(self, image: Image, start: tuple[float, float], end: tuple[float, float]) -> Any:
        """The way along edges, as points."""
        if self._edge is None or self._edge.image is not image:
            self._edge = LiveEdge(image)
        return {"points": [[round(x, 1), round(y, 1)] for x, y in self._edge.way(start, end)]}
