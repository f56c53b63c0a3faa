"""EfficientSAM (Xiong et al., CVPR 2024, arXiv 2312.00863): three masks of clicks or a box.

Inputs and outputs are those of the zoo's own runner (models/image_segmentation_efficientsam).
Encoder and decoder are one network there, so every thing costs a pass over the whole picture.
"""

from dataclasses import dataclass
from enum import IntEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.learned.network import FloatArray, Network
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

NAME = "efficientsam"


@dataclass(frozen=True, slots=True)
class SamSettings:
    """What the network takes and gives."""

    input_side_px: int = 1024  # 1024..1024: the square it sees, to which the picture is stretched
    max_points: int = 6  # count, 6..6: that it takes; a box is two of them
    min_logit: float = 0.0  # logit, -2..2: from 0 on a pixel is as likely of the thing as not


SAM = SamSettings()


class _Label(IntEnum):
    """Of points: of the thing, the corners of a box, and places that are not used."""

    INSIDE = 1
    TOP_LEFT = 2
    BOTTOM_RIGHT = 3
    PADDING = -1


def proposals(network: Network, image: Image, grounding: Grounding) -> tuple[Candidate, ...]:
    """Up to three masks (H, W), each with the IoU that the network predicts for it, best first.

    Clicks outside are no input of the network: masks that cover one are left out, as are those
    that miss a click inside. Raises ModelFailed where the network gives nothing of use.
    """
    prompt = prompt_of(grounding, image.shape)
    if prompt is None:
        return ()
    square = cv2.resize(
        image, (SAM.input_side_px, SAM.input_side_px), interpolation=cv2.INTER_LINEAR
    )
    points, labels = prompt
    logits, quality = network.run(
        {
            "batched_images": cv2.dnn.blobFromImage(square, 1 / 255),
            "batched_point_coords": points,
            "batched_point_labels": labels,
        },
        {"output_masks": (1, 1, 3, None, None), "iou_predictions": (1, 1, 3)},
    )
    found = [
        Candidate(_full_size(logit, image.shape), float(np.clip(score, 0, 1)), NAME)
        for logit, score in zip(logits[0, 0], quality[0, 0], strict=True)
    ]
    fitting = [one for one in found if one.mask.any() and _agrees(one.mask, grounding.points)]
    return tuple(sorted(fitting, key=lambda one: -one.score))


def prompt_of(grounding: Grounding, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray] | None:
    """Points (1, 1, 6, 2) in pixels of the square and their labels (1, 1, 6, 1).

    None where nothing says what is meant. shape: (H, W, …) of the picture.
    """
    marks: list[tuple[float, float, float]] = []
    if grounding.box is not None:
        (left, right), (top, low) = sorted(grounding.box[::2]), sorted(grounding.box[1::2])
        marks += [(left, top, _Label.TOP_LEFT), (right, low, _Label.BOTTOM_RIGHT)]
    marks += [(click.x, click.y, _Label.INSIDE) for click in grounding.points if click.label]
    if not marks:
        return None
    points = np.zeros((1, 1, SAM.max_points, 2), np.float32)
    labels = np.full((1, 1, SAM.max_points, 1), _Label.PADDING, np.float32)
    scale = SAM.input_side_px / shape[1], SAM.input_side_px / shape[0]
    for at, (x, y, label) in enumerate(marks[: SAM.max_points]):
        points[0, 0, at] = x * scale[0], y * scale[1]
        labels[0, 0, at] = label
    return points, labels


def _full_size(logit: FloatArray, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    size = (shape[1], shape[0])
    return np.asarray(cv2.resize(logit, size, interpolation=cv2.INTER_LINEAR) >= SAM.min_logit)


def _agrees(mask: NDArray[np.bool_], clicks: tuple[Click, ...]) -> bool:
    """Whether a mask (H, W) covers the clicks inside and none of those outside."""
    height, width = mask.shape
    return all(
        mask[min(int(one.y), height - 1), min(int(one.x), width - 1)] == bool(one.label)
        for one in clicks
        if one.x >= 0 and one.y >= 0
    )
