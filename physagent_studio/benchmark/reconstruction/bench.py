"""`physagent bench reconstruction`: synthetic truth, photographs, repeatability, time, memory."""

import json
import math
import resource
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.benchmark.reconstruction.cover import (
    Cover,
    cover_rows,
    covers_of,
    movers,
    standing,
)
from physagent_studio.benchmark.reconstruction.lookalikes import scooter, stack
from physagent_studio.benchmark.reconstruction.many_parts import many_part_rows
from physagent_studio.benchmark.reconstruction.photo_holes import hole_rows
from physagent_studio.benchmark.reconstruction.plates import plate_rows
from physagent_studio.benchmark.reconstruction.synthetic import Drawn, TrueMasks, scene
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.benchmark.scenes.pictures import boxed
from physagent_studio.exchange import load_case
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Click, Grounding, Ramp, SceneObject, SceneState
from physagent_studio.reconstruction import mesh_of, photo_hash, reconstruct
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.reconstruction.shapes.meshes import ramp_corners
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.supports.clicked import marked_ramp
from physagent_studio.records.case import Case, Image
from physagent_studio.records.scene import Scene

SCENES = 16
LOOKALIKES = 8
POLYGONS = Path(__file__).resolve().parents[3] / "tests" / "data" / "reference_polygons.json"


def bench(cases: Path | None = None) -> list[Row]:
    """All rows; the photographs are left out where `cases` or the reference outlines are absent."""
    rows = [*_synthetic(), *_lookalikes(), *_ramps(), *plate_rows()]
    rows += many_part_rows()
    if cases is not None and POLYGONS.is_file():
        rows += _photographs(cases)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    peak_mb = peak / (2**20 if sys.platform == "darwin" else 2**10)
    rows.append(at_most("peak memory of the process", peak_mb, 1024, "MB"))
    return rows


# --- synthetic scenes --------------------------------------------------------------------------


def _synthetic() -> list[Row]:
    drawn = [scene(seed) for seed in range(SCENES)]
    scenes = [_with_truth(item) for item in drawn]
    reprojection = [f.measured for s in scenes for f in s.findings if f.name == "reprojection"]
    place, height, width = zip(
        *(
            errors
            for item, made in zip(drawn, scenes, strict=True)
            for truth, found in zip(item.objects, made.state.objects, strict=True)
            if (errors := _errors(item, truth, found, made)) is not None
        ),
        strict=True,
    )
    clicked = [value for item in drawn for value in _one_click(item)]
    again = _with_truth(drawn[0])
    same = again.hash == scenes[0].hash and all(
        np.array_equal(again.meshes[name].vertices, scenes[0].meshes[name].vertices)
        for name in again.meshes
    )
    assert again.plate is not None
    assert scenes[0].plate is not None
    same &= np.array_equal(again.plate, scenes[0].plate)
    fallen = [name for made in scenes for name in movers(made)]
    count = sum(standing(made) for made in scenes)
    return [
        shown("synthetic objects", len(place)),
        # One seen right above another may stand on it or behind it; masks alone do not tell.
        at_most("synthetic: share of objects that move by themselves", len(fallen) / count, 0.1),
        at_least("reprojection IoU, median", float(np.median(reprojection)), 0.95),
        at_least("reprojection IoU, 10th percentile", float(np.percentile(reprojection, 10)), 0.88),
        at_most("position over distance, median", float(np.median(place)), 0.01),
        at_most("position over distance, 90th percentile", float(np.percentile(place, 90)), 0.06),
        at_most("height error, median", float(np.median(height)), 0.02),
        at_most("width error, median", float(np.median(width)), 0.03),
        at_least("one click: mask IoU, median", float(np.median(clicked)), 0.93),
        at_least("one click: mask IoU, 10th percentile", float(np.percentile(clicked, 10)), 0.80),
        Row("same bits on a second run", str(same), "", "True", same),
        *cover_rows("synthetic", [cover for made in scenes for cover in covers_of(made)]),
    ]


def _case(item: Drawn) -> Case:
    objects = tuple((o.name, _middle_click(item.masks[o.name])) for o in item.objects)
    return Case(
        name="synthetic",
        image=item.image,
        image_hash=photo_hash(item.image),
        objects=objects,
        prompt="The objects stay.",
    )


def _middle_click(mask: BoolArray) -> Grounding:
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    return Grounding(points=(Click(x=float(column), y=float(row)),))


def _with_truth(item: Drawn) -> Scene:
    """Reconstructed with the true masks and camera."""
    case = _case(item)
    state = SceneState(
        camera=item.camera,
        objects=tuple(SceneObject(name=name, grounding=g) for name, g in case.objects),
    )
    return reconstruct(case, state, segmenter=TrueMasks(item.masks))


def _errors(
    item: Drawn, truth: SceneObject, found: SceneObject, made: Scene
) -> tuple[float, float, float] | None:
    """Relative errors of place, height and width; None for an object hardly in view."""
    if np.count_nonzero(item.masks[truth.name]) < 300 or found.position is None:
        return None
    assert truth.shape is not None
    true_body = in_world(truth, mesh_of(truth.shape))
    body = in_world(found, made.meshes[found.name])
    middle = np.asarray(truth.position)
    far = float(np.linalg.norm(middle - np.asarray(item.camera.position)))
    size, true_size = np.ptp(body, axis=0), np.ptp(true_body, axis=0)
    place = float(np.linalg.norm(np.asarray(found.position) - middle)) / far
    return place, abs(size[2] / true_size[2] - 1), abs(size[0] / true_size[0] - 1)


