"""`reconstruct`: a picture and a scene state with open fields → a scene with none.

The order: masks, what stands on what, camera and metres, supports, objects from the ground up,
landmarks, textures, background plate, checks. Only what is open is filled; masks and the plate
of an earlier scene are reused where their inputs did not change.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.errors import Cancelled
from physagent_studio.language import SceneHints, hints
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Landmark,
    SceneState,
    Slab,
    Support,
)
from physagent_studio.reconstruction import checks as findings
from physagent_studio.reconstruction.background.scene_plate import scene_plate
from physagent_studio.reconstruction.cache import same_sight, scene_hash
from physagent_studio.reconstruction.learned.at_hand import NOTHING, Inpainting, Learned, uses_of
from physagent_studio.reconstruction.masks import click_checks as grounds
from physagent_studio.reconstruction.masks.foot_spill import sound_masks
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, Segmenter, choose
from physagent_studio.reconstruction.masks.sureness import doubting, sureness
from physagent_studio.reconstruction.photo.line_segments import Segments, segments
from physagent_studio.reconstruction.placement import basins, supports
from physagent_studio.reconstruction.placement.place import Ground, Placed, place_all
from physagent_studio.reconstruction.placement.static_stability import reaching
from physagent_studio.reconstruction.shapes.meshes import support_mesh
from physagent_studio.reconstruction.shapes.offers import ranked, ranking
from physagent_studio.reconstruction.shapes.stated_meshes import stated_mesh
from physagent_studio.reconstruction.shapes.stems import with_parts
from physagent_studio.reconstruction.shapes.threads import hung, threads_of
from physagent_studio.reconstruction.supports import stances as layout
from physagent_studio.reconstruction.supports.seen_ends import Shown
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.supports.tabletops import Top
from physagent_studio.reconstruction.survey import landmarks, named_tops
from physagent_studio.reconstruction.survey.marked import candidates_of, regions_of
from physagent_studio.reconstruction.survey.named_tops import with_tops
from physagent_studio.reconstruction.survey.sighting import Look
from physagent_studio.reconstruction.survey.survey import Survey, survey
from physagent_studio.reconstruction.texture.skins import skinned
from physagent_studio.reconstruction.without_photo import scene_without_photo
from physagent_studio.records.case import Case, Image
from physagent_studio.records.scene import Candidate, Mesh, Scene


@dataclass(frozen=True, slots=True)
class SameSettings:
    """When a stated camera is the one that was found."""

    row_px: float = 0.5  # 0.1..2: states are written in rounded rows
    roll_rad: float = 1e-3  # 1e-4..0.01: and in rounded degrees


SAME = SameSettings()

UNASKED = "by its words, nobody clicked it"


class _Run:
    """Progress, cancellation and learned models of one reconstruction."""

    def __init__(
        self,
        cancelled: Callable[[], bool] | None,
        progress: Callable[[str, float], None] | None,
        learned: Learned,
    ) -> None:
        self.cancelled = cancelled
        self.progress = progress
        self.learned = learned

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
    learned: Learned = NOTHING,
) -> Scene:
    """The scene that a picture shows, every open field of `state` filled.

    previous: an earlier scene of the same picture; what did not change is taken from it.
    bodies: meshes of objects of kind `mesh` that came from elsewhere; they are set down on what
    they stand on. assets: stored meshes by what `Meshed.asset` names, for objects that a person
    has set down beside what the photo shows. learned: models whose masks join the embedded ones,
    and that fill the background where no plane is known. cancelled: asked between steps.
    progress: called with the step's name and 0 … 1.
    Without a photo nothing may be open, and the scene is drawn from its shapes.
    Raises InputError where an object was neither clicked nor boxed,
    Cancelled when `cancelled` says so.
    """
    key = scene_hash(case, state, learned.key)
    if previous is not None and previous.hash == key:
        return previous
    if previous is not None and same_sight(previous.state, state):
        return replace(previous, state=state, hash=key)
    if case.image is None:
        return scene_without_photo(state, key, assets or {})
    run = _Run(cancelled, progress, learned)
    asked, state = state, _turned(state)
    scene = _look(case, case.image, state, previous, segmenter, bodies, assets or {}, run)
    run.at("done", 1.0)
    # What a model that failed was to do was done without it, and is known by that.
    return replace(scene, hash=scene_hash(case, asked, learned.key))


def _roll_of(state: SceneState, camera: Camera) -> float:
    """Degrees by which the camera is turned, in the state's own figure where that says the same."""
    same = abs(camera.roll - math.radians(state.roll)) < SAME.roll_rad
    return state.roll if same else round(math.degrees(camera.roll), 3)


