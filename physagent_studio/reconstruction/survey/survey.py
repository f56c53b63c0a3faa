"""The picture read as a whole: what stands where, the camera, and metres.

Everything here happens before any object has a shape: masks, straight edges and names decide
which level planes there are and how high the camera is above them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from physagent_studio.knowledge import Usual, support_kind
from physagent_studio.language import SceneHints
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Scale, SceneState, Support
from physagent_studio.reconstruction.camera.estimate import Horizon
from physagent_studio.reconstruction.camera.scale import Heights, is_stated
from physagent_studio.reconstruction.grounding.toys import as_toys
from physagent_studio.reconstruction.supports.block import Block
from physagent_studio.reconstruction.supports.blocks import blocks_of, on_blocks
from physagent_studio.reconstruction.supports.flights import Flight, flights_of
from physagent_studio.reconstruction.supports.ramps import Profile
from physagent_studio.reconstruction.supports.shelves import boards_of, on_boards, shelf_rises
from physagent_studio.reconstruction.supports.standing import (
    lifted,
    root_of,
    standing_on,
    support_under,
)
from physagent_studio.reconstruction.survey.landmarks import Shown
from physagent_studio.reconstruction.survey.levels import heights_of, measured_of
from physagent_studio.reconstruction.survey.sighting import (
    Look,
    Sighting,
    profiles_of,
    shown_in,
    unit_camera,
)
from physagent_studio.records.case import Case


@dataclass(frozen=True, eq=False, slots=True)
class Survey:
    """What the picture says before shapes.

    on: what each object stands on: a support, an object, "floor" or "air". under: for objects
    in the air, the object or ramp that they hang above. root: the level plane of each stack.
    estimate: the horizon that the picture gives by itself, where one was stated unconfirmed.
    blocks: supports that are seen whole, in camera heights. vessels: objects open at the top.
    flights: stairs that are seen whole, likewise. basins: supports that are open vessels; `on`,
    `root` and `usual` tell of them too.
    """

    camera: Camera
    scale: Scale
    tops: Mapping[str, float]
    on: Mapping[str, str]
    under: Mapping[str, str | None]
    root: Mapping[str, str]
    usual: Mapping[str, Usual]
    profiles: Mapping[str, Profile] = field(default_factory=dict)
    shown: Shown = field(default_factory=Shown)
    estimate: Horizon | None = None
    blocks: Mapping[str, Block] = field(default_factory=dict)
    flights: Mapping[str, Flight] = field(default_factory=dict)
    vessels: frozenset[str] = frozenset()
    basins: frozenset[str] = frozenset()


def survey(
    case: Case, state: SceneState, look: Look, basins: frozenset[str] = frozenset()
) -> Survey:
    """Read the picture.

    basins: supports that are open vessels, which have stances and masks as objects have.
    """
    state = _without(state, basins)
    first = first_sight(state, look)
    unit = unit_camera(case, state, look.size, first.horizon(case, state))
    seen = _upon(state, look, unit, first)
    heights = _heights(state, look, unit, first, seen)
    camera = state.camera or unit.model_copy(update={"position": (0.0, 0.0, heights.camera)})
    estimate = None
    if camera.source == "given" and not camera.confirmed:
        bare = state.model_copy(update={"camera": None, "horizon": None})
        estimate = replace(first, on=seen.on).horizon(case, bare)
    return Survey(
        camera=camera,
        scale=_scale(heights.scale, first.usual),
        tops=heights.tops,
        on=seen.on,
        under=seen.under,
        root=seen.root,
        usual=first.usual,
        profiles=first.profiles,
        shown=first.shown,
        estimate=estimate,
        blocks=seen.blocks,
        flights=seen.flights,
        vessels=look.told.hollow.intersection(look.stances) - basins,
        basins=basins,
    )


def first_sight(state: SceneState, look: Look) -> Sighting:
    """What stands on what by the masks alone, sizes, outlines of ramps, painted marks."""
    usual = {name: _usual(name, look.told, state.scale) for name in look.stances}
    usual = as_toys(usual, {name: stance.extent for name, stance in look.stances.items()})
    profiles = profiles_of(state, look.found, look.size)
    slopes = {name: look.offers[name][0] for name in profiles if look.offers.get(name)}
    on = standing_on(state, look.stances, {**slopes, **look.regions}, profiles)
    on = on_boards(boards_of(state, look.size[1]), state, look.stances, on)
    shown = shown_in(look, state)
    return Sighting(look, on, _roots(on), usual, profiles, shown)


@dataclass(frozen=True, eq=False, slots=True)
class _Upon:
    """What stands on what, seen with the camera tilted as it is; see `Survey`.

    steps: single steps among the blocks, by their order.
    """

    on: Mapping[str, str]
    under: Mapping[str, str | None]
    root: Mapping[str, str]
    blocks: Mapping[str, Block]
    flights: Mapping[str, Flight]
    steps: Mapping[str, int]


def _upon(state: SceneState, look: Look, unit: Camera, first: Sighting) -> _Upon:
    """What stands on boxes, wedges and stairs that are seen whole, and what is in the air."""
    stances = look.stances
    steps, flights = flights_of(look.image, state, unit, look.offers, look.covered, look.told.steps)
    boards = boards_of(state, look.size[1])
    loose = _without(state, frozenset((*steps, *flights, *boards)))
    standing = {
        support.name: [stance for name, stance in stances.items() if first.on[name] == support.name]
        for support in loose.supports
    }
    blocks = {
        **blocks_of(look.image, loose, unit, look.offers, look.covered, first.profiles, standing),
        **steps,
    }
    on = on_blocks(unit, state, stances, first.on, blocks, flights)
    on = lifted(unit, state, stances, on, first.usual)
    under = {
        name: stances[name].over or support_under(stances[name], first.profiles)
        if on[name] == AIR
        else None
        for name in stances
    }
    order = {name: index + 1 for index, name in enumerate(steps)}
    return _Upon(on, under, _roots(on), blocks, flights, order)


def _heights(state: SceneState, look: Look, unit: Camera, first: Sighting, seen: _Upon) -> Heights:
    """Metres: how high the camera and all level planes are."""
    usual, profiles = first.usual, first.profiles
    slabs = {s.name for s in state.supports if support_kind(s.name) == "slab"}
    tops = {name: region for name, region in look.regions.items() if name in slabs}
    measured = measured_of(
        unit, look.stances, seen.on, seen.under, seen.root, usual, profiles, tops
    )
    boards = boards_of(state, look.size[1])
    shelved = shelf_rises(boards, unit, look.stances, seen.on, usual)
    return heights_of(state, unit, measured, seen.blocks, seen.steps, shelved)


def _scale(scale: Scale, usual: Mapping[str, Usual]) -> Scale:
    """The size that everything goes by; that of a lone thing in the air says how far it is."""
    if scale.reference is not None or not usual:
        return scale
    name = min(usual, key=lambda n: usual[n].spread)
    return Scale(reference=name, metres=usual[name].metres, source="assumed")


def _roots(on: Mapping[str, str]) -> dict[str, str]:
    return {name: root_of(name, on) for name in on}


def _without(state: SceneState, names: frozenset[str]) -> SceneState:
    """The state without some supports."""
    if not names:
        return state
    kept = tuple(item for item in state.supports if item.name not in names)
    return state.model_copy(update={"supports": kept})


def _usual(name: str, told: SceneHints, given: Scale) -> Usual:
    """What is usual for an object, or the size that was stated for it."""
    usual = told.usual(name)
    if given.reference == name and given.metres is not None and is_stated(given):
        return replace(usual, metres=given.metres, spread=0.01, known=True)
    return usual


def is_ground(support: Support) -> bool:
    """Whether a support is the ground itself."""
    if support.shape is not None:
        return support.shape.kind == "floor"
    return support_kind(support.name) == "floor"
