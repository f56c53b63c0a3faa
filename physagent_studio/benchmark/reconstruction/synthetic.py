"""Small pictures with exact truth: primitives on a textured floor, drawn by our own rasteriser.

They are plainer than photographs on purpose: what they measure is geometry, not taste.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Grounding, SceneObject
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.masks.segmenter import Cancelled
from physagent_studio.reconstruction.shapes.silhouettes import in_world, look
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate


class TrueMasks:
    """A `Segmenter` that knows the answer: it measures everything after the masks alone."""

    def __init__(self, masks: Mapping[str, BoolArray]) -> None:
        self.masks = masks

    def segment(
        self, image: Image, groundings: Sequence[tuple[str, Grounding]], cancelled: Cancelled = None
    ) -> dict[str, tuple[Candidate, ...]]:
        """The known masks, one candidate each."""
        return {name: (Candidate(self.masks[name], 1.0, "truth"),) for name, _ in groundings}


SIZE = (640, 400)
LIGHT = np.array([-0.45, -0.5, 0.74])


@dataclass(frozen=True, eq=False, slots=True)
class Drawn:
    """A picture with its truth. masks: what is visible of each object, (H, W)."""

    image: Image
    camera: Camera
    objects: tuple[SceneObject, ...]
    masks: dict[str, BoolArray]


def scene(seed: int, count: int = 3, roll: float = 0.0) -> Drawn:
    """A random scene: `count` objects on the floor, some in front of others.

    roll: radians by which the camera is turned clockwise.
    """
    rng = np.random.default_rng(seed)
    pitch = math.radians(rng.uniform(6, 28))
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    horizon = SIZE[1] / 2 - focal * math.tan(pitch)
    camera = Camera.from_horizon(
        SIZE, horizon, 1.0, focal=focal, roll=roll, source="given", confirmed=True
    )
    objects: list[SceneObject] = []
    places: list[tuple[float, float]] = []
    while len(objects) < count:
        x, y = _place(rng, camera, places)
        places.append((x, y))
        objects.append(_thing(rng, f"object_{len(objects) + 1}", x, y))
    return _drawn(rng, camera, tuple(objects))


def _place(
    rng: np.random.Generator, camera: Camera, taken: list[tuple[float, float]]
) -> tuple[float, float]:
    """A place on the floor in view, some distance from the others."""
    for _ in range(200):
        x, y = float(rng.uniform(-0.9, 0.9)), float(rng.uniform(2.2, 4.2))
        pixel = camera.project(np.array([[x, y, 0.15]]))[0][0]
        inside = 90 < pixel[0] < SIZE[0] - 90 and 90 < pixel[1] < SIZE[1] - 40
        if inside and all(math.hypot(x - a, y - b) > 0.55 for a, b in taken):
            return x, y
    return 0.0, 3.0 + 0.6 * len(taken)


def _thing(rng: np.random.Generator, name: str, x: float, y: float) -> SceneObject:
    kind = ("sphere", "box", "cylinder", "ellipsoid", "capsule")[int(rng.integers(5))]
    a, b, c = (float(v) for v in rng.uniform(0.22, 0.46, 3))
    yaw = 0.0
    shape: forms.Shape
    if kind == "sphere":
        shape, lift = forms.Sphere(radius=a / 2), a / 2
    elif kind == "ellipsoid":
        shape, lift = forms.Ellipsoid(radii=(a / 2, a / 2, b / 2)), b / 2
    elif kind == "cylinder":
        shape, lift = forms.Cylinder(radius=a / 2, height=b), b / 2
    elif kind == "capsule":
        shape, lift = forms.Capsule(radius=a / 3, height=a / 1.5 + b / 2), a / 3 + b / 4
    else:
        shape, lift, yaw = forms.Box(size=(a, b, c)), c / 2, float(rng.uniform(-0.7, 0.7))
    return SceneObject(name=name, shape=shape, position=(x, y, lift), rotation=about_up(yaw))


def _drawn(rng: np.random.Generator, camera: Camera, objects: tuple[SceneObject, ...]) -> Drawn:
    bodies = {}
    for item in objects:
        assert item.shape is not None
        mesh = mesh_of(item.shape)
        bodies[item.name] = (in_world(item, mesh), mesh.faces)
    image = backdrop(rng, camera)
    _shade_ground(image, camera, objects)
    seen = look(camera, bodies)
    masks: dict[str, BoolArray] = {}
    for index, (name, (vertices, faces)) in enumerate(bodies.items()):
        mask = np.asarray(seen.owner == index)
        masks[name] = mask
        color = rng.uniform(50, 235, 3)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        light = 0.45 + 0.6 * np.maximum(normal @ LIGHT, 0)
        image[mask] = color * light[seen.face[mask]][:, None]
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image += rng.normal(0, 2.5, image.shape)
    return Drawn(np.clip(image, 0, 255).astype(np.uint8), camera, objects, masks)


def backdrop(rng: np.random.Generator, camera: Camera) -> FloatArray:
    """A mottled floor that ends at a wall 7 m away."""
    width, height = camera.size
    columns, rows = np.meshgrid(
        np.linspace(0.5, width - 0.5, width), np.linspace(0.5, height - 0.5, height)
    )
    rays = camera.rays(np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64))
    rays = rays.reshape(height, width, 3)
    along = -camera.position[2] / np.minimum(rays[..., 2], -1e-6)
    x, y = rays[..., 0] * along, rays[..., 1] * along
    floor = (rays[..., 2] < 0) & (y < 7)
    noise = rng.normal(0, 1, (256, 256)).astype(np.float32)
    noise = cv2.GaussianBlur(noise, (0, 0), 2.0, borderType=cv2.BORDER_REFLECT)
    noise /= noise.std()
    u = ((x * 40) % 256).astype(np.float32)
    v = ((y * 40) % 256).astype(np.float32)
    mottle = cv2.remap(noise, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    ground, wall = rng.uniform(90, 190, 3), rng.uniform(120, 220, 3)
    out = np.where(floor[..., None], ground + 7 * mottle[..., None], wall)
    return out.astype(float)


def _shade_ground(image: FloatArray, camera: Camera, objects: tuple[SceneObject, ...]) -> None:
    """A soft dark patch where each object stands."""
    for item in objects:
        assert item.position is not None
        x, y, lift = item.position
        turn = np.linspace(0, 2 * math.pi, 40)
        ring = np.stack([x + 0.2 * np.cos(turn) + 0.06, y + 0.2 * np.sin(turn), 0 * turn], 1)
        pixels = camera.project(ring)[0]
        patch = np.zeros(image.shape[:2], np.float32)
        cv2.fillPoly(patch, [pixels.astype(np.int32)], 1.0)
        patch = cv2.GaussianBlur(patch, (0, 0), 8)
        image *= (1 - 0.3 * patch * min(1.0, 0.3 / max(lift, 0.05)))[..., None]