def _turned(state: SceneState) -> SceneState:
    """The state with its camera turned to a horizon that was edited since the camera was found."""
    camera, row, roll = state.camera, state.horizon, math.radians(state.roll)
    if camera is None or row is None:
        return state
    if abs(camera.horizon - row) < SAME.row_px and abs(camera.roll - roll) < SAME.roll_rad:
        return state
    turned = Camera.from_horizon(
        camera.size,
        row,
        camera.position[2],
        focal=camera.focal,
        roll=roll,
        source="given",
        confirmed=state.horizon_source == "person",
        horizon_sigma=1.0,
    )
    return state.model_copy(update={"camera": turned})


@dataclass(frozen=True, eq=False, slots=True)
class _Sight:
    """What the picture shows before anything is placed. basins: masks of supports that are open
    vessels. tops: supports whose edges were found. told: what the sentence says of it."""

    candidates: Mapping[str, tuple[Candidate, ...]]
    masks: dict[str, BoolArray]
    basins: dict[str, BoolArray]
    regions: Mapping[str, BoolArray]
    found: Segments
    stances: Mapping[str, Stance]
    read: Survey
    tops: Mapping[str, Top]
    told: SceneHints


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
    sight = _seen(case, image, state, previous, segmenter, run)
    done, placed = _put(state, image, sight, previous, bodies or {}, run)
    masks, camera = sight.masks, sight.read.camera
    run.at("textures", 0.78)
    bodies = _bodies(sight, placed, assets)
    meshes = bodies | skinned(image, masks, done, bodies)
    threads = threads_of(image, masks, done, sight.told.dropping)
    done, meshes = hung(done, meshes, threads)
    gone = masks | {name: masks[name] | thread.area for name, thread in threads.items()}
    run.at("background", 0.82)
    inpaint = Inpainting(run.learned, run.cancelled)
    plate = scene_plate(
        image, gone, sight.found, camera, done.supports, previous,
        [item.name for item in done.objects if in_air(item)], inpaint,
        lambda: run.at("background", 0.85),
    )  # fmt: skip
    run.at("checks", 0.97)
    fixed = _support_meshes(done)
    # Checked is what collides: what is drawn lies in its mask whatever the body is.
    checks = findings.measure(done, masks, bodies, fixed, sight.read.estimate, image)
    checks += tuple(grounds.measure(state, image, masks))
    groundings = [(item.name, item.grounding) for item in state.objects]
    sure = sureness(image, masks, sight.candidates, groundings, previous)
    return Scene(
        state=done,
        photo=image,
        plate=plate,
        masks=MappingProxyType(masks | {n: masks[n] | line.core for n, line in threads.items()}),
        meshes=MappingProxyType(meshes),
        support_meshes=MappingProxyType(fixed),
        candidates=MappingProxyType(dict(sight.candidates)),
        findings=checks,
        hash="",
        shapes=MappingProxyType(ranking(state, masks, placed.offers, previous)),
        sureness=MappingProxyType(doubting(sure, state.objects, checks)),
        learned=uses_of(inpaint, state.objects, sight.candidates, plate, previous),
    )


