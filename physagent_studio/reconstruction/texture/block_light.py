"""The light on a block of one colour: its sides differ by how bright they are, and not in hue.

What its top, its front and its end show tells of the light from three directions; the rest follows
as the weakest light that explains them. A block that turns then gets the light of where its sides
face, instead of taking it along.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.forms import Box
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import shrink
from physagent_studio.records.case import Image
from physagent_studio.rendering.lit import DARK, terms_of


@dataclass(frozen=True, slots=True)
class BlockLightSettings:
    """When sides of a block differ by their light alone."""

    min_side_px: int = 60  # 20..500: of a side, for its colour to be known
    min_facing_cosine: float = 0.9  # cosine, 0.7..0.99: of what belongs to a side and no edge
    max_hue_log: float = 0.16  # 0.05..0.4: between two sides; more is paint
    # 0.03..2: by how much the brightest side is brighter than the darkest; less is
    # nothing, more is paint
    range_log: tuple[float, float] = (0.08, 1.3)
    max_spread_log: float = 0.25  # 0.05..0.6: of the brightness on one side; more is a picture
    # log, 0..0.5: by which the top may be darker than another side: light comes from above
    max_under_log: float = 0.12
    rim_px: int = 3  # 1..8: of a side, in which the next one may be seen
    rim_off_log: float = 0.15  # 0.05..0.5: by which that differs from the side's own colour
    pull_share: float = 0.01  # 0.001..0.1: how strongly light is drawn to come from everywhere


BLOCK_LIGHT = BlockLightSettings()


def is_block(item: SceneObject) -> bool:
    """Whether it is a solid block."""
    return isinstance(item.shape, Box) and item.shape.wall is None


def block_terms(
    photo: Image, normals: FloatArray, inner: BoolArray, item: SceneObject
) -> FloatArray | None:
    """(16, 3) terms of the log of light on a block; None where its sides may be painted.

    photo: (H, W, 3). normals: (H, W, 3) unit, world. inner: (H, W) where it is seen.
    """
    sides = _sides(photo, normals, inner, item)
    if len(sides) < 2:
        return None
    ways, colours, spreads = (np.array(part) for part in zip(*sides, strict=True))
    tones = colours.mean(1)
    hues = colours - tones[:, None]
    apart = max(float(np.linalg.norm(one - other)) for one in hues for other in hues)
    low, high = BLOCK_LIGHT.range_log
    if apart > BLOCK_LIGHT.max_hue_log or not low < float(np.ptp(tones)) < high:
        return None
    if spreads.max() > BLOCK_LIGHT.max_spread_log:
        return None
    if tones[ways[:, 2].argmax()] < tones.max() - BLOCK_LIGHT.max_under_log:
        return None
    steps = np.column_stack([np.ones(len(ways)), ways])
    pull = BLOCK_LIGHT.pull_share * np.diag([0.0, 1.0, 1.0, 1.0])
    light = np.linalg.solve(steps.T @ steps + pull, steps.T @ (tones - tones.mean()))
    out = np.zeros((terms_of(ways[:1]).shape[1], 3))
    out[:4] = light[:, None]
    # The usual side keeps the colour that it has.
    seen = terms_of(normals[inner]) @ out
    out[0] -= np.median(seen, axis=0)
    return out


def evened_rims(plain: Image, normals: FloatArray, inner: BoolArray, item: SceneObject) -> Image:
    """A block's picture without its light (H, W, 3), in which no rim of a side of one colour is far
    from it: a fit that is a pixel off has what the next side shows there, in the wrong light.

    normals, inner: as for `block_terms`.
    """
    turn, out = matrix_of(item.rotation), plain.copy()
    for axis in range(3):
        for sign in (-1.0, 1.0):
            own = inner & (sign * (normals @ turn[:, axis]) > BLOCK_LIGHT.min_facing_cosine)
            core = shrink(own, BLOCK_LIGHT.rim_px)
            if np.count_nonzero(core) < BLOCK_LIGHT.min_side_px:
                continue
            logs = np.log(plain[core].astype(np.float64) + DARK)
            usual = np.median(logs, axis=0)
            spread = 1.5 * float(np.median(np.abs(logs.mean(-1) - usual.mean())))
            rim = own & ~core
            far = np.abs(np.log(plain[rim].astype(np.float64) + DARK) - usual).max(-1)
            off = far > BLOCK_LIGHT.rim_off_log + 3 * spread
            values = out[rim]
            values[off] = np.clip(np.exp(usual) - DARK + 0.5, 0, 255).astype(np.uint8)
            out[rim] = values
    return out


def _sides(
    photo: Image, normals: FloatArray, inner: BoolArray, item: SceneObject
) -> list[tuple[FloatArray, FloatArray, float]]:
    """Of each side that is seen: its normal (3,), world, the log of its usual colour (3,), and how
    far its brightness strays, log."""
    turn = matrix_of(item.rotation)
    logs = np.log(photo[inner].astype(np.float64) + DARK)
    facing = normals[inner] @ turn
    found = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            own = sign * facing[:, axis] > BLOCK_LIGHT.min_facing_cosine
            if np.count_nonzero(own) < BLOCK_LIGHT.min_side_px:
                continue
            colour = np.median(logs[own], axis=0)
            tone = logs[own].mean(-1)
            spread = 1.5 * float(np.median(np.abs(tone - np.median(tone))))
            found.append((sign * turn[:, axis], colour, spread))
    return found
