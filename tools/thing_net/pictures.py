"""Pictures to learn from: things of `benchmark.scenes`, stretched, and things made up by chance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest import mock

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.reconstruction import lookalikes, synthetic
from physagent_studio.benchmark.scenes import catalogue, lights, pictures
from physagent_studio.benchmark.scenes.catalogue import Thing

SIZE = (360, 270)
FIRST_SEED = 20_000
"""Seeds below are for building rules, for the ledger and for measuring."""
MADE_UP, STRETCHED = 0.4, 0.5
"""Shares of things that are made up, and of those stretched along their axes."""
PLAIN, STACKS, ALIKE = 0.08, 0.11, 0.12
"""Shares, each with those before, of pictures of plain solids, of stacks, of stacks all alike."""
FORMS = ("ball", "block", "can", "ball", "block", "can", "ring", "tube")


@dataclass(frozen=True, eq=False, slots=True)
class Picture:
    """A made picture and whose each of its pixels is.

    image: (H, W, 3). thing, part: (H, W) whose each pixel is, by number, or −1. asked: of how many
    things the picture is; those from there on stand around.
    """

    image: NDArray[np.uint8]
    thing: NDArray[np.int8]
    part: NDArray[np.int16]
    asked: int


def picture(seed: int) -> Picture:
    """The picture of a seed; the same bits each time."""
    kind = np.random.default_rng(seed + 77).random()
    if kind < ALIKE:
        plain = kind < PLAIN
        drawn = synthetic.scene(seed) if plain else lookalikes.stack(seed, kind > STACKS)
        return _reduced(drawn.image, drawn.masks)
    with _in_training(seed) as seen:
        found = pictures.scene(seed)
    labels = (seen[0].thing.astype(np.int8), seen[0].part.astype(np.int16))
    return Picture(found.image, *labels, len(found.stage.asked))


def _reduced(image: NDArray[np.uint8], masks: Mapping[str, NDArray[np.bool_]]) -> Picture:
    small = np.asarray(cv2.resize(image, SIZE, interpolation=cv2.INTER_AREA), np.uint8)
    thing = np.full(SIZE[::-1], -1, np.int8)
    for k, mask in enumerate(masks.values()):
        thing[cv2.resize(mask.astype(np.float32), SIZE, interpolation=cv2.INTER_AREA) > 0.5] = k
    return Picture(small, thing, thing.astype(np.int16), len(masks))


@contextmanager
def _in_training(seed: int) -> Iterator[list[Any]]:
    """Scenes are small, under fewer lamps, of stretched and made-up things; yields what is seen."""
    seen: list[Any] = []
    real, photographed = catalogue.built, pictures._photographed
    made_up = np.random.default_rng(seed).random() >= pictures.STACKED

    def built(name: str, rng: np.random.Generator) -> Thing:
        if made_up and rng.random() < MADE_UP:
            with mock.patch.dict(catalogue.listed(), {"made up": _made_up(rng)}):
                thing = real("made up", rng)
        else:
            thing = real(name, rng)
        return _stretched(thing, rng) if rng.random() < STRETCHED else thing

    def kept(rng: Any, light: Any, looked: Any, around: Any) -> Any:
        seen.append(looked)
        return photographed(rng, light, looked, around)

    small = {"SIZE": SIZE, "RIM": 8, "LEAST": 300, "built": built, "_photographed": kept}
    few = {"MAP": 200, "SUNS": 3, "SKIES": 4}
    with mock.patch.multiple(pictures, **small), mock.patch.multiple(lights, **few):
        yield seen


def _stretched(thing: Thing, rng: np.random.Generator) -> Thing:
    sides = np.exp(rng.normal(0, 0.22, 3))
    out = catalogue._each(thing, lambda points: points * sides)
    low, high = out.bounds
    return catalogue.placed(out, np.zeros(3), 1 / float((high - low).max()))


def _made_up(rng: np.random.Generator) -> dict[str, Any]:
    """A thing as `things.yaml` would say it: a body and up to six parts that stick out of it."""
    listed = catalogue.listed().values()
    kinds = sorted({kind for said in listed for kind in said["colours"].values()})
    colours = {f"c{k}": str(rng.choice(kinds)) for k in range(int(rng.integers(1, 5)))}
    body = _part(rng, 0.3, list(colours)) | {"at": [0, 0, 0.15]}
    core = np.array(body.get("size", [0.25, 0.25, 0.25]))
    parts = [body]
    for _ in range(int(rng.integers(0, 7))):
        part = _part(rng, float(rng.uniform(0.04, 0.26)), list(colours))
        way = rng.normal(0, 1, 3)
        way *= core / 2 * rng.uniform(0.7, 1.05) / np.abs(way).max()
        part["at"] = (np.array([0, 0, 0.15]) + way).tolist()
        if rng.random() < 0.4:
            part["mirror"] = True
        if rng.random() < 0.12:
            part["around"] = int(rng.integers(3, 7))
        parts.append(part)
    return {"group": "made up", "colours": colours, "parts": parts}


def _part(rng: np.random.Generator, size: float, roles: list[str]) -> dict[str, Any]:
    form = str(rng.choice(FORMS))
    paint: Any = str(rng.choice(roles))
    if rng.random() < 0.4:
        said = [p["paint"] for one in catalogue.listed().values() for p in one["parts"]]
        patterns = sorted({words[1] for words in said if len(words) > 1 and words[1:2] != words[1]})
        pattern = str(rng.choice([p for p in patterns if len(p) > 1]))
        paint = [paint, pattern, str(rng.choice(roles)), int(rng.integers(2, 7))]
    out: dict[str, Any] = {"form": form, "paint": paint}
    out["gloss"] = float(rng.choice([0.05, 0.1, 0.4, 0.7]))
    sides = np.exp(rng.normal(0, 0.45, 3)) * size
    if form == "tube":
        bends = rng.normal(0, size * 0.7, (int(rng.integers(2, 4)), 3))
        out["through"] = np.cumsum(np.vstack([np.zeros(3), bends]), 0).tolist()
        return out | {"thick": float(size * rng.uniform(0.08, 0.4))}
    if form == "ring":
        sides = np.array([size, size, size * rng.uniform(0.15, 0.4)]) * rng.uniform(0.8, 1.3)
    if form in ("can", "ball") and rng.random() < 0.6:
        sides[1] = sides[0]
    out["size"] = sides.tolist()
    if form == "can":
        out["taper"] = float(rng.choice([1, 1, rng.uniform(0.3, 1.4)]))
    if form == "block":
        out["round"] = float(rng.uniform(0.02, 0.4))
    if form != "ball" and rng.random() < 0.4:
        out["turn"] = [float(v) for v in rng.choice([0, 90, rng.uniform(0, 180)], 3)]
    return out
