"""Where things are in the picture, frame by frame: outlines through the camera, NumPy only."""

from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.program.rotations import matrices_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import Outline, Placed

NEAR = 0.01
"""What is nearer to the camera than this, m, along its axis, is not in the picture."""
AROUND = 16
"""Points of an outline's silhouette."""
FOLLOWED = 48
"""Points of a deforming body that are followed."""


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """One thing in the picture over F frames.

    outline: (F, K, 2) pixels of its silhouette, in order round it where it is rigid. marks:
    (F, M, 2) pixels of points of its body that a viewer follows. share: (F,) part of its
    silhouette within the frame. steps: (F − 1,) how far a mark moves at most from one frame to
    the next while it is in the frame, parts of the picture's width. sides: (F, S, 2) pixels of
    points on its surface, by which it is seen to spin where marks and outline stay; turns:
    (F − 1,) the steps of these.
    """

    outline: FloatArray
    marks: FloatArray
    share: FloatArray
    steps: FloatArray
    sides: FloatArray
    turns: FloatArray

    @property
    def centre(self) -> FloatArray:
        """(F, 2) middle of the silhouette, pixels."""
        return self.outline.mean(axis=1)

    @property
    def length(self) -> FloatArray:
        """(F,) longer side of the silhouette's bounding box, pixels."""
        return np.ptp(self.outline, axis=1).max(axis=-1)


def sight_of(facts: Facts, name: str) -> Sight | None:
    """One object in the picture; None where there is no camera."""
    camera = facts.program.scene.camera
    if camera is None:
        return None
    return facts.cached(("sight", name), lambda: _sight(facts, name, camera))


def beyond_of(placed: Placed, camera: Camera) -> FloatArray:
    """(T,) how far a body's silhouette reaches beyond the frame at each of its poses, in parts of
    its own longer side; infinite where it is not before the camera."""
    outline, _, ahead = _of_outline(placed, camera)
    over = np.maximum(-outline, outline - np.array(camera.size, float)).max(axis=(1, 2))
    long = np.maximum(np.ptp(outline, axis=1).max(axis=-1), 1e-9)
    return np.where(ahead, np.maximum(over, 0.0) / long, np.inf)


def _sight(facts: Facts, name: str, camera: Camera) -> Sight:
    rollout = facts.rollout
    deformed = dict(rollout.vertices).get(name)
    if deformed is not None and len(deformed):
        outline, marks, ahead = _of_vertices(deformed, rollout.frames, camera)
        sides = marks
        share = _within(outline, camera).mean(axis=1)
    else:
        rows = np.minimum(rollout.frame_steps(), facts.last)
        index = rollout.objects.index(name)
        placed = Placed(
            facts.outline(name),
            positions=rollout.positions[rows, index],
            matrices=matrices_of(rollout.rotations[rows, index]),
        )
        outline, marks, ahead = _of_outline(placed, camera)
        sides = _projected(_followed(placed, _sides(facts.outline(name))), camera)[0]
        share = _share(outline, camera)
    share = np.where(ahead, share, 0.0)
    steps, turns = (_steps(points, share, camera) for points in (marks, sides))
    return Sight(outline, marks, share, steps, sides, turns)


