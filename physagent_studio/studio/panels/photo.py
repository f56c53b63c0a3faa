"""Photo: the picture with its objects outlined, and the sentence."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.workbench import Snapshot


def state_of(snapshot: Snapshot) -> dict[str, Any]:
    """Address and size of the picture, outlines and clicks in its pixels."""
    case, scene = snapshot.case, snapshot.scene
    image = None if case is None else case.image
    if image is None:
        return {"image": None, "prompt": snapshot.program.event.prompt}
    assert case is not None
    return {
        "image": f"/photo/{case.image_hash}.jpg",
        "size": [image.shape[1], image.shape[0]],
        "prompt": snapshot.program.event.prompt or case.prompt,
        "objects": [
            {
                "name": item.name,
                "outline": outline_of(scene.masks[item.name])
                if scene is not None and item.name in scene.masks
                else [],
                "clicks": [[click.x, click.y, click.label] for click in item.grounding.points],
            }
            for item in snapshot.program.scene.objects
        ],
        "supports": [
            {
                "name": item.name,
                "clicks": [[click.x, click.y, click.label] for click in item.grounding.points],
            }
            for item in snapshot.program.scene.supports
        ],
    }


def outline_of(mask: NDArray[np.bool_]) -> list[list[list[int]]]:
    """Polygons around a mask (H, W), in pixels, thinned to about a pixel's accuracy."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    large = [one for one in found if cv2.contourArea(one) >= 12]
    thinned = [cv2.approxPolyDP(one, 1.0, closed=True) for one in large]
    return [[[int(x), int(y)] for x, y in one.reshape(-1, 2)] for one in thinned if len(one) >= 3]
