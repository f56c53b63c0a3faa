"""The photo all around: on the ground, on supports, and far away, so that orbiting shows no void.

What the camera saw is laid on what it saw; beyond the photo's border the picture is mirrored and
blurred, which is no more than a colour for what nobody has seen.
"""

import math

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program import Camera
from physagent_studio.records import Image, Mesh

ACROSS, UP = 16, 40
"""Cells of the dome across one width of the photo, and from straight below to straight above."""
RINGS = 26
"""Rings of the ground from below the camera to far away."""
THIN = 4
"""How many pixels of the photo make one of what is blurred anyway, along each side."""
BLUR = 0.03
"""Blur of what lies beyond the photo, as a part of its width."""
FINE = 48
"""Cells of the ground that the photo shows, each way: its perspective must not be seen to bend."""
BELOW = 2e-3
"""How far below the floor the picture on it lies, as a part of the scene's size."""
HALVINGS = 4
"""How often the faces of a support are halved, so that the photo on them lies straight."""


def beyond_of(camera: Camera, image: Image, far: float) -> tuple[Mesh, ...]:
    """What lies outside of the photo, drawn also in its own view. far: distance of the sky, m."""
    return (_dome(camera, image, _soft(image), far)[1],)


def seen_of(
    camera: Camera, image: Image, floor: float | None, supports: tuple[Mesh, ...], far: float,
    size: float,
) -> tuple[Mesh, ...]:  # fmt: skip
    """All that the photo shows, drawn once a camera has left it. floor: its height, m."""
    soft = _soft(image)
    inside = _dome(camera, image, soft, far)[0]
    seen = [inside, *(skin for one in supports if (skin := _skin(one, camera, image)) is not None)]
    if floor is not None:
        seen += _ground(camera, image, soft, floor - BELOW * size, far)
    return tuple(seen)


def _soft(image: Image) -> Image:
    small = cv2.resize(image, None, fx=1 / THIN, fy=1 / THIN, interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(small, (0, 0), max(BLUR * small.shape[1], 1.0)).astype(np.uint8)


# --- directions and pixels ----------------------------------------------------------------------


def _half_width(camera: Camera) -> float:
    """Half of the horizontal field of view, radians."""
    return math.atan(camera.size[0] / 2 / camera.focal)


def _pixels(camera: Camera, azimuth: FloatArray, elevation: FloatArray) -> FloatArray:
    """(N, 2) pixels of directions, folded back into the photo where they lie beside it.

    azimuth: radians beside the middle of the photo, to the right.
    """
    half = _half_width(camera)
    folded = np.abs(np.mod(azimuth + half, 4 * half) - 2 * half) - half
    # A fold runs the other way: the left border goes on to the left as its mirror image.
    ways = _directions(camera, -folded, elevation)
    local = ways @ camera.matrix
    depth = np.maximum(local[:, 2], 1e-3)
    pixels = local[:, :2] / depth[:, None] * camera.focal + np.array(camera.principal)
    width, rows = camera.size
    behind = local[:, 2] <= 1e-3
    pixels[behind, 1] = np.where(ways[behind, 2] > 0, 0.0, rows)
    return np.clip(pixels, [0.5, 0.5], [width - 0.5, rows - 0.5])


def _directions(camera: Camera, azimuth: FloatArray, elevation: FloatArray) -> FloatArray:
    ahead = camera.matrix[:, 2]
    angle = math.atan2(ahead[1], ahead[0]) - azimuth
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), np.sin(elevation)], axis=-1)


