"""A case of PhysGen: `sim.yaml`, the picture `original.png` and the labels of things `mask.png`.

Its world is the picture: pixels are centimetres, y goes down, gravity is 980. Speeds keep the ratio
of motion to weight (v² over g and length) in ours, where a thing has its metric size; without
gravity the picture is seen from above, and a thing moves on it as there.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_reader import slug
from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.peer_config import PeerObject, PeerSetup, photo_beside
from physagent_studio.exchange.peers.schedule import Motion, Push
from physagent_studio.exchange.plain_yaml import MAX_BYTES, PlainYaml, read_yaml
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction import read_photo
from physagent_studio.records.case import Case

_PHOTOS = ("original.png", "input.png", "original.jpg")
_LOOKS_ONLY = ("cat", "display", "save_snapshot", "denoise_strength", "size", "relight")
_READ = ("obj_info", "gravity", "init_velocity", "init_acc", "ground_friction")
_GRAVITY = 980.0
MOST_THINGS = 60
"""Things of one picture that are read."""


def load_physgen(path: Path, names: Sequence[str] = (), prompt: str = "") -> PeerSetup:
    """The case of a `sim.yaml`; without a prompt the sentence is made of its labels.

    Raises:
        InputError: in one sentence, with file and line.
    """
    doc = _document(path)
    pixels, image_hash = read_photo(photo_beside(path, _PHOTOS))
    labels = _labels(path, (pixels.shape[1], pixels.shape[0]))
    things = _things(path, doc)
    called = [slug(name) for name in names] or _names([one for _, one in things])
    if len(called) != len(things) or len(set(called)) != len(called) or "" in called:
        raise InputError(f"{path} has {len(things)} objects, so as many names are needed")
    grounded = [_grounding(path, labels, number) for number, _ in things]
    gravity = _number(path, doc, ("gravity",), doc.data.get("gravity"), _GRAVITY)
    pushes, moved = [], []
    for name, (number, _) in zip(called, things, strict=True):
        way = _speed(path, doc, number)
        if any(way):
            moved.append(name)
            pushes.append(Push(name, way, 1.0, level=gravity == 0, weight=gravity))
    said = prompt or f"The {' and the '.join(moved or called)} moves.".replace("_", " ")
    case = Case(
        name=slug(str(doc.data.get("cat") or path.parent.name)) or "case",
        image=pixels,
        image_hash=image_hash,
        objects=tuple(zip(called, grounded, strict=True)),
        prompt=said,
        event="given" if prompt else "moves",
        events=(("given" if prompt else "moves", said),),
    )
    known = {*_LOOKS_ONLY, *_READ}
    left_out = [str(key) for key in doc.data if key not in known and doc.data[key] is not None]
    left_out += [f"obj_info.{n}.mass" for n, info in things if info.get("mass") is not None]
    return PeerSetup(
        case=case,
        objects=tuple(
            _object(path, doc, n, i, info) for n, (i, info) in zip(called, things, strict=True)
        ),
        gravity=(0.0, 0.0, -9.81 * gravity / _GRAVITY) if gravity else None,
        floor_friction=_optional(path, doc, ("ground_friction",), doc.data.get("ground_friction")),
        left_out=tuple(left_out),
        motion=Motion(pushes=tuple(pushes)),
    )


def _document(path: Path) -> PlainYaml:
    doc = read_yaml(text_of(path, MAX_BYTES), str(path), last_wins=True)
    if not isinstance(doc.data, dict) or not isinstance(doc.data.get("obj_info"), dict):
        raise InputError(f"{path} is no sim.yaml of PhysGen (no obj_info)")
    return doc


def _labels(path: Path, size: tuple[int, int]) -> np.ndarray:
    """(H, W) number of the thing, in the size of the photo; decoded where pictures are."""
    found, _ = read_photo(path.parent / "mask.png")
    grey = found[..., 0]
    if (found[..., 1] != grey).any() or (found[..., 2] != grey).any():
        raise InputError(f"{path.parent / 'mask.png'} has colours; its grey levels are the things")
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_NEAREST))


def _things(path: Path, doc: PlainYaml) -> list[tuple[int, Mapping[str, Any]]]:
    found = []
    for key, info in doc.data["obj_info"].items():
        if not (str(key).isdecimal() and 0 < int(key) < 256 and isinstance(info, dict)):
            line = doc.line(("obj_info", str(key)))
            raise InputError(f"{path}, line {line}: obj_info must name grey levels 1 … 255")
        found.append((int(key), info))
    if not 0 < len(found) <= MOST_THINGS:
        raise InputError(f"{path} has {len(found)} objects (1 … {MOST_THINGS} are read)")
    return found


def _names(infos: Sequence[Mapping[str, Any]]) -> list[str]:
    """Their labels, numbered where several are called alike."""
    words = [slug(str(info.get("label") or "thing")) or "thing" for info in infos]
    return [
        word if words.count(word) == 1 else f"{word}_{words[: n + 1].count(word)}"
        for n, word in enumerate(words)
    ]


def _grounding(path: Path, labels: np.ndarray, number: int) -> Grounding:
    """A click where the thing is widest, and a box around it."""
    mask = (labels == number).astype(np.uint8)
    if not mask.any():
        raise InputError(f"{path.parent / 'mask.png'} shows nothing of grey level {number}")
    deep = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    y, x = np.unravel_index(int(deep.argmax()), deep.shape)
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    left, top, right, bottom = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
    click = Click(x=float(x) + 0.5, y=float(y) + 0.5, label=1)
    box = (float(left), float(top), float(right), float(bottom))
    return Grounding(points=(click,), box=box)


def _object(
    path: Path, doc: PlainYaml, name: str, number: int, info: Mapping[str, Any]
) -> PeerObject:
    def kept(key: str, low: float, high: float, unit: float = 1.0) -> float | None:
        found = _optional(path, doc, ("obj_info", str(number), key), info.get(key))
        return None if found is None else min(max(unit * found, low), high)

    density, friction = kept("density", 0.1, 30000.0, 1000.0), kept("friction", 0.0, 5.0)
    return PeerObject(name, density, friction, restitution=kept("elasticity", 0.0, 1.0))


def _speed(path: Path, doc: PlainYaml, number: int) -> tuple[float, float]:
    """Pixels a second at the start; their first acceleration is an impulse by the mass."""
    total = [0.0, 0.0]
    for key in ("init_velocity", "init_acc"):
        by_thing = doc.data.get(key) or {}
        if not isinstance(by_thing, dict):
            raise InputError(f"{path}, line {doc.line((key,))}: {key} must name grey levels")
        said = by_thing.get(str(number))
        if said is None:
            continue
        if not isinstance(said, list) or len(said) != 2:
            line = doc.line((key, str(number)))
            raise InputError(f"{path}, line {line}: {key} must be [x, y]")
        for axis in (0, 1):
            total[axis] += _number(path, doc, (key, str(number)), said[axis], 0.0)
    return total[0], total[1]


def _number(
    path: Path, doc: PlainYaml, place: tuple[str, ...], value: Any, default: float
) -> float:
    found = _optional(path, doc, place, value)
    return default if found is None else found


def _optional(path: Path, doc: PlainYaml, place: tuple[str, ...], value: Any) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{path}, line {doc.line(place)}: {place[-1]} must be a number")
    return float(value)
