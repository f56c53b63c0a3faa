"""Preflight of the scene: overlaps, things in the air, sizes, densities, tunnelling."""

import math
from collections.abc import Iterator

import numpy as np
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import ProgramError
from physagent_studio.program.actions import FixObject
from physagent_studio.program.edits import Edit, RemoveItem, SetField, apply
from physagent_studio.program.preflight.clashes import PreflightFinding, finding
from physagent_studio.program.preflight.mechanics import (
    expected_speed,
    gravity_of,
    standing,
)
from physagent_studio.program.preflight.scaling import scaled, shape_scaled, shape_thickened
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.aloft import AIR, in_air
from physagent_studio.program.scene.boards import is_hollow
from physagent_studio.program.scene.materials import MATERIALS
from physagent_studio.program.scene.shapes import (
    Placed,
    gap,
    lowest,
    outline_of,
    place_object,
    stretched,
)
from physagent_studio.program.scene.state import SceneObject, Slab

SAFETY = 3.0
"""Engine steps that a fast body takes at least to cross another and its own extent."""
FASTEST = 150.0
"""m/s above which nothing in an everyday picture moves."""
LARGEST, SMALLEST, THINNEST = 50.0, 0.003, 0.002
"""m: largest extents, and a smallest one, beyond which something was hardly meant so."""
EVERYDAY = 0.3
"""m: as large as things in a picture mostly are."""
TOUCHING = 0.02
"""Gaps and overlaps up to this part of a body's smallest extent count as touching."""


def scene_findings(program: PhysicalProgram) -> Iterator[PreflightFinding]:
    """Everything about the start that does not depend on the schedule."""
    placed = standing(program.scene)
    for item in program.scene.objects:
        yield from _density(item)
        yield from _size(item)
    yield from _collisions(program, placed)
    yield from _floating(program, placed)
    yield from _tunnelling(program)
    yield from _landmarks(program)


def _density(item: SceneObject) -> Iterator[PreflightFinding]:
    path = f"scene.objects.{item.name}"
    if item.density is None:
        return
    usual = MATERIALS[item.material].density
    if not usual / 15 <= item.density <= usual * 15 or item.density > 23_000:
        message = f"{item.density:g} kg/m³ is far from the {usual:g} kg/m³ of {item.material}"
        edits = (SetField(path=f"{path}.density", value=usual),)
        yield finding("implausible_density", f"{path}.density", message, edits)


def _size(item: SceneObject) -> Iterator[PreflightFinding]:
    if item.shape is None:
        return
    low, high = float(outline_of(item.shape).size.min()), float(outline_of(item.shape).size.max())
    path = f"scene.objects.{item.name}.shape"
    if high > LARGEST or high < SMALLEST:
        message = f"it is {high:.3g} m large, which no event in a picture is likely to have"
        yield finding("implausible_size", path, message, _other_unit(item, high))
    elif low < THINNEST and item.body.kind == "rigid":
        message = f"it is {low * 1000:.2g} mm thin; contacts may let it through"
        thicker = shape_thickened(item.shape, low, THINNEST).model_dump(mode="json")
        edits = (SetField(path=path, value=thicker),)
        yield finding("implausible_size", path, message, edits)


def _other_unit(item: SceneObject, size: float) -> tuple[SetField, ...]:
    """The size in another unit, as near to everyday as it gets; it stands where it stood."""
    assert item.shape is not None
    factor = 10.0 ** -round(math.log10(size / EVERYDAY))
    shape = shape_scaled(item.shape, factor)
    path = f"scene.objects.{item.name}"
    edits = [SetField(path=f"{path}.shape", value=shape.model_dump(mode="json"))]
    if item.position is not None:
        x, y, z = item.position
        foot = float(lowest(place_object(item.shape, item.position, item.rotation))[0])
        place: list[JsonValue] = [x, y, round(foot + (z - foot) * factor, 5)]
        edits.append(SetField(path=f"{path}.position", value=place))
    return tuple(edits)


def _extent(program: PhysicalProgram, name: str) -> float:
    item = program.scene.object(name)
    if item is None or item.shape is None:
        return math.inf
    return float(outline_of(item.shape).size.min())


