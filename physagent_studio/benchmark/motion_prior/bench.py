"""`physagent bench motion-prior`: flow, occlusion, speed and files of what is exported."""

import json
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.hostile import hostile
from physagent_studio.benchmark.motion_prior.beside_mujoco import beside_mujoco
from physagent_studio.benchmark.motion_prior.scenes import (
    MOTIONS,
    PLACE,
    SIZE,
    Motion,
    demo_run,
    pair_scene,
    plate,
    plate_scene,
    seen_on_ball,
    seen_on_plate,
)
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError
from physagent_studio.exchange import export_motion_prior, load_peer_config
from physagent_studio.exchange.prior.peer_config import config_of
from physagent_studio.program import PhysicalProgram, SceneObject, SceneState, Support, apply
from physagent_studio.program.program import EventProgram
from physagent_studio.records import Scene
from physagent_studio.rendering import Compositor, Flow, Frame, flow_between

INNER = 3
"""Pixels from outlines within which truth is not asked: a pixel there sees two things."""
REPEATS = 5
IDENTITY = (1.0, 0.0, 0.0, 0.0)


def bench(*, cases: Path | None) -> list[Row]:
    """Everything without a folder of cases; with one, its peers' configurations too."""
    rows = [*against_truth(), *occlusions(), *beside_opencv(), *exported(), *beside_mujoco()]
    rows += hostile()
    if cases is not None:
        rows += _peers(cases)
    return rows


def _frames(motion: Motion) -> tuple[Frame, Frame]:
    compositor = Compositor(plate_scene())
    first = compositor.frame(shadows=False, as_built=True)
    bent = None if motion.bend is None else {"plate": motion.moved(plate().vertices)}
    second = compositor.frame(
        [motion.position], [motion.rotation], bent, shadows=False, as_built=True
    )
    return first, second


def _truth(motion: Motion) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(H, W, 2) flow in closed form, and (H, W) where the plate is seen, off its outline."""
    width, height = SIZE
    grid = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), -1)
    pixels = grid.reshape(-1, 2).astype(np.float64)
    body, on = seen_on_plate(pixels, np.asarray(PLACE))
    camera = plate_scene().state.camera
    assert camera is not None
    target = camera.project(motion.moved(body))[0]
    inner = cv2.erode(on.reshape(height, width).astype(np.uint8), np.ones((2 * INNER + 1,) * 2))
    return (target - pixels).reshape(height, width, 2), inner > 0


def against_truth() -> list[Row]:
    """Exact flow against closed forms, and the next frame taken back along it."""
    mean, worst, warped, still = 0.0, 0.0, 0.0, 0.0
    for motion in MOTIONS:
        first, second = _frames(motion)
        flow = flow_between(first, second)
        truth, inner = _truth(motion)
        off = np.linalg.norm(flow.vectors - truth, axis=-1)[inner]
        mean, worst = max(mean, float(off.mean())), max(worst, float(off.max()))
        still = max(still, float(np.abs(flow.vectors[first.ids < 0]).max()))
        warped = max(warped, _left(first, second, flow, inner))
    return [
        at_most("flow against closed forms, mean, worst of five motions", mean, 0.02, "px"),
        at_most("flow against closed forms, largest", worst, 0.1, "px"),
        at_most("flow of what stands still", still, 0.0, "px"),
        at_most("error left when the next frame is taken back", 100 * warped, 20, "%"),
    ]


def _left(first: Frame, second: Frame, flow: Flow, inner: NDArray[np.bool_]) -> float:
    """Which share of the difference of two frames is left once motion is undone."""
    y, x = np.indices(inner.shape, np.float32)
    where = (x + flow.vectors[..., 0], y + flow.vectors[..., 1])
    back = cv2.remap(second.rgb, *where, cv2.INTER_LINEAR).astype(float)
    used = inner & flow.visible
    off = np.abs(back - first.rgb)[used].mean()
    return float(off / np.abs(second.rgb.astype(float) - first.rgb)[used].mean())


def occlusions() -> list[Row]:
    """F1 of what gets hidden as a ball passes before a plate, against closed forms."""
    compositor, radius = Compositor(pair_scene()), 0.25
    before, after = np.array([-0.2, 2.0, 1.2]), np.array([-0.08, 2.0, 1.22])
    first, second = (
        compositor.frame(np.array([PLACE, ball]), [IDENTITY] * 2, shadows=False, as_built=True)
        for ball in (before, after)
    )
    found = ~flow_between(first, second).visible
    y, x = np.nonzero(first.ids == 0)
    pixels = np.stack([x + 0.5, y + 0.5], 1).astype(np.float64)
    hidden = seen_on_ball(pixels, after, radius)
    told = found[y, x]
    both = np.count_nonzero(hidden & told)
    score = 2 * both / (np.count_nonzero(hidden) + np.count_nonzero(told))
    return [at_least("occlusion F1", score, 0.98)]


def beside_opencv() -> list[Row]:
    """End-point error and seconds of our flow and of OpenCV's on the same pictures."""
    ways: dict[str, Callable[[Frame, Frame], NDArray[np.float32]]] = {
        "ours": lambda one, other: flow_between(one, other).vectors,
        "DIS ultrafast": _dis,
        "Farneback": _farneback,
    }
    errors: dict[str, list[float]] = {name: [] for name in ways}
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    compositor = Compositor(plate_scene())
    for motion in MOTIONS:
        first, second = _frames(motion)
        truth, inner = _truth(motion)
        for _ in range(REPEATS):
            for name, way in ways.items():
                # Each with what it needs: ours a frame's geometry, theirs its picture.
                render = compositor.geometry if name == "ours" else compositor.frame
                started = time.process_time()
                render([motion.position], [motion.rotation])
                flow = way(first, second)
                seconds[name].append(time.process_time() - started)
                errors[name].append(float(np.linalg.norm(flow - truth, axis=-1)[inner].mean()))
    rows = [shown(f"end-point error, {name}", float(np.mean(errors[name])), "px") for name in ways]
    best = float(min(np.mean(errors[name]) for name in ways if name != "ours"))
    rows.append(
        at_most("our error by the best of OpenCV's", float(np.mean(errors["ours"])) / best, 1.0)
    )
    ratio = median(seconds["ours"]) / median(seconds["DIS ultrafast"])
    return [*rows, at_most("our time by that of DIS ultrafast, with a frame each", ratio, 1.0)]