def _crossed(rows: ArrayLike, columns: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Row and column of every point of a grid, row after row."""
    a, b = np.meshgrid(rows, columns, indexing="ij")
    return a.ravel().astype(np.float64), b.ravel().astype(np.float64)


def _grid_faces(rows: int, columns: int) -> NDArray[np.int32]:
    at = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    faces = [np.stack([a, c, b], -1), np.stack([b, c, d], -1)]
    return np.concatenate([one.reshape(-1, 3) for one in faces]).astype(np.int32)


# --- the sky, the ground, supports --------------------------------------------------------------


def _dome(camera: Camera, image: Image, soft: Image, far: float) -> tuple[Mesh, Mesh]:
    """(what the photo shows of far things, what lies beyond it), around the camera."""
    step = 2 * _half_width(camera) / ACROSS
    count = math.ceil(math.pi / step)
    azimuths = step * np.arange(-count, count + 1)
    elevations = np.linspace(-math.pi / 2, math.pi / 2, UP + 1)
    elevation, azimuth = _crossed(elevations, azimuths)
    uv = _pixels(camera, azimuth, elevation)
    points = np.array(camera.position) + far * _directions(camera, azimuth, elevation)
    faces = _grid_faces(len(elevations), len(azimuths))
    ahead = _in_photo(camera, points, margin=0.0)
    own = ahead[faces].all(axis=1)
    seen = Mesh(points, _both(faces[own]), uv, image)
    # Slightly farther away, and under the photo's border too: no gap shows there.
    outer = points + 0.02 * (points - np.array(camera.position))
    beyond = Mesh(outer, _both(faces), _in_soft(uv, camera, soft), soft)
    return seen, beyond


def _in_soft(pixels: FloatArray, camera: Camera, soft: Image) -> FloatArray:
    """Pixels of the photo in the blurred picture, off its border: textures go on at the other."""
    size = np.array([soft.shape[1], soft.shape[0]])
    return np.clip(pixels * (size / np.array(camera.size)), 2.0, size - 2.0)


def _in_photo(camera: Camera, points: FloatArray, margin: float) -> BoolArray:
    pixels, depth = camera.project(points)
    width, rows = camera.size
    inside = (pixels > -margin) & (pixels < np.array([width, rows]) + margin)
    return inside.all(axis=1) & (depth > 0)


def _both(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Faces that are seen from both sides."""
    return np.concatenate([faces, faces[:, ::-1]])


def _ground(camera: Camera, image: Image, soft: Image, height: float, far: float) -> list[Mesh]:
    """The level ground: crisp where the photo shows it, blurred around."""
    eye = np.array(camera.position)
    above = eye[2] - height
    if above <= 0:
        return []
    lowest = math.atan2(above, 0.9 * far)
    dips = -np.geomspace(lowest, math.pi / 2, RINGS)
    step = 2 * _half_width(camera) / ACROSS
    count = math.ceil(math.pi / step)
    azimuths = step * np.arange(-count, count + 1)
    dip, azimuth = _crossed(dips, azimuths)
    ways = _directions(camera, azimuth, dip)
    around = eye + ways * (above / np.maximum(-ways[:, 2:], 1e-9))
    faces = _both(_grid_faces(len(dips), len(azimuths)))
    sunk = around - [0.0, 0.0, 0.5 * BELOW]
    found = [Mesh(sunk, faces, _in_soft(_pixels(camera, azimuth, dip), camera, soft), soft)]
    crisp = _seen_ground(camera, image, height, far)
    return found if crisp is None else [*found, crisp]


def _seen_ground(camera: Camera, image: Image, height: float, far: float) -> Mesh | None:
    width, rows = camera.size
    columns, lines = np.linspace(0, width, FINE + 1), np.linspace(0, rows, FINE + 1)
    line, column = _crossed(lines, columns)
    uv = np.stack([column, line], axis=-1)
    rays, eye = camera.rays(uv), np.array(camera.position)
    down = -rays[:, 2] / np.linalg.norm(rays, axis=1)
    share = (eye[2] - height) / np.maximum(-rays[:, 2:], 1e-9)
    points = eye + rays * share
    near = (down > 1e-3) & (np.linalg.norm(points - eye, axis=1) < 0.9 * far)
    faces = _grid_faces(FINE + 1, FINE + 1)
    faces = faces[near[faces].all(axis=1)]
    if not len(faces):
        return None
    return Mesh(np.where(near[:, None], points, eye), _both(faces), uv, image)


def _skin(mesh: Mesh, camera: Camera, image: Image) -> Mesh | None:
    """The faces of a support that the photo shows, with the photo on them."""
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    ahead = np.einsum("ij,ij->i", normals, np.array(camera.position) - corners.mean(axis=1)) > 0
    corners = corners[ahead]
    for _ in range(HALVINGS if len(corners) < 400 else 0):
        corners = _halved(corners)
    points = corners.reshape(-1, 3)
    shown = _in_photo(camera, points, margin=0.0).reshape(-1, 3).all(axis=1)
    points = corners[shown].reshape(-1, 3)
    if not len(points):
        return None
    lifted = points + 1e-3 * (np.array(camera.position) - points)
    pixels, _ = camera.project(points)
    return Mesh(lifted, np.arange(len(points), dtype=np.int32).reshape(-1, 3), pixels, image)


def _halved(corners: FloatArray) -> FloatArray:
    """Each triangle (N, 3, 3) as four."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(part, axis=1) for part in parts])