def _collisions(program: PhysicalProgram, placed: dict[str, Placed]) -> Iterator[PreflightFinding]:
    names = list(placed)
    for index, first in enumerate(names):
        if program.scene.object(first) is None:
            break
        for second in names[index + 1 :]:
            scene = program.scene
            others = [scene.object(name) or scene.support(name) for name in (first, second)]
            if any(item and is_hollow(item.shape) for item in others):
                # One may well be inside the other.
                continue
            depth = overlap(placed[first], placed[second])
            allowed = max(TOUCHING * min(_extent(program, first), _extent(program, second)), 1e-3)
            if depth > allowed:
                yield _collision(program, placed, first, second, depth)


def _collision(
    program: PhysicalProgram, placed: dict[str, Placed], first: str, second: str, depth: float
) -> PreflightFinding:
    path = f"scene.objects.{first}.position"
    message = f"{first} starts {depth * 1000:.0f} mm inside {second}"
    item = program.scene.object(first)
    edits: tuple[SetField, ...] = ()
    if item is not None and item.position is not None:
        shift = way_out(placed[first], placed[second], upward=True) * 1.001
        free: list[JsonValue] = [round(float(part), 5) for part in np.add(item.position, shift)]
        edits = (SetField(path=path, value=free),)
    return finding("collision", path, message, edits)


def _floating(program: PhysicalProgram, placed: dict[str, Placed]) -> Iterator[PreflightFinding]:
    held = {
        a.name
        for a in program.event.actions
        if isinstance(a, FixObject) and a.start_step == 0 and a.when is None and not a.muted
    }
    if gravity_of(program.scene) < 1e-6:
        return
    for item in program.scene.objects:
        if item.name not in placed or in_air(item) or item.name in held:
            continue
        if item.body.kind != "rigid" and getattr(item.body, "pinned", "none") != "none":
            continue
        yield from _loose(program, placed, item)


def _loose(
    program: PhysicalProgram, placed: dict[str, Placed], item: SceneObject
) -> Iterator[PreflightFinding]:
    body, path = placed[item.name], f"scene.objects.{item.name}"
    gaps = {
        other: max(float(gap(body, solid)[0]), 0.0)
        for other, solid in placed.items()
        if other != item.name
    }
    slack = max(2 * TOUCHING * _extent(program, item.name), 5e-3)
    if item.support is not None and item.support in gaps:
        if gaps[item.support] > slack:
            distance = gaps[item.support]
            message = f"it stands on {item.support} but starts {distance:.2f} m from it"
            edits = (SetField(path=f"{path}.support", value=AIR),)
            yield finding("not_on_support", f"{path}.position", message, edits)
    elif item.support is None and min(gaps.values(), default=math.inf) > slack:
        yield _in_the_air(program, body, item)


def _in_the_air(program: PhysicalProgram, body: Placed, item: SceneObject) -> PreflightFinding:
    floors = [s.shape.height for s in program.scene.supports if s.shape and s.shape.kind == "floor"]
    path = f"scene.objects.{item.name}.position"
    if not floors or item.position is None:
        message = "it starts in the air and nothing is below it"
        meant = (SetField(path=f"scene.objects.{item.name}.support", value=AIR),)
        return finding("in_the_air", path, message, meant)
    drop = float(lowest(body)[0]) - max(floors)
    message = f"it starts in the air, {drop:.2f} m above the floor, and will fall"
    x, y, z = item.position
    edits = (SetField(path=path, value=[x, y, round(z - drop, 4)]),) if drop > 0 else ()
    return finding("in_the_air", path, message, edits)