def _grey(frame: Frame) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY), np.uint8)


def _dis(one: Frame, other: Frame) -> NDArray[np.float32]:
    way = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
    found = way.calc(_grey(one), _grey(other), np.zeros((*SIZE[::-1], 2), np.float32))
    return np.asarray(found, np.float32)


def _farneback(one: Frame, other: Frame) -> NDArray[np.float32]:
    start = np.zeros((*SIZE[::-1], 2), np.float32)
    found = cv2.calcOpticalFlowFarneback(_grey(one), _grey(other), start, 0.5, 4, 21, 3, 7, 1.5, 0)
    return np.asarray(found, np.float32)


def exported() -> list[Row]:
    """Seconds and memory of the demo's export."""
    scene, rollout, program = demo_run()
    like_the_photo = _first_frame(scene)
    with tempfile.TemporaryDirectory() as folder:
        cpu, started = time.process_time(), time.perf_counter()
        export_motion_prior(Path(folder) / "prior", scene, rollout, program, 16.0)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - started
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [
        *like_the_photo,
        at_most("export of the demo's prior, processor time", cpu, 6.0, "s"),
        at_most("81 frames with flow, masks, depth and videos", wall, 6.0, "s"),
        at_most("peak memory of this process", memory, 800, "MB"),
    ]


def _first_frame(scene: Scene) -> list[Row]:
    """The first frame beside the photo, outside of things, and whether stillness is still."""
    assert scene.photo is not None
    compositor = Compositor(scene)
    first = compositor.frame().rgb
    outside = ~np.logical_or.reduce(list(scene.masks.values()))
    error = ((first.astype(float) - scene.photo) ** 2)[outside].mean()
    ratio = 10 * np.log10(255**2 / max(error, 1e-4))
    again = all(np.array_equal(compositor.frame().rgb, first) for _ in range(REPEATS))
    return [
        at_least("frame 0 beside the photo, outside of things", float(ratio), 35, "dB"),
        at_least("frames of what does not move that are the same bits", int(again), 1),
    ]


def _peers(cases: Path) -> list[Row]:
    """How many of the peers' configurations in a folder of cases are read, with a report each, and
    carry the same values when they are exported again."""
    files, read, same = sorted(cases.glob("*/peer_config.yaml")), 0, 0
    for file in files:
        try:
            before = _program_of(file, file)
            read += 1
            with tempfile.TemporaryDirectory() as folder:
                again = Path(folder) / "config.yaml"
                again.write_text(json.dumps(config_of(before, None)[0]), encoding="utf-8")
                same += _program_of(again, file) == before
        except InputError:
            continue
    return [
        at_least("peers' configurations read", read, len(files)),
        at_least("the same values once they are exported and read again", same, len(files)),
    ]


def _program_of(config: Path, beside: Path) -> PhysicalProgram:
    """What a configuration says; its picture lies beside another file."""
    setup = load_peer_config(config, photo=beside.parent / "input.png")
    objects = tuple(SceneObject(name=name, grounding=one) for name, one in setup.case.objects)
    scene = SceneState(objects=objects, supports=(*setup.case.supports, Support(name="floor")))
    bare = PhysicalProgram(scene=scene, event=EventProgram(prompt=setup.case.prompt))
    return apply(bare, setup.edits(bare))
