"""Reconstructed scenes: whether they cover their masks, and stay at rest while nothing is done."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.aloft import AIR, in_air
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Scene
from physagent_studio.rendering import Compositor
from physagent_studio.simulation import simulate

LEAST = 300
"""Pixels of a mask from which on a thing counts."""
WELL = 0.93
"""IoU from which on what is drawn changes its form for nobody as it sets off."""


@dataclass(frozen=True, slots=True)
class Cover:
    """One thing as drawn against the photo: IoU with its mask, how far their middles are apart,
    pixels, and how alike its pixels are where both show it, dB (peak signal to noise).
    """

    name: str
    iou: float
    jump: float
    psnr: float


def covers_of(scene: Scene) -> list[Cover]:
    """Of each thing that the photo shows, drawn as it was built among the others."""
    frame = Compositor(scene).frame(as_built=True)
    out = []
    for index, item in enumerate(scene.state.objects):
        mask = scene.masks.get(item.name)
        if mask is None or np.count_nonzero(mask) < LEAST:
            continue
        drawn = frame.ids == index
        away = np.inf
        if drawn.any():
            away = float(np.linalg.norm(_middle(drawn) - _middle(mask)))
        likeness = _psnr(frame.rgb, scene.photo, drawn & mask)
        out.append(Cover(item.name, iou(drawn, mask), away, likeness))
    return out


def cover_rows(where: str, covers: Sequence[Cover]) -> list[Row]:
    """The figures of many things. where: what pictures they are of."""
    values = np.array([one.iou for one in covers])
    jumps = np.array([one.jump for one in covers])
    likeness = np.array([one.psnr for one in covers])
    covered = f"{where}: drawn solids cover their masks"
    return [
        at_least(f"{covered}, median", float(np.median(values)), 0.97),
        shown(f"{covered}, lowest", float(values.min())),
        at_least(f"{where}: share that covers {WELL} of it", float((values >= WELL).mean()), 0.9),
        at_most(f"{where}: jump as it sets off, median", float(np.median(jumps)), 1.0, "px"),
        shown(f"{where}: jump as it sets off, worst", float(jumps.max()), "px"),
        at_least(f"{where}: pixels of drawn solids, median", float(np.median(likeness)), 28, "dB"),
        shown(f"{where}: pixels of drawn solids, lowest", float(likeness.min()), "dB"),
    ]


def _psnr(drawn: Image, photo: Image | None, where: NDArray[np.bool_]) -> float:
    """How alike two pictures (H, W, 3) are in an area (H, W), dB; 0 where there is no such area."""
    if photo is None or not where.any():
        return 0.0
    error = np.square(drawn[where].astype(float) - photo[where].astype(float)).mean()
    return float(10 * np.log10(255**2 / max(error, 0.1)))


def _middle(area: NDArray[np.bool_]) -> NDArray[np.float64]:
    rows, columns = area.nonzero()
    return np.array([columns.mean(), rows.mean()])


SECONDS = 2.0
FAR = 0.02
"""How far a thing may move and still be at rest, m."""
TURNED = math.radians(5)


def movers(scene: Scene) -> tuple[str, ...]:
    """Names of objects that move or turn by themselves within two seconds.

    What the picture shows in the air is left out: it falls, and may fall on what stands.
    """
    grounded = _grounded(scene)
    program = PhysicalProgram(scene=scene.state.model_copy(update={"objects": grounded}))
    rollout = simulate(program, scene.meshes)
    last = min(round(SECONDS / program.clip.step_seconds), len(rollout.positions) - 1)
    moved = np.linalg.norm(rollout.positions[last] - rollout.positions[0], axis=1)
    same = np.abs((rollout.rotations[last] * rollout.rotations[0]).sum(-1)).clip(0, 1)
    turned = 2 * np.arccos(same)
    blown = rollout.blown_up is not None
    return tuple(
        item.name
        for k, item in enumerate(grounded)
        if blown or moved[k] > FAR or turned[k] > TURNED
    )


def _grounded(scene: Scene) -> tuple[SceneObject, ...]:
    """The objects but those in the air, and what stands on such a one."""
    kept = scene.state.objects
    falling = {item.name for item in kept if in_air(item)} | {AIR}
    while any(item.support in falling for item in kept):
        falling |= {item.name for item in kept if item.support in falling}
        kept = tuple(item for item in kept if item.name not in falling)
    return kept


def standing(scene: Scene) -> int:
    """How many objects stand on something."""
    return sum(not in_air(item) for item in scene.state.objects)