def _tunnelling(program: PhysicalProgram) -> Iterator[PreflightFinding]:
    """The engine refines its steps by itself; past its limit, or by much, a person should know."""
    sizes = {
        item.name: float(outline_of(item.shape).size.min())
        for item in program.scene.objects
        if item.shape is not None
    }
    walls = [min(s.shape.size) for s in program.scene.supports if isinstance(s.shape, Slab)]
    clip = program.clip
    for item in program.scene.objects:
        others = [size for name, size in sizes.items() if name != item.name] + walls
        if item.name not in sizes or not others:
            continue
        speed = expected_speed(program, item)
        path = f"scene.objects.{item.name}"
        if speed > FASTEST:
            message = f"the actions may drive it to {speed:.0f} m/s"
            yield finding("implausible_speed", path, message, _slower(program, item))
        finest = (sizes[item.name] + min(others)) / (SAFETY * max(speed, 1e-9))
        needed = math.ceil(clip.step_seconds / finest - 1e-9)
        if needed > clip.substeps:
            message = (
                f"at {speed:.1f} m/s it could pass through something {min(others) * 1000:.0f} mm "
                f"thin; the engine needs {needed} substeps, not {clip.substeps}"
            )
            edits = (SetField(path="clip.substeps", value=min(needed, 1000)),)
            yield finding("tunnelling", path, message, edits)


def _slower(program: PhysicalProgram, item: SceneObject) -> tuple[Edit, ...]:
    """Its actions, all weaker by the same factor; what it falls stays as it is."""
    edits: list[Edit] = []
    factor = 1.0
    for _ in range(6):
        slower = apply(program, edits) if edits else program
        changed = slower.scene.object(item.name)
        assert changed is not None
        speed = expected_speed(slower, changed)
        if speed <= FASTEST:
            return tuple(edits)
        factor *= 0.9 * FASTEST / speed
        mine = (a for a in program.event.actions if a.name == item.name and not a.muted)
        edits = [edit for action in mine for edit in scaled(action, factor)]
        if not edits:
            break
    return ()


def _landmarks(program: PhysicalProgram) -> Iterator[PreflightFinding]:
    for landmark in program.scene.landmarks:
        if not landmark.points and not landmark.pixels:
            message = "it has neither pixels nor points, so nothing can be measured at it"
            path = f"scene.landmarks.{landmark.name}"
            edits: tuple[Edit, ...] = (RemoveItem(path=path),)
            try:
                apply(program, edits)
            except ProgramError:
                # Something speaks of it: only a person can say where it is.
                edits = ()
            yield finding("unplaced", path, message, edits)


_TINY = 1e-12


def overlap(first: Placed, second: Placed) -> float:
    """How deep two bodies overlap at their first pose, m; 0 where they do not, bounded above."""
    return float(np.linalg.norm(way_out(first, second)))


def way_out(first: Placed, second: Placed, upward: bool = False) -> FloatArray:
    """(3,) the shortest shift of the first body that frees it from the second, m; 0 if it is free.

    The best over the directions of both bodies' axes, the line between their centres and a
    sphere of further directions. upward: only shifts that do not go down.
    """
    if first.half_space is not None:
        return -way_out(second, first) if second.half_space is None else np.zeros(3)
    if second.half_space is not None:
        return max(0.0, -float(gap(first, second)[0])) * second.half_space.normal
    one, two = first.at(slice(0, 1)), second.at(slice(0, 1))
    if float(gap(one, two)[0]) > 1e-6:
        return np.zeros(3)
    between = two.positions - one.positions
    ways = np.concatenate([one.matrices[0].T, two.matrices[0].T, between, _sphere(96)])
    ways = np.concatenate([ways, -ways])
    lengths = np.linalg.norm(ways, axis=-1, keepdims=True)
    ways = (ways / np.maximum(lengths, _TINY))[lengths[:, 0] > _TINY]
    if upward:
        ways = ways[ways[:, 2] <= 1e-9]
    one, two = stretched(one, len(ways)), stretched(two, len(ways))
    depth = np.sum(one.support(ways) * ways, -1) - np.sum(two.support(-ways) * ways, -1)
    best = int(depth.argmin())
    return -max(0.0, float(depth[best])) * ways[best]


def _sphere(count: int) -> FloatArray:
    """(count, 3) directions spread evenly over a sphere (Fibonacci)."""
    index = np.arange(count) + 0.5
    z = 1 - 2 * index / count
    angle = np.pi * (1 + math.sqrt(5)) * index
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=-1)
