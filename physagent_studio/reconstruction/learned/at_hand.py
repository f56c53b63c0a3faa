"""Which learned models are there, what they are asked, and what came of it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding, SceneObject
from physagent_studio.reconstruction.learned import efficient_sam, lama
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.reconstruction.learned.zoo import (
    ZOO,
    ModelFailed,
    condition,
    content,
    damaged,
    models_folder,
    path_of,
)
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate, LearnedUse, Scene

Made = TypeVar("Made")
BACKGROUND = "background"


class Learned:
    """The models whose files are in a folder; each is loaded when it is first asked.

    A model that fails once is not asked again: `failed` says why, and the embedded way stands in.
    """

    def __init__(self, folder: Path | None) -> None:
        """folder: None for none, with which nothing is ever asked."""
        self._folder = folder
        self._loading = threading.Lock()
        self._networks: dict[str, Network] = {}
        self.failed: dict[str, str] = {}
        found = {} if folder is None else {name: condition(ZOO[name], folder) for name in ZOO}
        self.there = tuple(name for name, how in found.items() if how == "ready")
        for name, how in found.items():
            if folder is not None and how == "damaged":
                self.failed[name] = damaged(ZOO[name], path_of(ZOO[name], folder))

    def __reduce__(self) -> tuple[Callable[[Path | None], Learned], tuple[Path | None]]:
        """Another process loads its own; the networks stay here."""
        return (_in_folder, (self._folder,))

    @property
    def key(self) -> str:
        """What tells scenes apart by the models that they are made with; "" for none."""
        return " ".join(ZOO[name].sha256 for name in self.there if name not in self.failed)

    def masks(self, image: Image, grounding: Grounding) -> tuple[Candidate, ...]:
        """Masks (H, W) of what was clicked or boxed, best first; none without the model."""
        found = self._asked(
            efficient_sam.NAME, lambda net: efficient_sam.proposals(net, image, grounding)
        )
        return found or ()

    def filled(
        self, photo: Image, hole: NDArray[np.bool_], cancelled: Callable[[], bool]
    ) -> Image | None:
        """The photo (H, W, 3) with the hole (H, W) filled; None without the model."""
        return self._asked(lama.NAME, lambda net: lama.inpainted(net, photo, hole, cancelled))

    def _asked(self, name: str, work: Callable[[Network], Made]) -> Made | None:
        if name not in self.there or name in self.failed:
            return None
        try:
            return work(self._network(name))
        except ModelFailed as error:
            self.failed[name] = str(error)
            return None

    def _network(self, name: str) -> Network:
        with self._loading:
            if name not in self._networks:
                self._networks[name] = Network(content(ZOO[name], self._folder))
            return self._networks[name]


class Inpainting:
    """The filling of holes as `background` calls it; `used` says whether a model did it."""

    def __init__(self, learned: Learned, cancelled: Callable[[], bool] | None) -> None:
        self.learned = learned
        self._cancelled = cancelled or (lambda: False)
        self.used = False

    def __call__(self, photo: Image, hole: NDArray[np.bool_]) -> Image:
        """The photo (H, W, 3) with the hole (H, W) filled, or as it is where no model does that."""
        found = self.learned.filled(photo, hole, self._cancelled) if hole.any() else None
        self.used = self.used or found is not None
        return photo if found is None else found


NOTHING = Learned(None)
"""No models: the embedded way alone."""


def learned_here(folder: Path | None = None) -> Learned:
    """The models in a folder, by default the user's; loaded ones are shared by all who ask."""
    where = folder or models_folder()
    stamps = []
    for model in ZOO.values():
        path = path_of(model, where)
        stamps.append((model, path.stat().st_mtime_ns if path.is_file() else 0))
    return _shared(where, tuple(stamps))


def _in_folder(folder: Path | None) -> Learned:
    return NOTHING if folder is None else learned_here(folder)


@lru_cache(maxsize=1)
def _shared(folder: Path, stamps: tuple[object, ...]) -> Learned:
    """stamps: models, and when their files were written; with others they are read anew."""
    return Learned(folder)


def uses_of(
    inpainting: Inpainting,
    objects: Sequence[SceneObject],
    offers: Mapping[str, Sequence[Candidate]],
    plate: Image,
    previous: Scene | None,
) -> tuple[LearnedUse, ...]:
    """What models did for a scene, those that failed with why.

    offers: the candidates of each object. plate: the background, which may be that of `previous`.
    """
    learned = inpainting.learned
    kept = previous.learned if previous is not None and plate is previous.plate else ()
    before = any(BACKGROUND in use.made for use in kept)
    made = {
        efficient_sam.NAME: tuple(_masked_by_model(objects, offers)),
        lama.NAME: (BACKGROUND,) if inpainting.used or before else (),
    }
    known = [name for name in ZOO if made[name] or name in {*learned.there, *learned.failed}]
    return tuple(LearnedUse(name, made[name], learned.failed.get(name, "")) for name in known)


def _masked_by_model(
    objects: Sequence[SceneObject], offers: Mapping[str, Sequence[Candidate]]
) -> Iterator[str]:
    """The objects whose chosen mask came from a model."""
    for item in objects:
        own = offers.get(item.name)
        if own and own[min(item.grounding.candidate, len(own) - 1)].method == efficient_sam.NAME:
            yield item.name
