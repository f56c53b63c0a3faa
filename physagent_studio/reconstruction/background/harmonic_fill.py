"""Fills: the nearest that no line cuts off, and pictures put together from their gradients."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from physagent_studio.arrays import BoolArray, FloatImage
from physagent_studio.reconstruction.background.structure import Structure


def reduced(
    image: FloatImage, hole: BoolArray, size: tuple[int, int]
) -> tuple[FloatImage, BoolArray]:
    """Image and hole at another size; background colours alone, none of the objects'."""
    weight = (~hole).astype(np.float32)
    colour = cv2.resize(image * weight[..., None], size, interpolation=cv2.INTER_AREA)
    some = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
    return (colour / np.maximum(some, 1e-3)[..., None]).astype(np.float32), np.asarray(some < 0.99)


def nearest_along(image: FloatImage, hole: BoolArray, structure: Structure) -> FloatImage:
    """A sharp fill (H, W, C): the nearest known pixel that nothing known cuts off.

    Pixels of the same row are nearer than those above and below, for walls, floors and tables
    run across pictures.
    """
    right, below = structure.crossed(hole.shape)
    over_line_px = 500.0  # 100..2000: how far it is to the other side of a line
    across_rows_ratio = 3.0  # 1..10: how much farther a pixel above or below is than one beside
    cost = {1: 1 + over_line_px * right, 0: across_rows_ratio + over_line_px * below}
    far = np.where(hole, np.inf, 0.0)
    source = np.arange(hole.size).reshape(hole.shape)
    for _ in range(4 * max(hole.shape)):
        before = far.copy()
        for axis, step in ((1, 1), (1, -1), (0, 1), (0, -1)):
            # What it costs to come from the neighbour before, or after, along this axis.
            price = np.roll(cost[axis], 1, axis) if step == 1 else cost[axis].copy()
            edge = (slice(None), 0 if step == 1 else -1) if axis else (0 if step == 1 else -1,)
            price[edge] = np.inf
            offered = np.roll(far, step, axis) + price
            better = offered < far
            far = np.where(better, offered, far)
            source = np.where(better, np.roll(source, step, axis), source)
        if np.array_equal(before, far):
            break
    # The mean along its row is more the ground's colour than the one pixel at the rim is.
    known = (~hole).astype(np.float32)
    row_mean_px = 1.2  # 0.5..4: spread of the mean along a row from which a guess is made
    total = cv2.GaussianBlur(image * known[..., None], (0, 0), sigmaX=row_mean_px, sigmaY=0.7)
    mean = (
        total
        / np.maximum(cv2.GaussianBlur(known, (0, 0), sigmaX=row_mean_px, sigmaY=0.7), 1e-3)[
            ..., None
        ]
    )
    guess = mean.reshape(-1, image.shape[2])[source]
    return np.where(hole[..., None], guess, image).astype(np.float32)


def from_steps(
    image: FloatImage,
    hole: BoolArray,
    steps: tuple[FloatImage, FloatImage] | None = None,
    weights: tuple[NDArray, NDArray] | None = None,
    anchor: float = 1e-9,
) -> FloatImage:
    """The picture (H, W, C) whose hole (H, W) has the given steps as nearly as can be (Poisson).

    steps: wanted differences (H, W, C) of the pixel to the right, and of that below, to this one;
    None for no difference. weights: (H, W) how much each of the two counts. What is not missing
    stays, and the fill meets it without a seam. anchor: how much it counts that the fill be as
    the picture's hole already is.
    """
    count = int(np.count_nonzero(hole))
    index = np.full(np.add(hole.shape, 2), -2)
    index[1:-1, 1:-1] = -1
    index[1:-1, 1:-1][hole] = np.arange(count)
    padded = np.pad(image.astype(np.float64), ((1, 1), (1, 1), (0, 0)))
    wanted = [np.pad(s, ((1, 1), (1, 1), (0, 0))) for s in steps] if steps else None
    heavy = [np.pad(w, 1) for w in weights] if weights else None
    rows, columns = np.nonzero(index >= 0)
    own = index[rows, columns]
    degree, known = np.full(count, anchor), anchor * image[hole].astype(np.float64)
    entries: list[tuple[NDArray, NDArray, NDArray]] = []
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = index[rows + dy, columns + dx]
        # Steps and weights are kept at the left or upper one of two pixels.
        first = (rows + min(dy, 0), columns + min(dx, 0))
        weight = np.where(near > -2, heavy[abs(dy)][first] if heavy else 1.0, 0.0)
        degree[own] += weight
        if wanted is not None:
            known[own] -= weight[:, None] * (dy + dx) * wanted[abs(dy)][first]
        rim = near == -1
        known[own[rim]] += weight[rim, None] * padded[rows[rim] + dy, columns[rim] + dx]
        entries.append((own[near >= 0], near[near >= 0], -weight[near >= 0]))
    r = np.concatenate([own, *(entry[0] for entry in entries)])
    c = np.concatenate([own, *(entry[1] for entry in entries)])
    v = np.concatenate([degree, *(entry[2] for entry in entries)])
    solve = splu(sparse.csc_matrix((v, (r, c)), (count, count)))
    out = image.astype(np.float32)
    out[hole] = solve.solve(known).astype(np.float32)
    return out