def _of_vertices(
    deformed: FloatArray, frames: int, camera: Camera
) -> tuple[FloatArray, FloatArray, BoolArray]:
    rows = np.minimum(np.arange(frames), len(deformed) - 1)
    every = max(deformed.shape[1] // (4 * FOLLOWED), 1)
    points = deformed[rows][:, ::every]
    pixels, ahead = _projected(points, camera)
    return pixels, pixels[:, :: max(pixels.shape[1] // FOLLOWED, 1)], ahead


def _of_outline(placed: Placed, camera: Camera) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The silhouette, from the directions across the line of sight, and the marks."""
    assert placed.outline is not None
    right, down = _across(placed.positions, camera)
    turn = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    rim = np.stack([placed.support(np.cos(t) * right + np.sin(t) * down) for t in turn], axis=1)
    body = _followed(placed, _marks(placed.outline))
    outline, ahead = _projected(rim, camera)
    return outline, _projected(body, camera)[0], ahead


def _followed(placed: Placed, local: FloatArray) -> FloatArray:
    """(T, M, 3) world points of points (M, 3) of a body."""
    return placed.positions[:, None] + np.einsum("tij,mj->tmi", placed.matrices, local)


def _across(places: FloatArray, camera: Camera) -> tuple[FloatArray, FloatArray]:
    """Two unit directions (T, 3) across the line of sight to each place (T, 3)."""
    ahead = _unit(places - camera.position)
    along = ahead @ camera.matrix[:, 0]
    right = _unit(camera.matrix[:, 0] - along[:, None] * ahead)
    return right, np.cross(ahead, right)


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _marks(outline: Outline) -> FloatArray:
    """(M, 3) points by which a viewer sees a body turn, body frame: none but the middle of a
    ball, the ends of its axis of what is round, else the middles of its six sides."""
    if outline.is_ball:
        return outline.bounds.mean(axis=0)[None]
    return _ends(outline, np.eye(3) if outline.axis is None else np.array([outline.axis]))


def _sides(outline: Outline) -> FloatArray:
    """(7, 3) the middle of a body and of its six sides, body frame: what is round is seen to
    spin by them, if it is of more than one colour."""
    return _ends(outline, np.eye(3))


def _ends(outline: Outline, axes: FloatArray) -> FloatArray:
    """(1 + 2K, 3) the middle of a body and where axes (K, 3) through it leave it."""
    middle = outline.bounds.mean(axis=0)
    ends = np.concatenate([outline.support(axes), outline.support(-axes)])
    on_axes = middle + (ends - middle) * np.tile(np.abs(axes), (2, 1))
    return np.concatenate([middle[None], on_axes])


def _projected(points: FloatArray, camera: Camera) -> tuple[FloatArray, BoolArray]:
    """Pixels (F, M, 2) of world points (F, M, 3), and (F,) whether all lie before the camera."""
    frames, count = points.shape[:2]
    finite = np.asarray(np.isfinite(points).all(axis=(1, 2)), bool)
    flat = np.where(finite[:, None, None], points, 0.0).reshape(-1, 3)
    local = (flat - camera.position) @ camera.matrix
    depth = np.maximum(local[:, 2], NEAR)
    pixels = camera.focal * local[:, :2] / depth[:, None] + camera.principal
    ahead = np.asarray((local[:, 2] > NEAR).reshape(frames, count).all(axis=1), bool)
    return pixels.reshape(frames, count, 2), ahead & finite


def _within(pixels: FloatArray, camera: Camera) -> BoolArray:
    """(…,) whether pixels (…, 2) lie in the frame."""
    return np.asarray(((pixels >= 0) & (pixels <= camera.size)).all(axis=-1), bool)


def _share(outline: FloatArray, camera: Camera) -> FloatArray:
    """(F,) part of the area of convex outlines (F, K, 2) that lies in the frame."""
    cut = outline
    for axis in (0, 1):
        cut = _cut(cut, axis, 0.0, 1.0)
        cut = _cut(cut, axis, float(camera.size[axis]), -1.0)
    return np.clip(_area(cut) / np.maximum(_area(outline), 1e-9), 0.0, 1.0)


def _cut(outline: FloatArray, axis: int, limit: float, sign: float) -> FloatArray:
    """(F, 2K, 2) outlines cut off at a line across an axis (Sutherland and Hodgman, 1974).

    What lies beyond falls onto the line, where it has no area: each keeps as many points.
    """
    following = np.roll(outline, -1, axis=1)
    here, there = outline[..., axis] - limit, following[..., axis] - limit
    crosses = here * there < 0
    part = np.where(crosses, here / np.where(crosses, here - there, 1.0), 0.0)
    kept = outline.copy()
    kept[..., axis] = limit + sign * np.maximum(sign * here, 0.0)
    border = np.where(crosses[..., None], outline + part[..., None] * (following - outline), kept)
    return np.stack([kept, border], axis=2).reshape(len(outline), -1, 2)


def _area(outline: FloatArray) -> FloatArray:
    """(F,) area within outlines (F, K, 2), taken about one of their points."""
    own = outline - outline[:, :1]
    following = np.roll(own, -1, axis=1)
    turns = own[..., 0] * following[..., 1] - own[..., 1] * following[..., 0]
    return np.abs(turns.sum(axis=1)) / 2


def _steps(marks: FloatArray, share: FloatArray, camera: Camera) -> FloatArray:
    """(F − 1,) greatest step of a mark between frames that both show the thing; of many marks
    the step that all but a tenth keep within."""
    moved = np.linalg.norm(np.diff(marks, axis=0), axis=-1) / camera.size[0]
    most = np.quantile(moved, 0.9, axis=1) if marks.shape[1] > 8 else moved.max(axis=1)
    seen = (share[1:] > 0.25) & (share[:-1] > 0.25)
    return np.where(seen, most, 0.0)
