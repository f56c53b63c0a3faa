"""Where things are on a step, how much room a scene takes, and who is held."""

from collections.abc import Mapping, Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import FixObject
from physagent_studio.program.scene.aloft import hangs
from physagent_studio.records import Mesh
from physagent_studio.studio.scene.primitives import color_of
from physagent_studio.workbench import Snapshot

Poses = dict[str, tuple[FloatArray, FloatArray]]
"""Object name → position, m, and rotation, wxyz."""


def held_at(snapshot: Snapshot, step: int) -> frozenset[str]:
    """The objects that an action keeps where they are on a step, or that still hang there."""
    rollout, program = snapshot.rollout, snapshot.program
    if rollout is None:
        return frozenset()
    ran = [
        (program.action(span.id), span.start, rollout.steps + 1 if span.end is None else span.end)
        for span in rollout.spans
        if span.start is not None
    ]
    held = {a.name for a, from_, to in ran if isinstance(a, FixObject) and from_ <= step < to}
    moved = {a.name for a, from_, _ in ran if a is not None and from_ <= step}
    return frozenset(held | {o.name for o in program.scene.objects if hangs(o)} - moved)


def poses_at(snapshot: Snapshot, step: int) -> Poses:
    """Position and rotation (wxyz) of every object at a step; as placed where nothing ran."""
    rollout = snapshot.rollout
    poses = {
        item.name: (np.array(item.position), np.array(item.rotation))
        for item in snapshot.program.scene.objects
        if item.position is not None
    }
    if rollout is not None:
        row = min(step, rollout.steps)
        for at, name in enumerate(rollout.objects):
            poses[name] = (rollout.positions[row, at], rollout.rotations[row, at])
    return poses


def centre_and_size(program: PhysicalProgram) -> tuple[FloatArray, float]:
    """Middle of the objects, world, m, and a length that suits their spread."""
    places = [np.array(o.position) for o in program.scene.objects if o.position is not None]
    if not places:
        return np.zeros(3), 1.0
    points = np.array(places)
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.3)


def small(image: NDArray[np.uint8], longest: int = 640) -> NDArray[np.uint8]:
    """The picture thinned out to at most `longest` pixels a side."""
    stride = max(1, -(-max(image.shape[:2]) // longest))
    return np.ascontiguousarray(image[::stride, ::stride])


Color = tuple[int, int, int]
APART = 22.0
"""Distance in CIE L*a*b* from which on two small squares are told apart at a glance."""
DARKEST, LIGHTEST = 35.0, 82.0
"""Lightness L* within which a line is seen on white and on nearly black."""
CLEARER = 1.4
"""What a* and b* are multiplied by: a mean over light and shade is duller than the thing looks."""
STEP = 11.0
"""Steps of L* in which a colour is made lighter or darker."""


def colours_of(snapshot: Snapshot) -> dict[str, Color]:
    """The colour of each thing of the scene on view, by its name."""
    names = dict.fromkeys(item.name for item in snapshot.program.scene.objects)
    if snapshot.rollout is not None:  # of what was taken out since, the path is still drawn
        names |= dict.fromkeys(snapshot.rollout.objects)
    return own_colours(tuple(names), {} if snapshot.scene is None else snapshot.scene.meshes)


def own_colours(names: Sequence[str], meshes: Mapping[str, Mesh]) -> dict[str, Color]:
    """Colours of things, in their order, from what they are drawn as; without it by their names."""
    own = tuple(meshes[name].color if name in meshes else color_of(name) for name in names)
    return dict(zip(names, apart(own), strict=True))


@lru_cache(maxsize=16)
def apart(colours: tuple[Color, ...]) -> tuple[Color, ...]:
    """The same colours, clearer, and where two are alike the later one lighter or darker."""
    levels = np.arange(DARKEST, LIGHTEST + 1, STEP)
    taken: list[FloatArray] = []
    for colour in colours:
        lab = _lab(colour) * [1.0, CLEARER, CLEARER]
        lab[0] = np.clip(lab[0], DARKEST, LIGHTEST)
        nearest = sorted(levels, key=lambda level, own=lab[0]: abs(level - own))
        tries = [lab, *(np.array([level, *lab[1:]]) for level in nearest)]
        free = [min((float(np.linalg.norm(t - o)) for o in taken), default=APART) for t in tries]
        at = next((at for at, room in enumerate(free) if room >= APART), int(np.argmax(free)))
        taken.append(tries[at])
    return tuple(_rgb(lab) for lab in taken)


def _lab(colour: Color) -> FloatArray:
    pixel = np.array(colour, np.float32).reshape(1, 1, 3) / 255
    return cv2.cvtColor(pixel, cv2.COLOR_RGB2LAB)[0, 0].astype(np.float64)


def _rgb(lab: FloatArray) -> Color:
    pixel = cv2.cvtColor(lab.astype(np.float32).reshape(1, 1, 3), cv2.COLOR_LAB2RGB)[0, 0]
    red, green, blue = (round(float(part) * 255) for part in np.clip(pixel, 0, 1))
    return red, green, blue
