"""What a person's hand in the photo changes: groups of typed edits, each one step of undo.

A correction opens everything that was read off the picture with it, so that reconstruction finds
it anew and the scene follows. What the person has pinned, or has brought along, stays.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np
from pydantic import JsonValue

from physagent_studio.agent.rules.scene.footing import with_depth, with_room, with_walls_weighed
from physagent_studio.agent.rules.scene.materials import material_of
from physagent_studio.errors import InputError
from physagent_studio.knowledge import support_kind, usual_size
from physagent_studio.language.hints import called
from physagent_studio.program import AddItem, Edit, Grounding, PhysicalProgram, SetField
from physagent_studio.program.base import Pixel, free_name, overlap
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    FormKind,
    Landmark,
    Mark,
    SceneObject,
    SceneState,
)
from physagent_studio.reconstruction.grounding.same_kind import kind_name
from physagent_studio.reconstruction.masks.segmenter import settled
from physagent_studio.records import Case, ShapeOffer

FORMS: tuple[FormKind, ...] = (
    "sphere", "ellipsoid", "cylinder", "frustum", "capsule", "torus", "box", "revolved", "inflated",
    "board",
)  # fmt: skip
SMALLEST, LARGEST = 1e-3, 1e3
"""Sizes that may be typed, m."""
FAR = 8.0
"""How many pictures away a landmark's place in the picture may lie that is kept."""


def mask_edits(
    program: PhysicalProgram,
    case: Case,
    pinned: Collection[str],
    name: str,
    grounding: Grounding,
    *,
    layer: bool = False,
    wrong: Collection[str] = (),
) -> tuple[Edit, ...]:
    """A person's mask: clicks, box, strokes and the chosen candidate of an object or support.

    A name that is not there yet becomes an object. layer: it is a layer of a stack, which the
    clicks on the others go on to tell apart. wrong: things whose clicks are wrong, so that
    they do not count as outside of this one. Raises InputError for clicks outside the
    picture, and for a grounding that shows nothing.
    """
    scene = program.scene
    check_grounding(case, name, grounding)
    grounding = grounding.model_copy(update={"proposed": False})
    if scene.support(name) is not None:
        path = f"scene.supports.{name}"
        opened = [SetField(path=f"{path}.shape", value=None)]
        opened += opened_objects(_carried(scene, name), pinned, ("position",))
    else:
        path = f"scene.objects.{name}"
        said = [(o.name, o.grounding) for o in scene.objects if o.name not in {name, *wrong}]
        if not layer:
            grounding = settled(name, [*said, (name, grounding)])
        item = scene.object(name)
        if item is None:
            material = material_of(name, case.prompt)
            item = SceneObject(name=name, grounding=grounding, material=material)
            return (AddItem(path="scene.objects", item=item.model_dump(mode="json")),)
        # What it stands on, and whether anything stands on it, was read off the mask that it had.
        there = [o for o in (item, *_carried(scene, name)) if not in_air(o)]
        opened = opened_objects(there, pinned, ("support", "shape", "position"))
        if in_air(item):
            opened += opened_objects((item,), pinned, ("shape", "position"))
    value = grounding.model_dump(mode="json")
    return (SetField(path=f"{path}.grounding", value=value), *opened)


def alike_edits(
    program: PhysicalProgram,
    case: Case,
    pinned: Collection[str],
    like: str,
    boxes: Sequence[tuple[float, float, float, float]],
) -> tuple[Edit, ...]:
    """New things in boxes, each of the kind of the thing that they are like."""
    stem, edits = kind_name(like).replace(" ", "_"), list[Edit]()
    names = {item.name for item in (*program.scene.objects, *program.scene.supports)}
    free = (name for number in range(2, 400) if (name := f"{stem}_{number}") not in names)
    for name, box in zip(free, boxes, strict=False):
        edits += mask_edits(program, case, pinned, name, Grounding(box=box))
    return tuple(edits)


def check_grounding(case: Case, name: str, grounding: Grounding) -> None:
    """Raises InputError where a grounding shows nothing, or clicks lie outside the picture."""
    if case.image is None:
        raise InputError("this program has no photo to click in")
    if not grounding.shows_something:
        raise InputError(f"nothing is marked as inside {name}; click, box or paint it")
    height, width = case.image.shape[:2]
    for click in grounding.points:
        if not (0 <= click.x < width and 0 <= click.y < height):
            raise InputError(
                f"the click ({click.x:g}, {click.y:g}) on '{name}' lies outside the picture"
                f" of {width} × {height} pixels"
            )


