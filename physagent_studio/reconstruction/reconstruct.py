"""`reconstruct`: a picture and a scene state with open fields → a scene with none.

The order: masks, what stands on what, camera and metres, supports, objects from the ground up,
landmarks, textures, background plate, checks. Only what is open is filled; masks and the plate
of an earlier scene are reused where their inputs did not change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import (
    Grounding,
    Landmark,
    SceneObject,
    SceneState,
    Slab,
    Support,
)
from physagent_studio.reconstruction import (
    clicked_supports,
    findings,
    grounds,
    landmarks,
    layout,
    supports,
)
from physagent_studio.reconstruction.bare import scene_without_photo
from physagent_studio.reconstruction.crossing import edges_of, lines_through
from physagent_studio.reconstruction.lines import Segments, segments
from physagent_studio.reconstruction.meshes import support_mesh
from physagent_studio.reconstruction.names import support_kind
from physagent_studio.reconstruction.parts import with_parts
from physagent_studio.reconstruction.placement import Placed, place_all
from physagent_studio.reconstruction.plate import background, hole_of
from physagent_studio.reconstruction.segmentation import (
    EmbeddedSegmenter,
    Segmenter,
    apart,
    choose,
)
from physagent_studio.reconstruction.steady import reaching
from physagent_studio.reconstruction.stored import stated_mesh
from physagent_studio.reconstruction.strokes import corrected
from physagent_studio.reconstruction.survey import Survey, survey
from physagent_studio.reconstruction.texture import textured
from physagent_studio.records.case import Case, Image
from physagent_studio.records.scene import Candidate, Mesh, Scene

BoolArray = NDArray[np.bool_]
VERSION = "4"
"""Changes whenever the same input gives another scene."""
SAME_ROW = 0.5
"""Pixels within which a stated horizon is that of the camera."""
UNASKED = "by its words, nobody clicked it"


class _Run:
    """Progress and cancellation of one reconstruction."""

    def __init__(
        self,
        cancelled: Callable[[], bool] | None,
        progress: Callable[[str, float], None] | None,
    ) -> None:
        self.cancelled = cancelled
        self.progress = progress

    def at(self, what: str, share: float) -> None:
        if self.cancelled is not None and self.cancelled():
            raise Cancelled("the reconstruction was cancelled")
        if self.progress is not None:
            self.progress(what, share)


def reconstruct(
    case: Case,
    state: SceneState,
    *,
    previous: Scene | None = None,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[str, float], None] | None = None,
    segmenter: Segmenter | None = None,
    bodies: Mapping[str, Mesh] | None = None,
    assets: Mapping[str, Mesh] | None = None,
) -> Scene:
    """The scene that a picture shows, every open field of `state` filled.

    previous: an earlier scene of the same picture; what did not change is taken from it.
    bodies: meshes of objects of kind `mesh` that came from elsewhere; they are set down on what
    they stand on. assets: stored meshes by what `Meshed.asset` names, for objects that a person
    has set down beside what the photo shows. cancelled: asked between steps. progress: called with
    the step's name and 0 … 1.
    Without a photo nothing may be open, and the scene is drawn from its shapes.
    Raises InputError where an object was neither clicked nor boxed,
    Cancelled when `cancelled` says so.
    """
    key = scene_hash(case, state)
    if previous is not None and previous.hash == key:
        return previous
    if previous is not None and _same_sight(previous.state, state):
        return replace(previous, state=state, hash=key)
    if case.image is None:
        return scene_without_photo(state, key, assets or {})
    run = _Run(cancelled, progress)
    state = _turned(state)
    scene = _look(case, case.image, state, previous, segmenter, bodies, assets or {}, run)
    run.at("done", 1.0)
    return replace(scene, hash=key)


def _turned(state: SceneState) -> SceneState:
    """The state with its camera turned to a horizon that was edited since the camera was found."""
    camera, row = state.camera, state.horizon
    if camera is None or row is None or abs(camera.horizon - row) < SAME_ROW:
        return state
    turned = Camera.from_horizon(
        camera.size,
        row,
        camera.position[2],
        focal=camera.focal,
        source="given",
        confirmed=state.horizon_source == "person",
        horizon_sigma=1.0,
    )
    return state.model_copy(update={"camera": turned})


def _look(
    case: Case,
    image: Image,
    state: SceneState,
    previous: Scene | None,
    segmenter: Segmenter | None,
    bodies: Mapping[str, Mesh] | None,
    assets: Mapping[str, Mesh],
    run: _Run,
) -> Scene:
    """Every step of a reconstruction in its order; the scene's hash is the caller's."""
    run.at("masks", 0.0)
    candidates = _candidates(case, state, previous, segmenter, run)
    groundings = [(item.name, item.grounding) for item in state.objects]
    masks = choose(candidates, groundings, image.shape[:2], image)
    regions = _regions(state, image, candidates, masks)
    run.at("camera", 0.45)
    found = segments(image)
    stances = layout.read(masks, case.prompt)
    covered = np.any(list(masks.values()), axis=0) if masks else np.zeros(image.shape[:2], bool)
    offers = {
        item.name: [offer.mask for offer in candidates.get(item.name, ())]
        for item in state.supports
    }
    read = survey(case, image, state, stances, regions, found, covered, offers)
    run.at("supports", 0.5)
    solid, open_supports = supports.resolve(state, read, stances, regions, found)
    run.at("objects", 0.55)
    given = {**(previous.meshes if previous is not None else {}), **(bodies or {})}
    placed = place_all(
        state.objects,
        solid,
        masks,
        stances,
        read,
        given,
        frozenset(bodies or ()),
        lambda share: run.at("objects", 0.55 + 0.2 * share),
    )
    solid = _carrying(state, solid, placed)
    marks, open_marks = landmarks.resolve(state.landmarks, read.camera, solid, read.shown)
    done = _completed(state, read, solid, placed, marks, (*open_supports, *open_marks))
    run.at("textures", 0.78)
    meshes = {
        item.name: _skinned(image, masks[item.name], read.camera, item, placed.meshes[item.name])
        for item in placed.objects
        if item.name in placed.meshes
    }
    meshes |= {
        item.name: stated_mesh(item, assets)
        for item in placed.objects
        if findings.is_added(item) and item.name not in meshes
    }
    run.at("background", 0.82)
    plate = _plate(image, masks, previous, found, read.camera, solid)
    run.at("checks", 0.97)
    fixed = _support_meshes(done)
    checks = findings.measure(done, masks, meshes, fixed, read.estimate, image)
    checks += tuple(grounds.measure(state, image, masks))
    return Scene(
        state=done,
        photo=image,
        plate=plate,
        masks=MappingProxyType(masks),
        meshes=MappingProxyType(meshes),
        support_meshes=MappingProxyType(fixed),
        candidates=MappingProxyType(candidates),
        findings=checks,
        hash="",
    )


def _skinned(image: Image, mask: BoolArray, camera: Camera, item: SceneObject, mesh: Mesh) -> Mesh:
    """The body with its stems and handles, the photo on it."""
    return textured(image, mask, camera, item, with_parts(camera, mask, item, mesh))


def _carrying(state: SceneState, solid: tuple[Support, ...], placed: Placed) -> tuple[Support, ...]:
    """Slabs that were read off the picture reach under what is seen to stand on them."""
    given = {item.name for item in state.supports if item.shape is not None}
    out = []
    for support in solid:
        shape = support.shape
        if isinstance(shape, Slab) and support.name not in given:
            standing = [
                (item, placed.meshes[item.name])
                for item in placed.objects
                if item.support == support.name and item.name in placed.meshes
            ]
            shape = reaching(shape, standing)
        out.append(support.model_copy(update={"shape": shape}))
    return tuple(out)


def _completed(
    state: SceneState,
    read: Survey,
    solid: tuple[Support, ...],
    placed: Placed,
    marks: tuple[Landmark, ...],
    still_open: tuple[str, ...],
) -> SceneState:
    """The given state with everything that was found put in."""
    said = (flag for flag in state.flags if not flag.endswith(UNASKED))
    flags = tuple(dict.fromkeys((*said, *_proposals(state), *still_open)))
    return state.model_copy(
        update={
            "camera": read.camera,
            "horizon": read.camera.horizon,
            "horizon_source": state.horizon_source if state.horizon is not None else "estimated",
            "scale": read.scale,
            "objects": placed.objects,
            "supports": solid,
            "landmarks": marks,
            "flags": flags[:64],
        }
    )


def _proposals(state: SceneState) -> list[str]:
    """Sentences about things that were found by their words."""
    return [
        f"{item.name} was found at ({click.x:.0f}, {click.y:.0f}) {UNASKED}"
        for item in state.objects
        if item.grounding.proposed
        for click in item.grounding.points[:1]
    ]


_UNSEEN = ("material", "density", "friction", "restitution", "rolling", "body")
"""Fields of objects and supports that no picture shows: changing them changes no geometry."""


def _same_sight(before: SceneState, after: SceneState) -> bool:
    """Whether a completed state differs only in what a picture does not show, or in landmarks
    that have their points already."""
    placed = all(mark.points is not None or not mark.pixels for mark in after.landmarks)
    return placed and after.is_resolved and _sight(before) == _sight(after)


def _sight(state: SceneState) -> dict[str, object]:
    data = state.model_dump(exclude={"landmarks", "flags"})
    for item in (*data["objects"], *data["supports"]):
        for field in _UNSEEN:
            item.pop(field, None)
    return data


def scene_hash(case: Case, state: SceneState) -> str:
    """SHA-256 of everything that a reconstruction depends on."""
    parts = [VERSION, case.image_hash, case.prompt, state.model_dump_json()]
    if case.focal is not None:
        parts.append(f"{case.focal:.3f}")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _candidates(
    case: Case,
    state: SceneState,
    previous: Scene | None,
    segmenter: Segmenter | None,
    run: _Run,
) -> dict[str, tuple[Candidate, ...]]:
    """Candidates of objects and of clicked supports; reused where no click changed."""
    assert case.image is not None
    tasks = _clicked(state)
    for name, grounding in tasks:
        height, width = case.image.shape[:2]
        for click in grounding.points:
            if not (0 <= click.x < width and 0 <= click.y < height):
                raise InputError(
                    f"the click ({click.x:g}, {click.y:g}) on '{name}' lies outside the picture"
                    f" of {width} × {height} pixels"
                )
    for item in state.objects:
        wanted = item.shape is None or item.position is None
        if wanted and not item.grounding.shows_something:
            raise InputError(f"'{item.name}' is not marked in the photo: click it, or draw a box")
    known = _known(previous, tasks)
    asked = tasks if segmenter is not None else [t for t in apart(tasks) if t[0] not in known]
    if len(known) < len(tasks):
        fresh = (segmenter or EmbeddedSegmenter()).segment(case.image, asked, run.cancelled)
        known = {name: fresh.get(name, known.get(name, ())) for name, _ in tasks}
    run.at("masks", 0.44)
    return known


def _clicked(state: SceneState) -> list[tuple[str, Grounding]]:
    tasks = [(item.name, item.grounding) for item in state.objects]
    tasks += [
        (item.name, item.grounding)
        for item in state.supports
        if item.grounding.points and support_kind(item.name) in ("slab", "ramp")
    ]
    return tasks


def _known(
    previous: Scene | None, tasks: list[tuple[str, Grounding]]
) -> dict[str, tuple[Candidate, ...]]:
    """Candidates of an earlier scene, of the things for whose masks nothing has changed."""
    if previous is None:
        return {}
    before = dict(apart(_clicked(previous.state)))
    return {
        name: previous.candidates[name]
        for name, said in apart(tasks)
        if before.get(name) == said and name in previous.candidates
    }


def _regions(
    state: SceneState,
    image: Image,
    candidates: Mapping[str, tuple[Candidate, ...]],
    masks: Mapping[str, BoolArray],
) -> dict[str, BoolArray]:
    """Masks of the clicked supports, without the objects in front of them."""
    out: dict[str, BoolArray] = {}
    size = next((mask.shape for mask in masks.values()), (0, 0))
    for item in state.supports:
        offers = candidates.get(item.name, ())
        marked = clicked_supports.region_of(item, (size[0], size[1]))
        if marked is not None:
            out[item.name] = marked & ~np.any(list(masks.values()), axis=0)
        if marked is not None or not offers or support_kind(item.name) != "slab":
            continue
        chosen = offers[min(item.grounding.candidate, len(offers) - 1)].mask
        region = corrected(image, chosen, item.grounding.strokes).copy()
        for offer in offers[1:] if item.grounding.candidate == 0 else ():
            # Part of a table is often taken for all of it: what is about as likely joins in.
            if offer.score > 0.75 * offers[0].score:
                region |= offer.mask
        for mask in masks.values():
            region &= ~mask
        out[item.name] = region
    return out


def _plate(
    image: Image,
    masks: Mapping[str, BoolArray],
    previous: Scene | None,
    found: Segments,
    camera: Camera,
    solid: tuple[Support, ...],
) -> Image:
    """The background; that of an earlier scene if the objects are the same."""
    if previous is not None and previous.plate is not None and previous.photo is not None:
        same = previous.masks.keys() == masks.keys() and np.array_equal(previous.photo, image)
        if same and all(np.array_equal(previous.masks[name], masks[name]) for name in masks):
            return previous.plate
    hole = hole_of(list(masks.values()), image.shape[:2])
    lines = [lines_through(image, hole, found), edges_of(image, hole, camera, solid)]
    return background(image, list(masks.values()), np.concatenate(lines))


def _support_meshes(state: SceneState) -> dict[str, Mesh]:
    places = [item.position for item in state.objects if item.position is not None]
    reach = 2.0 * max((float(np.hypot(p[0], p[1])) for p in places), default=1.0)
    return {
        item.name: support_mesh(item.shape, reach)
        for item in state.supports
        if item.shape is not None
    }
