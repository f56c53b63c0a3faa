"""Checks of stage 1 that hold the picture's parts against one another.

A mask, a support or a camera that is wrong by itself often fits perfectly by itself; what gives
it away is that the picture shows something that could then not be seen.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SceneObject, SceneState, Slab
from physagent_studio.reconstruction.camera.estimate import Horizon
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.shapes.silhouettes import in_world, look
from physagent_studio.records.scene import Finding, Mesh


@dataclass(frozen=True, slots=True)
class ConsistencySettings:
    """When parts of a picture contradict one another."""

    max_hidden_share: float = 0.1  # 0.05..0.6: of a seen thing behind a support as reconstructed
    max_horizon_sigmas: float = 4.0  # 2..8: between a stated horizon and that of the lines


CONSISTENT = ConsistencySettings()


def check(
    state: SceneState,
    masks: Mapping[str, BoolArray],
    meshes: Mapping[str, Mesh],
    support_meshes: Mapping[str, Mesh],
    estimate: Horizon | None,
) -> list[Finding]:
    """All checks of a completed state.

    meshes in the body frame, support_meshes in the world; estimate: the horizon that the
    picture gives by itself, None where it is not asked.
    """
    assert state.camera is not None
    out = [] if estimate is None else [_against_lines(state.camera, estimate)]
    out += [_below_horizon(item, state.camera, masks) for item in _standing(state, masks)]
    return out + _hidden(state, state.camera, masks, meshes, support_meshes)


def _against_lines(camera: Camera, estimate: Horizon) -> Finding:
    away = abs(camera.horizon - estimate.row) / max(estimate.sigma, 1.0)
    text = (
        f"the horizon is stated at row {camera.horizon:.0f}, the picture itself has it at row"
        f" {estimate.row:.0f} ± {estimate.sigma:.0f}"
    )
    most = CONSISTENT.max_horizon_sigmas
    return Finding("stated", "camera", away, most, "sigma", away <= most, "camera", text)


def _standing(state: SceneState, masks: Mapping[str, BoolArray]) -> list[SceneObject]:
    """Objects that are seen to stand on something below the eye."""
    return [
        item
        for item in state.objects
        if item.support not in (None, AIR)
        and np.any(masks.get(item.name, False))
        and not _is_high(item, state)
    ]


def _is_high(item: SceneObject, state: SceneState) -> bool:
    """Whether what carries it, in the end, reaches as high as the camera."""
    assert state.camera is not None
    below, seen = item.support or "", {item.name}
    while (carrier := state.object(below)) is not None and below not in seen:
        seen.add(below)
        below = carrier.support or ""
    support = state.support(below)
    shape = support.shape if support is not None else None
    if isinstance(shape, Slab):
        top = shape.position[2] + shape.size[2] / 2
    elif isinstance(shape, Ramp):
        top = shape.toe[2] + shape.rise
    else:
        return False
    return top >= 0.98 * state.camera.position[2]


def _below_horizon(item: SceneObject, camera: Camera, masks: Mapping[str, BoolArray]) -> Finding:
    """What stands on something level below the eye has its foot below the horizon."""
    foot = int(np.flatnonzero(masks[item.name].any(axis=1))[-1]) + 1
    above = max(0.0, (camera.horizon - foot) / camera.size[1])
    text = f"{item.name} stands lower in the photo than the horizon"
    if above:
        text = (
            f"{item.name} stands above the horizon of the photo (row {foot}, horizon at row"
            f" {camera.horizon:.0f}), where no ground is"
        )
    return Finding("foot", item.name, above, 0.0, "picture heights", above == 0, "camera", text)


def _hidden(
    state: SceneState,
    camera: Camera,
    masks: Mapping[str, BoolArray],
    meshes: Mapping[str, Mesh],
    support_meshes: Mapping[str, Mesh],
) -> list[Finding]:
    """What the picture shows cannot lie behind a support that is reconstructed before it."""
    fixed = {
        item.name: support_meshes[item.name]
        for item in state.supports
        if item.name in support_meshes and item.shape is not None and item.shape.kind != "floor"
    }
    if not fixed:
        return []
    before = look(camera, {name: (mesh.vertices, mesh.faces) for name, mesh in fixed.items()})
    out: list[Finding] = []
    for item in state.objects:
        mask = masks.get(item.name)
        if item.position is None or item.name not in meshes or mask is None or not mask.any():
            continue
        mesh = meshes[item.name]
        world = in_world(item, mesh)
        seen = look(camera, {item.name: (world, mesh.faces)})
        # Half its size of leeway: where it touches its support the two are about as far away.
        leeway = 0.5 * float(np.ptp(world, axis=0).max())
        shown = mask & np.isfinite(seen.depth)
        behind = shown & (before.depth < seen.depth - leeway)
        share = float(behind.sum() / mask.sum())
        out.append(_of_share(item.name, share, _most(before.owner[behind], tuple(fixed))))
    return out


def _most(owners: np.ndarray, names: tuple[str, ...]) -> str:
    return names[int(np.bincount(owners).argmax())] if owners.size else ""


def _of_share(name: str, share: float, by: str) -> Finding:
    fine = share <= CONSISTENT.max_hidden_share
    text = f"{name} is in front of what is behind it"
    if by:
        text = f"{share:.0%} of {name} would be hidden by {by}, and the picture shows it"
    return Finding("hidden", name, share, CONSISTENT.max_hidden_share, "", fine, "support", text)