def horizon_edits(
    program: PhysicalProgram,
    case: Case,
    pinned: Collection[str],
    row: float,
    roll: float | None = None,
) -> tuple[Edit, ...]:
    """The horizon at a row of the picture's middle column; the whole scene follows.

    roll: degrees by which it rises to the right, as it is where it is None.
    """
    if case.image is None:
        raise InputError("this program has no photo to draw a horizon in")
    height = case.image.shape[0]
    if not math.isfinite(row) or abs(row - height / 2) > 10 * height:
        raise InputError(f"the horizon at row {row:g} is too far from the picture")
    given = (
        SetField(path="scene.horizon", value=round(row, 2)),
        SetField(path="scene.horizon_source", value="person"),
    )
    if roll is not None and roll != program.scene.roll:
        given = (*given, SetField(path="scene.roll", value=round(roll, 2)))
    return (*given, *_opened_scene(program.scene, pinned, horizon=False))


def size_edits(
    program: PhysicalProgram, case: Case, pinned: Collection[str], name: str, metres: float
) -> tuple[Edit, ...]:
    """The larger visible extent of an object, m; every other size and distance follows."""
    if program.scene.object(name) is None:
        raise InputError(f"there is no object '{name}' to give a size")
    if not SMALLEST <= metres <= LARGEST:
        raise InputError(f"{metres:g} m is no size of a thing ({SMALLEST:g} … {LARGEST:g})")
    scale: dict[str, JsonValue] = {"reference": name, "metres": metres, "source": "person"}
    stays = program.scene.horizon_source == "person" or program.scene.horizon == case.horizon
    return (
        SetField(path="scene.scale", value=scale),
        *_opened_scene(program.scene, pinned, horizon=not stays),
    )


def ramp_edits(
    program: PhysicalProgram,
    case: Case,
    pinned: Collection[str],
    name: str,
    marks: tuple[Pixel, Pixel, Pixel],
) -> tuple[Edit, ...]:
    """A ramp by its toe, the foot below its top, and its top, pixels; name "" makes a new one."""
    if case.image is None:
        raise InputError("this program has no photo to place a ramp in")
    scene = program.scene
    toe, foot, top = marks
    if math.dist(toe, foot) < 4 or foot[1] - top[1] < 2:
        raise InputError(
            "a ramp takes three clicks: its toe on the ground, the place on the ground below its "
            "upper end, and that upper end above it"
        )
    said = zip(("toe", "foot", "top"), marks, strict=True)
    listed: list[JsonValue] = [
        Mark(role=role, x=x, y=y).model_dump(mode="json") for role, (x, y) in said
    ]
    objects = [o for o in scene.objects if not in_air(o)]
    opened = opened_objects(objects, pinned, ("support", "shape", "position"))
    support = scene.support(name)
    if support is None:
        fresh: dict[str, JsonValue] = {
            "name": free_name("ramp", scene.names),
            "grounding": {"marks": listed},
        }
        return (AddItem(path="scene.supports", item=fresh), *opened)
    if support_kind(name) != "ramp":
        raise InputError(
            f"'{name}' is no ramp by its name; select a ramp, or nothing for a new one"
        )
    path = f"scene.supports.{name}"
    grounding: dict[str, JsonValue] = {"points": [], "marks": listed}
    return (
        SetField(path=f"{path}.grounding", value=grounding),
        SetField(path=f"{path}.shape", value=None),
        *opened,
    )


