"""One network in OpenCV: its inputs by name in, outputs of a known shape and finite out."""

import threading
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.learned.zoo import ModelFailed

FloatArray = NDArray[np.float32]
Shape = tuple[int | None, ...]
"""Sizes that an output has to have; None for any."""


class Network:
    """A network that was read from an ONNX file; one thread at a time runs it, the others wait."""

    def __init__(self, data: bytes) -> None:
        """data: an ONNX file. Raises ModelFailed where OpenCV cannot read it."""
        self._alone = threading.Lock()
        try:
            self._net = cv2.dnn.readNetFromONNX(np.frombuffer(data, np.uint8))
        except cv2.error as error:
            raise ModelFailed(f"OpenCV cannot read the network: {error.err}") from error

    def run(
        self, inputs: Mapping[str, NDArray[Any]], outputs: Mapping[str, Shape]
    ) -> tuple[FloatArray, ...]:
        """The outputs of those names, in their order; "" is the first that the network has.

        Raises ModelFailed where the network does not run, or an output has another shape or is
        not finite.
        """
        try:
            with self._alone:
                for name, values in inputs.items():
                    self._net.setInput(values, name)
                first = self._net.getUnconnectedOutLayersNames()[0]
                found = self._net.forward([name or first for name in outputs])
                # OpenCV lends its own memory, which the next run writes over.
                made = tuple(np.array(one, np.float32) for one in found)
        except cv2.error as error:
            raise ModelFailed(f"the network does not run: {error.err}") from error
        for (name, wanted), values in zip(outputs.items(), made, strict=True):
            _check(name, wanted, values)
        return made


def _check(name: str, wanted: Shape, values: FloatArray) -> None:
    fits = len(wanted) == values.ndim and all(
        size is None or size == other for size, other in zip(wanted, values.shape, strict=True)
    )
    if not fits or not values.size:
        raise ModelFailed(f"the network's output {name} has the shape {values.shape}, not {wanted}")
    if not np.isfinite(values).all():
        raise ModelFailed(f"the network's output {name} has values that are not finite")
