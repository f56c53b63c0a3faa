"""Rendered look-alikes of what photographs show and is hard to cut out: stacks, thin poles.

Exact masks come with each picture, so that methods are judged on pictures that nobody tuned to.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.benchmark.reconstruction.synthetic import LIGHT, backdrop
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, Cylinder, Shape
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.shapes.silhouettes import look
from physagent_studio.records.case import Image

SIZE = (832, 480)
PAPER = np.array([212.0, 203.0, 186.0])
COVER = 0.012
"""Thickness of a book's boards, m."""


@dataclass(frozen=True, eq=False, slots=True)
class Lookalike:
    """A picture, and what is visible of each thing in it by name, (H, W), in the order drawn."""

    image: Image
    masks: dict[str, BoolArray]


@dataclass(frozen=True, eq=False, slots=True)
class _Part:
    """A piece of a thing: vertices (V, 3) in the world, faces (F, 3), colour, grain 0 … 255."""

    owner: str
    vertices: FloatArray
    faces: NDArray[np.int32]
    color: FloatArray
    grain: float = 0.0


def stack(seed: int, alike: bool = False) -> Lookalike:
    """Three to five books or boxes on one another, from the lowest up; alike: all of one colour."""
    rng = np.random.default_rng(seed)
    camera = _camera(rng)
    count, books = int(rng.integers(3, 6)), bool(rng.random() < 0.5)
    turn, x, y = float(rng.uniform(0.2, 1.0)), rng.uniform(-0.4, 0.4), rng.uniform(1.7, 2.5)
    tone = rng.uniform(40, 220, 3)
    parts: list[_Part] = []
    height = 0.0
    for number in range(count):
        wide, deep, high = (float(v) for v in rng.uniform((0.5, 0.42, 0.08), (0.65, 0.52, 0.15)))
        size = (wide, deep, high)
        yaw = turn + float(rng.uniform(-0.08, 0.08))
        place = (x + rng.uniform(-0.03, 0.03), y + rng.uniform(-0.03, 0.03), height)
        color = tone + rng.normal(0, 12, 3) if alike else rng.uniform(30, 230, 3)
        pieces = (
            _book(size, bool(rng.random() < 0.5))
            if books
            else [("block", Box(size=size), (0.0, 0.0, high / 2))]
        )
        for kind, shape, middle in pieces:
            body = _placed(shape, middle, yaw, place)
            paper = kind == "paper"
            parts.append(_Part(f"item_{number}", *body, PAPER if paper else color, 5.0 * paper))
        height += size[2] + 0.001
    return _drawn(rng, camera, parts)


_Piece = tuple[str, Shape, tuple[float, float, float]]


def _book(size: tuple[float, float, float], left: bool) -> list[_Piece]:
    """Two boards, a spine to one side and paper between them: kind, shape, middle."""
    wide, deep, high = size
    board = Box(size=(wide, deep, COVER))
    side = (wide - COVER) / 2 * (-1 if left else 1)
    return [
        ("board", board, (0.0, 0.0, COVER / 2)),
        ("board", board, (0.0, 0.0, high - COVER / 2)),
        ("board", Box(size=(COVER, deep, high)), (side, 0.0, high / 2)),
        ("paper", Box(size=(wide - 0.03, deep - 0.03, high - 2 * COVER)), (0.0, 0.0, high / 2)),
    ]


def scooter(seed: int) -> Lookalike:
    """A thing of thin parts: a low board between two wheels, a pole and a handlebar."""
    rng = np.random.default_rng(1000 + seed)
    camera = _camera(rng)
    turn, x, y = float(rng.uniform(-0.6, 0.6)), rng.uniform(-0.3, 0.3), rng.uniform(2.0, 2.8)
    dark, light = rng.uniform(15, 90, 3), rng.uniform(120, 235, 3)
    reach, tall = float(rng.uniform(0.5, 0.75)), float(rng.uniform(0.7, 1.0))
    lean = reach / 2 - 0.02
    pieces: list[tuple[Shape, tuple[float, float, float], FloatArray]] = [
        (Box(size=(reach, 0.14, 0.03)), (0.0, 0.0, 0.09), light),
        (Cylinder(radius=0.014, height=tall), (lean, 0.0, 0.1 + tall / 2), dark),
        (Box(size=(0.03, 0.4, 0.03)), (lean, 0.0, 0.1 + tall), dark),
    ]
    for end in (-1, 1):
        pieces.append((Box(size=(0.14, 0.04, 0.14)), (end * (reach / 2 + 0.05), 0.0, 0.07), dark))
    parts = [
        _Part("scooter", *_placed(shape, middle, turn, (x, y, 0.0)), color)
        for shape, middle, color in pieces
    ]
    return _drawn(rng, camera, parts)


def _camera(rng: np.random.Generator) -> Camera:
    focal = SIZE[1] / 2 / math.tan(math.radians(22.5))
    pitch = math.radians(rng.uniform(10, 26))
    horizon = SIZE[1] / 2 - focal * math.tan(pitch)
    return Camera.from_horizon(SIZE, horizon, 1.0, focal=focal, source="given", confirmed=True)


def _placed(
    shape: Shape,
    middle: tuple[float, float, float],
    yaw: float,
    place: tuple[float, float, float],
) -> tuple[FloatArray, NDArray[np.int32]]:
    mesh = mesh_of(shape)
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return (np.asarray(mesh.vertices) + middle) @ turn.T + place, np.asarray(mesh.faces)


def _drawn(rng: np.random.Generator, camera: Camera, parts: list[_Part]) -> Lookalike:
    image = backdrop(rng, camera)
    seen = look(camera, {str(k): (p.vertices, p.faces) for k, p in enumerate(parts)})
    order = list(dict.fromkeys(part.owner for part in parts))
    owner = np.full(seen.owner.shape, -1)
    for index, part in enumerate(parts):
        mask = np.asarray(seen.owner == index)
        owner[mask] = order.index(part.owner)
        a, b, c = (part.vertices[part.faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        light = 0.4 + 0.6 * np.maximum(normal @ LIGHT, 0)
        image[mask] = part.color * light[seen.face[mask]][:, None]
        image[mask] += rng.normal(0, part.grain, (len(image), 1))[np.nonzero(mask)[0]]
    image *= (1 - 0.55 * _below(owner))[..., None]
    ground = cv2.GaussianBlur(np.roll((owner >= 0).astype(np.float32), 10, 0), (0, 0), 12)
    image *= np.where(owner >= 0, 1.0, 1 - 0.35 * ground)[..., None]
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    image += rng.normal(0, 2.5, image.shape)
    masks = {name: np.asarray(owner == k) for k, name in enumerate(order)}
    return Lookalike(np.clip(image, 0, 255).astype(np.uint8), masks)


def _below(owner: NDArray[np.int64], reach: int = 6) -> FloatArray:
    """(H, W) 0 … 1: the shade just below where a higher thing ends on a lower one."""
    shade = np.zeros(owner.shape)
    for down in range(1, reach + 1):
        above = np.full_like(owner, -1)
        above[down:] = owner[:-down]
        shade = np.maximum(shade, ((above > owner) & (owner >= 0)) * (1 - down / (reach + 1)))
    return cv2.GaussianBlur(shade, (0, 0), 1.0).astype(np.float64)