def form_edits(
    program: PhysicalProgram,
    pinned: Collection[str],
    name: str,
    kind: FormKind | None,
    offers: Sequence[ShapeOffer] = (),
) -> tuple[Edit, ...]:
    """Another kind of shape for an object: the one that is asked for, or the next of its kinds.

    offers: the kinds that were fitted to its mask, best first: they come before all others.
    """
    item = program.scene.object(name)
    if item is None:
        raise InputError("select an object first, then switch its shape")
    if not item.grounding.shows_something:
        raise InputError(f"{name} is not marked in the photo, so no other shape can be fitted")
    if kind is None:
        kinds = forms_of(name, program.event.prompt, offers)
        now = item.form or (item.shape.kind if item.shape is not None else None)
        kind = kinds[(kinds.index(now) + 1) % len(kinds) if now in kinds else 0]
    path = f"scene.objects.{name}"
    return (
        SetField(path=f"{path}.form", value=kind),
        SetField(path=f"{path}.shape", value=None),
        *opened_objects((item,), pinned, ("position",)),
        *opened_objects(_carried(program.scene, name), pinned, ("position",)),
    )


def forms_of(name: str, prompt: str, offers: Sequence[ShapeOffer] = ()) -> tuple[FormKind, ...]:
    """All kinds of shape: those that were fitted to its mask, best first, then those that are
    usual for a thing of that name, then the others."""
    usual = usual_size(called(name, prompt)).shapes
    ranks = {offer.kind: rank for rank, offer in enumerate(offers)}

    def order(kind: FormKind) -> tuple[int, bool, int]:
        return ranks.get(kind, len(ranks)), kind not in usual, FORMS.index(kind)

    return tuple(sorted(FORMS, key=order))


def stated(state: SceneState) -> SceneState:
    """A freshly completed state with room on its ramps and depth in its bodies, as a first has."""
    return with_walls_weighed(with_room(with_depth(state)))


# --- what follows a correction -----------------------------------------------------------------


def _carried(scene: SceneState, name: str) -> list[SceneObject]:
    """The objects that stand on one of that name, or on such an object."""
    found, names = [], [name]
    for below in names:
        for item in scene.objects:
            if item.support == below and item.name not in names:
                names.append(item.name)
                found.append(item)
    return found


def _opened_scene(
    scene: SceneState, pinned: Collection[str], *, horizon: bool
) -> Iterator[SetField]:
    """Everything that hangs on the camera."""
    paths = ["scene.camera", *(["scene.horizon"] if horizon else [])]
    yield from _opened(paths, pinned)
    yield from opened_objects(scene.objects, pinned, ("shape", "position"))
    estimated = (one for one in scene.supports if one.source in ("estimated", "assumed"))
    yield from _opened([f"scene.supports.{one.name}.shape" for one in estimated], pinned)
    for mark in scene.landmarks:
        yield from _followed(mark, scene.camera, pinned)


def _followed(mark: Landmark, camera: Camera | None, pinned: Collection[str]) -> Iterator[SetField]:
    """A landmark stays where it is in the picture; one without pixels gets those it is seen at."""
    path = f"scene.landmarks.{mark.name}"
    if any(overlap(f"{path}.points", fact) for fact in pinned):
        return
    if not mark.pixels and mark.points and camera and mark.source not in ("person", "given"):
        pixels, depth = camera.project(np.array(mark.points))
        if (depth > 0).all() and (np.abs(pixels) < FAR * max(camera.size)).all():
            seen: JsonValue = [[round(float(x), 1), round(float(y), 1)] for x, y in pixels]
            yield SetField(path=f"{path}.pixels", value=seen)
            yield SetField(path=f"{path}.points", value=None)
    elif mark.pixels:
        yield SetField(path=f"{path}.points", value=None)


def opened_objects(
    items: Iterable[SceneObject], pinned: Collection[str], fields: tuple[str, ...]
) -> list[SetField]:
    """Fields of objects that the picture shows.

    A shape is found together with its place, so one whose place is pinned stays; so does a mesh
    from elsewhere.
    """
    paths = []
    for item in items:
        if not item.grounding.shows_something or item.source == "person":
            continue
        path = f"scene.objects.{item.name}"
        meshed = item.shape is not None and item.shape.kind == "mesh"
        held = any(overlap(f"{path}.position", fact) for fact in pinned)
        kept = {"shape"} if meshed or held else set()
        paths += [f"{path}.{field}" for field in fields if field not in kept]
    return list(_opened(paths, pinned))


def _opened(paths: Iterable[str], pinned: Collection[str]) -> Iterator[SetField]:
    for path in paths:
        if not any(overlap(path, fact) for fact in pinned):
            yield SetField(path=path, value=None)
