"""The thread, cord or chain by which a thing is seen to hang: a thin line straight up from it.

A thing that swings takes its thread along, and swings about the upper end of it; left in the
background, the thread would stay where it was. It weighs nothing and runs into nothing. What is
lighter than air has its string below.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import kind_of
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh

IntArray = NDArray[np.int64]
GreyArray = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class ThreadSettings:
    """What is taken for a thread."""

    max_width_share: float = 0.12  # 0.05..0.25: of the thing's width; wider, it is a part of it
    width_shares: tuple[float, ...] = (1.0, 0.25)  # 0.1..1: of that, for which lines are looked for
    min_length_share: float = 0.35  # 0.2..1: of the thing's height; shorter, it is its stem
    min_contrast: float = 8.0  # grey levels, 4..20: by which it stands out of both its sides
    noise_ratio: float = 2.0  # 1.5..4: the same, over what the sides differ by among themselves
    middle_share: float = 0.25  # 0.1..0.5: of the width, that it begins off the middle by at most
    cap_share: float = 0.25  # 0.1..0.5: of its height: a cap or a hook between it and the thread
    # 0..1: of that, above it, from where a thread is followed; the longest is taken
    start_shares: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75)
    max_gap_px: int = 9  # 1..20: of rows in which it is not seen
    max_lean_px: int = 1  # 1..3: from row to row
    rim_px: int = 2  # 1..4: beside it, where its colour has run into the background


THREAD = ThreadSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Thread:
    """A thread in the photo. area: (H, W) what it covers, its soft rim too; core: without that.
    foot, top: its ends, pixels. width: pixels. colors: (N, 3) RGB from its foot to its top."""

    area: BoolArray
    core: BoolArray
    foot: tuple[float, float]
    top: tuple[float, float]
    width: float
    colors: Image


def threads_of(
    image: Image, masks: Mapping[str, BoolArray], state: SceneState, dropping: Collection[str]
) -> dict[str, Thread]:
    """By which threads things that hang are seen to hang; what drops leaves its thread there.

    What is lighter than air has its own below.
    """
    found = {}
    for item in state.objects:
        if item.name not in masks or item.name in dropping:
            continue
        taken = np.any([mask & (name != item.name) for name, mask in masks.items()], axis=0)
        kind = kind_of(item.name)
        thread = None
        if kind is not None and kind.buoyant and item.aloft is not None:
            thread = thread_below(image, masks[item.name], taken)
        elif item.aloft == "hangs":
            thread = thread_above(image, masks[item.name], taken)
        if thread is not None:
            found[item.name] = thread
    return found


def hung(
    state: SceneState, meshes: Mapping[str, Mesh], threads: Mapping[str, Thread]
) -> tuple[SceneState, dict[str, Mesh]]:
    """The state and the looks with the threads that things hang by."""
    camera, out, items = state.camera, dict(meshes), []
    assert camera is not None
    for item in state.objects:
        thread = threads.get(item.name)
        if thread is not None and item.name in out and item.position is not None:
            out[item.name] = with_thread(out[item.name], item, camera, thread)
            # What hangs below a thing does not hold it.
            if thread.top[1] < thread.foot[1]:
                length = item.tether or round(length_of(thread, item, camera), 4)
                item = item.model_copy(update={"tether": length})
        items.append(item)
    return state.model_copy(update={"objects": tuple(items)}), out


def thread_above(image: Image, mask: BoolArray, taken: BoolArray) -> Thread | None:
    """The thread that a thing of this mask (H, W) hangs by; None where none is seen.

    image: (H, W, 3) RGB. taken: (H, W) what belongs to other things.
    """
    if not mask.any() or not at_work("threads"):
        return None
    x0, y0, x1, y1 = bounds(mask)
    widest = max(int(THREAD.max_width_share * (x1 - x0)), 3)
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    # Threads are as wide as stems, or mere lines.
    lines = [_ridges(grey, max(round(share * widest), 3)) for share in THREAD.width_shares]
    ridges = np.where(taken, 0.0, np.max(lines, axis=0))
    middle = float(np.flatnonzero(mask[y0]).mean())
    reach, cap = THREAD.middle_share * (x1 - x0), THREAD.cap_share * (y1 - y0)
    # A knot or the end of a bow beside it may be seen first.
    starts = [y0 - round(share * cap) for share in THREAD.start_shares]
    traces = [_followed(ridges, middle, row, max(int(reach), 2), cap) for row in starts]
    rows, columns = max(traces, key=lambda trace: len(trace[0]))
    if not len(rows) or y0 - rows[-1] < THREAD.min_length_share * (y1 - y0):
        return None
    wide = _width(grey, rows, columns, widest)
    slope, at = np.polyfit(rows, columns, 1)
    y, x = np.mgrid[: mask.shape[0], : mask.shape[1]]
    beside = np.where((y < y0) & (y >= rows[-1]), np.abs(x - slope * y - at), np.inf)
    free = ~mask & ~taken
    # The middle of a pixel lies half a pixel from its corner.
    ends = [(float(slope * row + at) + 0.5, row + 0.5) for row in (float(y0), float(rows[-1]))]
    return Thread(
        (beside <= wide / 2 + THREAD.rim_px) & free,
        (beside <= wide / 2) & free,
        ends[0],
        ends[1],
        float(wide),
        image[rows, columns],
    )


def thread_below(image: Image, mask: BoolArray, taken: BoolArray) -> Thread | None:
    """The string that hangs from a thing of this mask (H, W), as `thread_above` gives a thread; its
    top is its lower end."""
    if not at_work("strings below"):
        return None
    found = thread_above(np.ascontiguousarray(image[::-1]), mask[::-1], taken[::-1])
    if found is None:
        return None
    rows, foot, top = len(mask), np.array(found.foot), np.array(found.top)
    # From within the body, whose drawn outline may leave a knot out: what hides it is before it.
    _, y0, _, y1 = bounds(mask)
    foot += THREAD.cap_share * (y1 - y0) / max(foot[1] - top[1], 1.0) * (foot - top)
    return replace(
        found,
        area=found.area[::-1],
        core=found.core[::-1],
        foot=(float(foot[0]), float(rows - foot[1])),
        top=(float(top[0]), float(rows - top[1])),
    )


def with_thread(mesh: Mesh, item: SceneObject, camera: Camera, thread: Thread) -> Mesh:
    """The drawn mesh (body frame) with its thread: a strip as wide as it is, on the plane through
    the thing's middle that faces the camera. What collides stays as it is."""
    if mesh.texture is None or mesh.uv is None or item.position is None:
        return mesh
    half = np.array([thread.width / 2, 0.0])
    ends = (np.asarray(thread.foot), np.asarray(thread.top))
    corners = np.array([end + side for end in ends for side in (-half, half)])
    place = np.asarray(item.position)
    world = _at_its_depth(camera, place, corners)
    vertices = (world - place) @ matrix_of(item.rotation)
    first = len(mesh.vertices)
    strip = first + np.array([[0, 1, 3], [0, 3, 2], [0, 3, 1], [0, 2, 3]], np.int32)
    texture, uv = _with_strip(mesh.texture, thread.colors)
    return replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, vertices]),
        faces=np.concatenate([mesh.faces, strip]),
        uv=np.concatenate([mesh.uv, uv]),
        texture=texture,
        solid=(mesh.vertices, mesh.faces) if mesh.solid is None else mesh.solid,
    )