def _seen(
    case: Case,
    image: Image,
    state: SceneState,
    previous: Scene | None,
    segmenter: Segmenter | None,
    run: _Run,
) -> _Sight:
    """Masks, what stands on what, camera and metres."""
    run.at("masks", 0.0)
    candidates = candidates_of(
        case,
        state,
        previous,
        segmenter or EmbeddedSegmenter(learned=run.learned),
        lambda: run.at("masks", 0.44),
        run.cancelled,
    )
    told = hints(case.prompt, [i.name for i in state.objects], [s.name for s in state.supports])
    hollow = basins.basin_names(state, told)
    things = (*state.objects, *(item for item in state.supports if item.name in hollow))
    groundings = [(item.name, item.grounding) for item in things]
    chosen = choose(candidates, groundings, image.shape[:2], image)
    chosen = sound_masks(image, chosen, state.objects, told)
    masks = {name: mask for name, mask in chosen.items() if name not in hollow}
    regions = regions_of(state, image, candidates, masks)
    run.at("camera", 0.45)
    found = segments(image)
    stances = layout.read(chosen, told)
    covered = np.any(list(masks.values()), axis=0) if masks else np.zeros(image.shape[:2], bool)
    offers = {
        item.name: [offer.mask for offer in candidates.get(item.name, ())]
        for item in state.supports
    }
    look = Look(image, stances, chosen, regions, found, covered, offers, told=told)
    look, tops = with_tops(case, state, look)
    read = survey(case, state, look, hollow)
    pools = {name: mask for name, mask in chosen.items() if name in hollow}
    return _Sight(candidates, masks, pools, look.regions, found, stances, read, tops, told)


def _put(
    state: SceneState,
    image: Image,
    sight: _Sight,
    previous: Scene | None,
    bodies: Mapping[str, Mesh],
    run: _Run,
) -> tuple[SceneState, Placed]:
    """Supports, objects and landmarks in their places: the completed state."""
    read, stances = sight.read, sight.stances
    run.at("supports", 0.5)
    covered = np.any(list(sight.masks.values()), axis=0) if sight.masks else image[..., 0] < 0
    solid, open_supports = supports.resolve(
        state, read, stances, sight.regions, sight.found, sight.tops, Shown(image, covered)
    )
    solid = basins.with_basins(solid, sight.basins, sight.masks, stances, read)
    run.at("objects", 0.55)
    given = {**(previous.meshes if previous is not None else {}), **bodies}
    things = {**sight.masks, **sight.basins}
    known = ranked(state, sight.masks, previous)
    ground = Ground(solid, things, stances, read, given, frozenset(bodies), known, sight.found)
    placed = place_all(state.objects, ground, lambda share: run.at("objects", 0.55 + 0.2 * share))
    solid = _carrying(state, solid, placed)
    marks, open_marks = landmarks.resolve(state.landmarks, read.camera, solid, read.shown)
    still_open = (*open_supports, *open_marks, *named_tops.said(state))
    return _completed(state, read, solid, placed, marks, still_open), placed


def _bodies(sight: _Sight, placed: Placed, assets: Mapping[str, Mesh]) -> dict[str, Mesh]:
    """The bodies with their stems and handles, and those that a person has set down beside them."""
    camera = sight.read.camera
    meshes = {
        item.name: with_parts(
            camera,
            sight.masks[item.name],
            item,
            placed.meshes[item.name],
            sight.read.usual[item.name],
        )
        for item in placed.objects
        if item.name in placed.meshes
    }
    added = [item for item in placed.objects if findings.is_added(item)]
    return meshes | {
        item.name: stated_mesh(item, assets) for item in added if item.name not in meshes
    }


def _carrying(state: SceneState, solid: tuple[Support, ...], placed: Placed) -> tuple[Support, ...]:
    """Slabs that were read off the picture reach under what is seen to stand on them."""
    given = {item.name for item in state.supports if item.shape is not None}
    out = []
    for support in solid:
        shape = support.shape
        if isinstance(shape, Slab) and shape.rail is None and support.name not in given:
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
            "roll": _roll_of(state, read.camera),
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


def _support_meshes(state: SceneState) -> dict[str, Mesh]:
    places = [item.position for item in state.objects if item.position is not None]
    reach = 2.0 * max((float(np.hypot(p[0], p[1])) for p in places), default=1.0)
    return {
        item.name: support_mesh(item.shape, reach)
        for item in state.supports
        if item.shape is not None
    }
