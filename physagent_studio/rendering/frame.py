"""`Frame`: one rendered picture with its per-pixel truth, and `Flow` between two of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.raster import FloatArray, Hits, IntArray, Lens

Picture = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """What a frame's pixels touch, kept so that flow can follow it.

    hits: pixels that see an object and are not hidden by a support. points: (V, 3) vertices of
    all objects in the camera frame, m. faces: (F, 3) rows of `points`. lens: the projection.
    """

    hits: Hits
    points: FloatArray
    faces: IntArray
    lens: Lens


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """A rendered picture.

    rgb: (H, W, 3) uint8. ids: (H, W) int16, index into `scene.state.objects`, −1 for the
    background. depth: (H, W) float32 along the optical axis, m; inf where there is no object.
    """

    rgb: Picture
    ids: NDArray[np.int16]
    depth: NDArray[np.float32]
    surface: Surface


@dataclass(frozen=True, eq=False, slots=True)
class Flow:
    """Forward motion in the picture from one frame to the next.

    vectors: (H, W, 2) float32, pixels, (x, y); 0 on the background, since the camera stands
    still. visible: (H, W) bool, whether what the pixel shows is still seen in the next frame.
    """

    vectors: NDArray[np.float32]
    visible: NDArray[np.bool_]