def length_of(thread: Thread, item: SceneObject, camera: Camera) -> float:
    """From the thing's middle to the upper end of its thread, m."""
    place = np.asarray(item.position)
    top = _at_its_depth(camera, place, np.array([thread.top]))[0]
    return float(np.linalg.norm(top - place))


def _at_its_depth(camera: Camera, place: FloatArray, pixels: FloatArray) -> FloatArray:
    """(N, 3) world places of pixels (N, 2), as far along the optical axis as `place`, m."""
    depth = float(camera.project(place[None])[1][0])
    return np.asarray(camera.position) + depth * camera.rays(pixels)


def _with_strip(texture: Image, colors: Image) -> tuple[Image, FloatArray]:
    """A texture with the colours of a thread beside it, and where its corners lie there (4, 2)."""
    high, wide = texture.shape[:2]
    rows = max(high, len(colors))
    sheet = np.zeros((rows, wide + 8, 3), np.uint8)
    sheet[:high, :wide] = texture
    sheet[: len(colors), wide:] = colors[:, None]
    sheet[len(colors) :, wide:] = colors[-1]
    middle, last = wide + 4.0, len(colors) - 0.5
    return sheet, np.array([[middle, 0.5], [middle, 0.5], [middle, last], [middle, last]])


def _followed(
    ridges: GreyArray, column: float, foot: int, reach: int, cap: float
) -> tuple[IntArray, IntArray]:
    """Rows and columns of a ridge from a foot upwards: it begins within `reach` of a column, no
    higher than `cap` pixels, and leans little from row to row."""
    found: list[tuple[int, int]] = []
    gap = 0
    for row in range(foot - 1, -1, -1):
        near = reach if not found else THREAD.max_lean_px + gap
        low, high = max(round(column) - near, 0), round(column) + near + 1
        line = ridges[row, low:high]
        if not line.size or line.max() <= 0:
            gap += 1
            if gap > (THREAD.max_gap_px if found else cap):
                break
            continue
        column, gap = float(low + int(line.argmax())), 0
        found.append((row, int(column)))
    rows, columns = np.array(found, np.int64).reshape(-1, 2).T
    return rows, columns


def _width(grey: GreyArray, rows: IntArray, columns: IntArray, widest: int) -> int:
    """Width of a thread in pixels: as far as it stands out half as much as in its middle, in the
    median of its rows."""
    away = widest // 2 + 2
    across = np.clip(columns[:, None] + np.arange(-away, away + 1), 0, grey.shape[1] - 1)
    lines = grey[rows[:, None], across]
    off = np.median(np.abs(lines - lines[:, [0, -1]].mean(1, keepdims=True)), axis=0)
    return int(np.count_nonzero(off > off.max() / 2))


def _ridges(grey: GreyArray, widest: int) -> GreyArray:
    """(H, W) by how much each pixel stands out of what is beside it, left and right alike; 0 where
    it does not, or no more than its two sides differ."""
    away = widest // 2 + 2
    smooth = cv2.GaussianBlur(grey, (1, 5), 0, sigmaY=1.5)
    left, right = np.roll(smooth, away, axis=1), np.roll(smooth, -away, axis=1)
    middle = cv2.blur(smooth, (max(widest // 3, 1), 1))
    out = np.maximum(np.minimum(left, right) - middle, middle - np.maximum(left, right))
    least = np.maximum(THREAD.min_contrast, THREAD.noise_ratio * np.abs(left - right))
    out = np.where(out >= least, out, 0.0).astype(np.float32)
    out[:, :away] = out[:, -away:] = 0
    return out
