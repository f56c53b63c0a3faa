"""Job folders: what a runner in another environment is given, and what it gives back.

job/    job.json, image.png, masks/0.png …          written by us
job/result/    result.json and what it names         written by the runner
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.strokes import seeds_of
from physagent_studio.records.case import Image

VERSION = 1
RUNNERS = Path(__file__).resolve().parent / "runners"


def write_job(
    folder: Path,
    kind: str,
    image: Image,
    groundings: Sequence[tuple[str, Grounding]],
    masks: Mapping[str, BoolArray],
    intrinsics: NDArray[np.float64] | None,
    seed: int = 0,
) -> None:
    """Write a job. kind: `sam3d` or `sam2`. intrinsics: (3, 3), pixels."""
    (folder / "masks").mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "image.png"), cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    objects: list[dict[str, Any]] = []
    for index, (name, grounding) in enumerate(groundings):
        entry: dict[str, Any] = {
            "name": name,
            "points": _points(grounding, image),
            "box": grounding.box,
        }
        if name in masks:
            entry["mask"] = f"masks/{index}.png"
            cv2.imwrite(str(folder / entry["mask"]), masks[name].astype(np.uint8) * 255)
        objects.append(entry)
    job = {
        "version": VERSION,
        "kind": kind,
        "image": "image.png",
        "seed": seed,
        "intrinsics": None if intrinsics is None else intrinsics.tolist(),
        "objects": objects,
    }
    text = json.dumps(job, indent=1, allow_nan=False)
    (folder / "job.json").write_text(text, encoding="utf-8")


def _points(grounding: Grounding, image: Image) -> list[list[float]]:
    """[x, y, label] of clicks, and of some points on each stroke that lie in the picture.

    A stroke that erases, and what lies outside a cut, is label 0.
    """
    height, width = image.shape[:2]
    out = [[click.x, click.y, click.label] for click in grounding.points]
    for x, y, within in seeds_of(grounding.strokes):
        if 0 <= x < width and 0 <= y < height:
            out.append([x, y, int(within)])
    return out


def read_result(folder: Path, kind: str) -> list[dict[str, Any]]:
    """The entries of a result folder.

    Raises BackendMissing where nothing ran yet, InputError where the result is not readable.
    """
    path = folder / "result" / "result.json"
    if not path.is_file():
        raise BackendMissing(
            f"the job in {folder} has no result yet; run"
            f" `python {RUNNERS / f'{kind}_runner.py'} {folder}` where {kind} is installed"
        )
    if path.stat().st_size > 2**22:
        raise InputError(f"{path} is too large to be a result")
    try:
        result = json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_constant)
        entries = result["objects"]
        fits = result["version"] == VERSION and result["kind"] == kind
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path} is no result of {kind}: {error}") from error
    if not fits or not isinstance(entries, list):
        raise InputError(f"{path} is not a result of {kind}, version {VERSION}")
    return entries


def inside(folder: Path, name: object) -> Path:
    """A file that a result names; it has to lie in the result folder."""
    base = (folder / "result").resolve()
    path = (base / str(name)).resolve()
    if not path.is_relative_to(base) or not path.is_file():
        raise InputError(f"the result names '{name}', which is not in {base}")
    return path


def numbers(entry: Mapping[str, Any], field: str, count: int) -> NDArray[np.float64]:
    """A finite vector of a result's entry."""
    try:
        values = np.asarray(entry[field], float).reshape(-1)
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(f"the result of '{entry.get('name')}' has no {field}") from error
    if len(values) not in (count, 1) or not np.isfinite(values).all():
        raise InputError(f"the {field} of '{entry.get('name')}' are not {count} finite numbers")
    return values


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a number")
