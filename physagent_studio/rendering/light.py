"""Light on objects. A photo's texture already carries its light, so only the change counts."""

import numpy as np

from physagent_studio.rendering.raster import FloatArray

LIGHT = np.array([-0.30, -0.40, 1.0]) / np.linalg.norm([-0.30, -0.40, 1.0])
"""Direction towards the usual light, world: from above, a little left and towards the camera."""

_AMBIENT = 0.70
_LOWEST, _HIGHEST = 0.75, 1.20


def linear_of(srgb: FloatArray) -> FloatArray:
    """sRGB 0 … 1 as linear light (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def srgb_of(linear: FloatArray) -> FloatArray:
    """Linear light 0 … 1 as sRGB."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def lambert(cosine: FloatArray, ambient: float = _AMBIENT) -> FloatArray:
    """Brightness at this cosine between normal and light; 1 where it falls straight on.

    The cosine is wrapped around the terminator, as under a large soft light.
    """
    return ambient + (1 - ambient) * (0.5 + 0.5 * cosine)


def relative(cosine: FloatArray, initial: FloatArray) -> FloatArray:
    """How much brighter than in the photo; exactly 1 where nothing has turned.

    cosine, initial: between normal and light, now and at the initial pose.
    """
    return np.clip(lambert(cosine) / lambert(initial), _LOWEST, _HIGHEST)
