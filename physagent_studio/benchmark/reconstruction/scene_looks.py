"""Backgrounds and bodies of the random pictures held against what these were drawn from."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.reconstruction.plates import steps_of
from physagent_studio.benchmark.reconstruction.truth import TrueMasks
from physagent_studio.benchmark.scenes import Pictured
from physagent_studio.benchmark.scenes.catalogue import turned_in_place
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.reconstruction import photo_hash
from physagent_studio.reconstruction.background.plate import background, hole_of
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.pipeline import reconstruct
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.switches import without
from physagent_studio.records.case import Case, Image

FloatArray = NDArray[np.float64]
Results = dict[tuple[int, str, str], float]
SHADE = 8.0
"""Grey levels by which what a thing shades or is mirrored in differs from the empty picture."""
TURN = math.pi / 2
"""By how much bodies are turned about the vertical to be seen from another side."""


def plates(
    seed: int, drawn: Pictured, way: str, left_out: Sequence[str]
) -> tuple[Results, set[str]]:
    """Minus the error of the background from true masks and camera, grey levels."""
    masks = [subject.mask for subject in drawn.subjects]
    with without(left_out) as asked:
        found = segments(drawn.image)
        plate = background(drawn.image, masks, camera=drawn.stage.camera, found=found)
    error = _error(drawn.image, drawn.emptied(), plate, hole_of(masks, plate.shape[:2]))
    return {(seed, way, "background"): -error}, set(asked)


def _error(image: Image, empty: Image, plate: Image, hole: NDArray[np.bool_]) -> float:
    """Error of tone and of steps, over all that was to be taken out or was changed beside it."""
    made, truth, seen = (picture.astype(np.float32) for picture in (plate, empty, image))
    off = np.abs(cv2.GaussianBlur(made - truth, (0, 0), 2.0)).mean(-1)
    off += np.abs(cv2.GaussianBlur(steps_of(made) - steps_of(truth), (0, 0), 3.0))
    shade = np.abs(cv2.GaussianBlur(seen - truth, (0, 0), 1.0)).mean(-1) > SHADE
    changed = hole | shade | (plate != image).any(-1)
    return float(off[changed].sum() / np.count_nonzero(hole | shade))


def bodies(
    seed: int, drawn: Pictured, way: str, left_out: Sequence[str]
) -> tuple[Results, set[str]]:
    """IoU of each drawn body with the true thing, as it stands and turned about the vertical."""
    truth = TrueMasks({s.name: s.mask for s in drawn.subjects})
    said = tuple((s.name, s.box) for s in drawn.subjects)
    things = tuple(SceneObject(name=name, grounding=own) for name, own in said)
    state = SceneState(camera=drawn.stage.camera, objects=things)
    hashed = photo_hash(drawn.image)
    case = Case("drawn", drawn.image, hashed, said, (), (), "The objects stay.")
    with without(left_out) as asked:
        made = reconstruct(case, state, segmenter=truth)
    out: Results = {}
    camera = drawn.stage.camera
    for item, subject in zip(made.state.objects, drawn.subjects, strict=True):
        mesh = made.meshes[item.name]
        shown = silhouette(camera, in_world(item, mesh), mesh.faces)
        out[seed, way, item.name] = iou(shown, subject.mask)
        shown = silhouette(camera, _turned(in_world(item, mesh)), mesh.faces)
        whose = drawn.stage.taken_of([turned_in_place(subject.thing, TURN)])[1]
        out[seed, way, f"{item.name}, turned"] = iou(shown, whose == 0)
    return out, set(asked)


def _turned(world: FloatArray) -> FloatArray:
    """Vertices (V, 3) turned about the vertical through the middle of their bounds."""
    middle = (world.min(0) + world.max(0)) / 2
    return (world - middle) @ matrix_of(about_up(TURN)).T + middle
