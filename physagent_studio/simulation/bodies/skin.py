"""How the visual mesh of a deformable follows its nodes."""

from __future__ import annotations

import numpy as np

from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.surfaces import FloatArray

NEIGHBOURS = 4
"""Nodes that carry a vertex."""


def skinned(cloud: Cloud, points: FloatArray, qpos: FloatArray, kind: str) -> FloatArray:
    """Vertices (F, V, 3) world, m, of the raw states (F, nq).

    points: (V, 3) m, the first places of the vertices in the world. kind: of the body.
    """
    places = cloud.places(qpos)
    if kind in ("soft", "plastic"):
        return np.einsum("vk,fkj->fvj", _quadratic(cloud, points), places)
    if kind == "breakable":
        return _pieces(cloud, points, places, cloud.turns(qpos))
    return _blended(cloud, points, places, turning=kind in ("cloth", "rope"))


def _quadratic(cloud: Cloud, points: FloatArray) -> FloatArray:
    """(V, 27) weights of a quadratic map of the nodes' box (Lagrange on 0, ½, 1)."""
    corner, far = cloud.rest[0], cloud.rest[26]
    size = (far - corner) @ cloud.axes
    share = np.clip(((points - corner) @ cloud.axes) / size, -0.2, 1.2)
    low = 2 * (share - 0.5) * (share - 1)
    middle = 4 * share * (1 - share)
    high = 2 * share * (share - 0.5)
    line = np.stack([low, middle, high], -1)
    weights = np.einsum("vi,vj,vk->vijk", line[:, 0], line[:, 1], line[:, 2])
    return weights.reshape(len(points), 27)


def _pieces(cloud: Cloud, points: FloatArray, places: FloatArray, turns: FloatArray) -> FloatArray:
    """Every vertex stays with the piece whose middle was nearest."""
    away = np.linalg.norm(points[:, None] - cloud.rest[None], axis=-1)
    owner = np.argmin(away, axis=1)
    first = turns[0, owner]
    local = np.einsum("vji,vj->vi", first, points - cloud.rest[owner])
    return places[:, owner] + np.einsum("fvij,vj->fvi", turns[:, owner], local)


def _blended(cloud: Cloud, points: FloatArray, places: FloatArray, turning: bool) -> FloatArray:
    """Every vertex follows its nearest nodes, and turns with them where the nodes are a sheet."""
    away = np.linalg.norm(points[:, None] - cloud.rest[None], axis=-1)
    count = min(NEIGHBOURS, len(cloud.rest))
    near = np.argsort(away, axis=1, kind="stable")[:, :count]
    weight = 1 / np.maximum(np.take_along_axis(away, near, 1), 1e-6) ** 2
    weight /= weight.sum(1, keepdims=True)
    offset = points[:, None] - cloud.rest[near]
    result = np.empty((len(places), len(points), 3))
    for frame, nodes in enumerate(places):
        moved = offset
        if turning:
            moved = np.einsum("vkij,vkj->vki", _turns(cloud, nodes)[near], offset)
        result[frame] = np.einsum("vk,vki->vi", weight, nodes[near] + moved)
    return result


def _turns(cloud: Cloud, nodes: FloatArray) -> FloatArray:
    """(K, 3, 3) rotation of the surroundings of each node since the start."""
    away = np.linalg.norm(cloud.rest[:, None] - cloud.rest[None], axis=-1)
    near = np.argsort(away, axis=1, kind="stable")[:, 1:9]
    first = cloud.rest[near] - cloud.rest[:, None]
    now = nodes[near] - nodes[:, None]
    moment = np.einsum("kni,knj->kij", now, first)
    size = np.einsum("kni,kni->k", first, first)
    u, _, vt = np.linalg.svd(moment + 1e-3 * size[:, None, None] * np.eye(3))
    sign = np.ones((len(nodes), 3))
    sign[:, 2] = np.sign(np.linalg.det(u @ vt))
    return (u * sign[:, None, :]) @ vt
