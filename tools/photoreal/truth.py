"""The truth file beside a picture, and the case that a person would have written for it.

Field names and conventions are those of the program format (docs/program.md): metres,
world +x right, +y away from the camera, +z up, quaternions wxyz, pixel (i, j) covers
[i, i+1) × [j, j+1).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from photoreal.stage import Item, Lens


def quaternion(matrix: NDArray[np.floating]) -> list[float]:
    """Unit quaternion wxyz, w ≥ 0, of a rotation matrix, from its largest component."""
    m = np.asarray(matrix, float)
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)],
        ]
    )
    x, y, z, w = np.linalg.eigh(k / 3)[1][:, -1]
    q = np.array([w, x, y, z]) * (1 if w >= 0 else -1)
    return [round(float(part), 9) + 0.0 for part in q]


def planes(wall: float) -> list[dict[str, Any]]:
    """The floor z = 0 and the wall y = `wall`, as supports."""
    return [
        {"name": "floor", "shape": {"kind": "floor", "height": 0.0}},
        {"name": "wall", "shape": {"kind": "wall", "point": [0.0, wall, 0.0], "yaw": -math.pi / 2}},
    ]


def truth_of(
    items: Sequence[Item],
    lens: Lens,
    ids: NDArray[np.uint8],
    unseen: Sequence[dict[str, Any]],
    **more: Any,
) -> dict[str, Any]:
    """Everything that is known about the picture, as plain JSON values.

    unseen: supports that have no number in `ids`.
    """
    camera = {
        "size": list(lens.size),
        "focal": round(lens.focal, 6),
        "principal": [lens.size[0] / 2, lens.size[1] / 2],
        "position": list(lens.position),
        "rotation": quaternion(lens.rotation),
    }
    horizon = lens.size[1] / 2 - lens.focal * np.tan(lens.pitch)
    known = [entry(item, ids) for item in items if item.truth]
    return {
        "camera": camera,
        "horizon": round(float(horizon), 4),
        "objects": [e for e in known if e["role"] == "object"],
        "supports": [*unseen, *(e for e in known if e["role"] == "support")],
        **more,
    }


def entry(item: Item, ids: NDArray[np.uint8]) -> dict[str, Any]:
    """A body's own entry with its pose and what the mask shows of it."""
    assert item.truth is not None
    entry = dict(item.truth)
    if entry["role"] == "object":
        entry["position"] = [round(float(p), 9) for p in item.position]
        entry["rotation"] = quaternion(item.rotation)
    mask = ids == entry["id"]
    ys, xs = np.nonzero(mask)
    entry["pixels"] = int(mask.sum())
    entry["bounds"] = [int(xs.min()), int(ys.min()), int(xs.max()) + 1, int(ys.max()) + 1]
    return entry


def click(mask: NDArray[np.bool_]) -> tuple[int, int]:
    """The pixel (x, y) farthest inside a mask, where a person would click."""
    inside = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    y, x = np.unravel_index(int(np.argmax(inside)), inside.shape)
    return int(x), int(y)


def _numbered(truth: dict[str, Any]) -> list[dict[str, Any]]:
    return [e for role in ("objects", "supports") for e in truth[role] if "id" in e]


def write_case(
    folder: Path,
    image: str,
    truth: dict[str, Any],
    ids: NDArray[np.uint8],
    events: dict[str, str],
    second: Mapping[str, tuple[int, int]] | None = None,
) -> None:
    """`case.yaml`, `truth.json` and `ids.png`.

    second: a further click for a body whose faces look unlike each other.
    """
    clicks = {e["name"]: [click(ids == e["id"])] for e in _numbered(truth)}
    for name, pixel in (second or {}).items():
        clicks[name].append(pixel)
    grounding = {
        role: {
            e["name"]: {"points": [[x, y, 1] for x, y in clicks[e["name"]]]}
            for e in truth[role]
            if "id" in e
        }
        for role in ("objects", "supports")
    }
    case = {"image": image, "size": truth["camera"]["size"], **grounding, "events": events}
    text = yaml.safe_dump(case, sort_keys=False, allow_unicode=True, width=10_000)
    (folder / "case.yaml").write_text(text, encoding="utf-8")
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    cv2.imwrite(str(folder / "ids.png"), ids, [cv2.IMWRITE_PNG_COMPRESSION, 9])