def _one_click(item: Drawn) -> list[float]:
    case = _case(item)
    offers = EmbeddedSegmenter().segment(item.image, case.objects)
    masks = choose(offers, case.objects, item.image.shape[:2])
    large = [name for name, mask in item.masks.items() if np.count_nonzero(mask) >= 300]
    return [iou(masks[name], item.masks[name]) for name in large]


def _lookalikes() -> list[Row]:
    """Stacks from one click each, and poles from a box, on pictures drawn for the purpose."""
    layers: list[float] = []
    for seed in range(LOOKALIKES):
        drawn = stack(seed, alike=seed % 3 == 2)
        said = tuple((name, _middle_click(mask)) for name, mask in drawn.masks.items())
        layers += _mask_scores(drawn.image, said, drawn.masks)
    poles: list[float] = []
    for seed in range(LOOKALIKES):
        drawn = scooter(seed)
        boxes = tuple((name, _boxed(Grounding(), mask)) for name, mask in drawn.masks.items())
        poles += _mask_scores(drawn.image, boxes, drawn.masks)
    return [
        at_least("layers of stacks, one click: mask IoU, median", float(np.median(layers)), 0.75),
        at_least("poles, box alone: mask IoU, median", float(np.median(poles)), 0.85),
    ]


def _ramps() -> list[Row]:
    """Slope from three clicks that are a pixel off, over many views."""
    rng = np.random.default_rng(3)
    errors: list[float] = []
    for _ in range(200):
        pitch = math.radians(rng.uniform(8, 28))
        focal = 579.0
        camera = Camera.from_horizon((832, 480), 240 - focal * math.tan(pitch), 1.0, focal=focal)
        run, slope = float(rng.uniform(0.5, 1.0)), math.radians(rng.uniform(12, 40))
        truth = Ramp(
            toe=(float(rng.uniform(-0.5, 0.5)), float(rng.uniform(2.4, 3.4)), 0.0),
            yaw=float(rng.uniform(-0.6, 0.6)),
            run=run,
            rise=run * math.tan(slope),
            width=0.3,
        )
        near = ramp_corners(truth)[0]
        pixels = camera.project(near[:3])[0] + rng.normal(0, 1.0, (3, 2))
        toe, foot, top = ((float(x), float(y)) for x, y in pixels)
        found = marked_ramp(camera, [toe], [foot], top)
        if found is not None:
            errors.append(abs(math.degrees(math.atan2(found.rise, found.run) - slope)))
    return [at_most("ramp slope from three clicks, median", float(np.median(errors)), 1.0, "°")]


# --- photographs -------------------------------------------------------------------------------


def reference_masks(case: str, shape: tuple[int, int]) -> dict[str, BoolArray]:
    """Masks of the outlines that were traced by eye, by object name; {} for an unknown case."""
    outlines = json.loads(POLYGONS.read_text(encoding="utf-8")).get(case, {})
    return {name: _polygon(outline, shape) for name, outline in outlines.items()}


def _polygon(outline: Mapping[str, list], shape: tuple[int, int]) -> BoolArray:
    canvas = np.zeros(shape, np.uint8)
    for ring, value in ((outline["outline"], 1), *((hole, 0) for hole in outline["holes"])):
        cv2.fillPoly(canvas, [np.round(np.array(ring) * 16).astype(np.int32)], value, shift=4)
    return canvas.astype(bool)


def _photographs(cases: Path) -> list[Row]:
    clicked: list[float] = []
    boxed: list[float] = []
    seconds: list[float] = []
    fallen: list[str] = []
    covers: list[Cover] = []
    photos: list[Image] = []
    stood = 0
    for folder in sorted(cases.iterdir()):
        if not (folder / "case.yaml").is_file():
            continue
        case = load_case(folder)
        assert case.image is not None
        photos.append(case.image)
        truth = reference_masks(folder.name, case.image.shape[:2])
        if not truth:
            continue
        clicked += _mask_scores(case.image, case.objects, truth)
        boxes = tuple((name, _boxed(grounding, truth[name])) for name, grounding in case.objects)
        boxed += _mask_scores(case.image, boxes, truth)
        state = SceneState(
            objects=tuple(SceneObject(name=name, grounding=g) for name, g in case.objects),
            supports=case.supports,
            landmarks=case.landmarks,
        )
        start = time.perf_counter()
        made = reconstruct(case, state)
        seconds.append((time.perf_counter() - start) * 3 / max(len(case.objects), 3))
        fallen += [f"{folder.name}: {name}" for name in movers(made)]
        stood += standing(made)
        covers += covers_of(made)
    return [
        shown("objects in photographs", len(clicked)),
        at_least("photographs, clicks: mask IoU, median", float(np.median(clicked)), 0.88),
        shown("photographs, clicks: mask IoU, mean", float(np.mean(clicked))),
        at_least("photographs, box: mask IoU, median", float(np.median(boxed)), 0.93),
        shown("photographs: objects that stand", stood),
        at_most("photographs, clicks: objects that move by themselves", len(fallen), 0),
        at_most("photographs: time for three objects, median", float(np.median(seconds)), 6, "s"),
        *cover_rows("photographs", covers),
        *hole_rows(photos),
    ]


def _mask_scores(
    image: Image, objects: Sequence[tuple[str, Grounding]], truth: Mapping[str, BoolArray]
) -> list[float]:
    offers = EmbeddedSegmenter().segment(image, objects)
    masks = choose(offers, objects, image.shape[:2])
    return [iou(masks[name], truth[name]) for name, _ in objects if name in truth]


def _boxed(grounding: Grounding, mask: BoolArray) -> Grounding:
    """The clicks with a box drawn by hand: 4 % wider than the object on each side."""
    return grounding.model_copy(update={"box": boxed(mask).box})
