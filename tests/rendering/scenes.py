"""Scenes made by hand."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import trimesh

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Floor,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.records.rollout import CONTACT_DTYPE, Rollout
from physagent_studio.records.scene import Mesh, Scene

SIZE = (208, 120)


def mesh_of(shape: trimesh.Trimesh, **kwargs) -> Mesh:
    return Mesh(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int32), **kwargs)


def scene_of(objects, meshes, supports=(), support_meshes=None, camera=None, **kwargs) -> Scene:
    """A scene of `objects` (SceneObject) with `meshes` by name."""
    return Scene(
        state=SceneState(
            camera=camera or Camera.from_horizon(SIZE, 30, 1.2),
            objects=tuple(objects),
            supports=tuple(supports),
        ),
        photo=kwargs.get("photo"),
        plate=kwargs.get("plate"),
        masks=MappingProxyType(kwargs.get("masks", {})),
        meshes=MappingProxyType(meshes),
        support_meshes=MappingProxyType(support_meshes or {}),
        candidates=MappingProxyType({}),
        findings=(),
        hash="by hand",
    )


def ball(position=(0.0, 3.0, 0.25), radius=0.25, name="ball", subdivisions=4, **kwargs):
    item = SceneObject(name=name, shape=Sphere(radius=radius), position=position, **kwargs)
    return item, mesh_of(trimesh.creation.icosphere(subdivisions, radius))


def crate(position=(0.6, 2.6, 0.2), size=(0.3, 0.4, 0.4), name="crate", **kwargs):
    item = SceneObject(name=name, shape=Box(size=size), position=position, **kwargs)
    return item, mesh_of(trimesh.creation.box(size))


def table(position=(0.0, 3.0, 0.25), size=(1.0, 0.8, 0.5), name="table"):
    support = Support(name=name, shape=Slab(position=position, size=size))
    shape = trimesh.creation.box(size)
    shape.apply_translation(position)
    return support, mesh_of(shape)


FLOOR = Support(name="floor", shape=Floor())


def rollout_of(names, positions, rotations, **kwargs) -> Rollout:
    """A rollout with one step per frame: positions (T, N, 3), rotations (T, N, 4)."""
    frames, count = positions.shape[:2]
    zeros = np.zeros((frames, count, 3))
    return Rollout(
        program_hash="by hand",
        objects=tuple(names),
        bodies=tuple(names),
        step_seconds=0.04,
        steps_per_frame=1,
        frames=kwargs.pop("frames", frames),
        positions=positions,
        rotations=rotations,
        velocities=zeros,
        angular=zeros,
        contacts=np.zeros(0, CONTACT_DTYPE),
        kinetic=np.zeros((frames, count)),
        potential=np.zeros((frames, count)),
        masses=np.ones(count),
        penetration=np.zeros(frames),
        spans=(),
        warnings=(),
        versions=(),
        **kwargs,
    )
