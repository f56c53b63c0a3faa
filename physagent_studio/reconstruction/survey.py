"""The picture read as a whole: what stands where, the camera, and metres.

Everything here happens before any object has a shape: masks, straight edges and names decide
which level planes there are and how high the camera is above them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from physagent_studio.program.base import Source
from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Scale, SceneState, Support
from physagent_studio.reconstruction import camera as camera_cues
from physagent_studio.reconstruction import clicked_supports
from physagent_studio.reconstruction.aloft import before_no_ground
from physagent_studio.reconstruction.block import Block
from physagent_studio.reconstruction.blocks import blocks_of, on_blocks
from physagent_studio.reconstruction.ellipses import level_circles
from physagent_studio.reconstruction.flight import Flight, flights_of
from physagent_studio.reconstruction.frames import find_frame
from physagent_studio.reconstruction.landmarks import LINES, OPENINGS, TARGETS, Shown
from physagent_studio.reconstruction.layout import Stance
from physagent_studio.reconstruction.levels import heights_of, measured_of
from physagent_studio.reconstruction.lines import Segments
from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.reconstruction.names import (
    Usual,
    support_kind,
    usual_size,
    words_of,
)
from physagent_studio.reconstruction.painted import painted_lines
from physagent_studio.reconstruction.ramps import Profile, find_profile
from physagent_studio.reconstruction.scale import FLOOR, is_stated
from physagent_studio.reconstruction.shelves import boards_of, on_boards, shelf_rises
from physagent_studio.reconstruction.standing import (
    lifted,
    root_of,
    standing_on,
    support_under,
)
from physagent_studio.reconstruction.toys import as_toys
from physagent_studio.reconstruction.vessels import is_vessel
from physagent_studio.records.case import Case, Image

GOAL, GOAL_HEIGHT, GOAL_SPREAD = "goal", 2.3, 0.15
"""Goals are 2.44 m high, smaller ones 2 m."""


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
    estimate: camera_cues.Horizon | None = None
    blocks: Mapping[str, Block] = field(default_factory=dict)
    flights: Mapping[str, Flight] = field(default_factory=dict)
    vessels: frozenset[str] = frozenset()
    basins: frozenset[str] = frozenset()


def survey(
    case: Case,
    image: Image,
    state: SceneState,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    found: Segments,
    covered: BoolArray,
    offers: Mapping[str, Sequence[BoolArray]],
    basins: frozenset[str] = frozenset(),
) -> Survey:
    """Read the picture.

    regions: masks of the supports that were clicked. covered: pixels of all objects.
    offers: all masks of each such support, the likeliest first. basins: supports that are open
    vessels, which have stances as objects have.
    """
    state = _without(state, basins)
    usual = {name: _usual(name, case.prompt, state.scale) for name in stances}
    usual = as_toys(usual, {name: stance.extent for name, stance in stances.items()})
    profiles = _profiles(state, found, (image.shape[1], image.shape[0]))
    boards = boards_of(state, image.shape[0])
    on = on_boards(boards, state, stances, standing_on(state, stances, regions, profiles))
    groundless = before_no_ground(image, stances, covered)
    root = {name: root_of(name, on) for name in stances}
    shown = _shown(image, state, case.prompt, covered)
    seen = {n: "air" if n in groundless and below == FLOOR else below for n, below in on.items()}
    horizon = _horizon(image, state, stances, seen, root, usual, found, shown, case.focal)
    unit = _unit_camera(case, state, (image.shape[1], image.shape[0]), horizon)
    steps, flights = flights_of(image, state, unit, offers, covered, case.prompt)
    loose = _without(state, frozenset((*steps, *flights, *boards)))
    standing = {
        support.name: [stance for name, stance in stances.items() if on[name] == support.name]
        for support in loose.supports
    }
    blocks = {**blocks_of(image, loose, unit, offers, covered, profiles, standing), **steps}
    on = on_blocks(unit, state, stances, on, blocks, flights)
    root = {name: root_of(name, on) for name in stances}
    on = lifted(unit, state, stances, on, root, usual, groundless)
    root = {name: root_of(name, on) for name in stances}
    under = {
        name: stances[name].over or support_under(stances[name], profiles)
        if on[name] == "air"
        else None
        for name in stances
    }
    measured = measured_of(unit, stances, on, under, root, usual, profiles)
    order = {name: index + 1 for index, name in enumerate(steps)}
    shelved = shelf_rises(boards, unit, stances, on, usual)
    heights = heights_of(state, unit, measured, blocks, order, shelved)
    camera = state.camera or unit.model_copy(update={"position": (0.0, 0.0, heights.camera)})
    scale = heights.scale
    if scale.reference is None and usual:
        # A lone thing in the air: its usual size says how far away it is.
        name = min(usual, key=lambda n: usual[n].spread)
        scale = Scale(reference=name, metres=usual[name].metres, source="assumed")
    estimate = None
    if camera.source == "given" and not camera.confirmed:
        bare = state.model_copy(update={"camera": None, "horizon": None})
        estimate = _horizon(image, bare, stances, on, root, usual, found, shown, case.focal)
    vessels = frozenset(name for name in stances if is_vessel(name, case.prompt))
    return Survey(
        camera=camera,
        scale=scale,
        tops=heights.tops,
        on=on,
        under=under,
        root=root,
        usual=usual,
        profiles=profiles,
        shown=shown,
        estimate=estimate,
        blocks=blocks,
        flights=flights,
        vessels=vessels - basins,
        basins=basins,
    )


def _without(state: SceneState, names: frozenset[str]) -> SceneState:
    """The state without some supports."""
    if not names:
        return state
    kept = tuple(item for item in state.supports if item.name not in names)
    return state.model_copy(update={"supports": kept})


def _unit_camera(
    case: Case, state: SceneState, size: tuple[int, int], horizon: camera_cues.Horizon
) -> Camera:
    """The camera, one unit above the ground where its height is not known yet."""
    if state.camera is not None:
        return state.camera
    return Camera.from_horizon(
        size,
        horizon.row,
        1.0,
        focal=case.focal or clicked_supports.focal_of(state, size, horizon.row) or horizon.focal,
        source=_horizon_source(state),
        # A horizon that a person gave is known; one that was tried for a repair is not.
        confirmed=state.horizon is not None
        and (state.horizon == case.horizon or state.horizon_source == "person"),
        horizon_sigma=horizon.sigma,
    )


def _horizon_source(state: SceneState) -> Source:
    if state.horizon is None:
        return "estimated"
    return "person" if state.horizon_source == "person" else "given"


def _usual(name: str, prompt: str, given: Scale) -> Usual:
    """What is usual for an object, or the size that was stated for it."""
    usual = usual_size(name, prompt)
    if given.reference == name and given.metres is not None and is_stated(given):
        return replace(usual, metres=given.metres, spread=0.01, known=True)
    return usual


def _profiles(state: SceneState, found: Segments, size: tuple[int, int]) -> dict[str, Profile]:
    out: dict[str, Profile] = {}
    for support in state.supports:
        if support.shape is None and support_kind(support.name) == "ramp":
            clicks = [(c.x, c.y) for c in support.grounding.points if c.label]
            profile = clicked_supports.profile_of(support) or find_profile(found, clicks, size)
            if profile is not None:
                out[support.name] = profile
    return out


def _horizon(
    image: Image,
    state: SceneState,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    root: Mapping[str, str],
    usual: Mapping[str, Usual],
    found: Segments,
    shown: Shown,
    stated: float | None,
) -> camera_cues.Horizon:
    """The horizon as a person gave it or as the picture shows it. stated: focal length, pixels."""
    size = (image.shape[1], image.shape[0])
    focal = stated or camera_cues.usual_focal(size)
    if state.camera is not None:
        return camera_cues.Horizon(state.camera.horizon, 1.0, state.camera.focal)
    if state.horizon is not None:
        return camera_cues.Horizon(state.horizon, 1.0, focal)
    kinds = {s.name: support_kind(s.name) for s in state.supports}
    profiles = _profiles(state, found, size)
    standing = []
    for name, stance in stances.items():
        ramp = kinds.get(on[name]) == "ramp"
        if on[name] in stances or _in_air(stance, on[name]) or (ramp and on[name] not in profiles):
            continue
        row = profiles[on[name]].toe[1] if ramp else stance.foot[1]
        plane = FLOOR if ramp else root[name]
        size_of = usual[name]
        standing.append(
            camera_cues.Standing(row, stance.extent, size_of.metres, size_of.spread, plane)
        )
    toes = [profile.toe[1] for profile in profiles.values()]
    if shown.frame is not None and GOAL in {
        w for mark in state.landmarks for w in words_of(mark.name)
    }:
        frame = shown.frame
        standing.append(
            camera_cues.Standing(frame.foot, frame.height, GOAL_HEIGHT, GOAL_SPREAD, FLOOR)
        )
    circles = [camera_cues.Disc(e.y, e.flatness) for e in shown.circles]
    circles += [stance.rim for stance in stances.values() if stance.rim is not None]
    return camera_cues.estimate(image, found, standing, toes, circles, stated)


def _shown(image: Image, state: SceneState, prompt: str, covered: BoolArray) -> Shown:
    """Frames and circles, looked for where the sentence or an open landmark names one."""
    words = set(words_of(prompt)) | {w for mark in state.landmarks for w in words_of(mark.name)}
    frame = find_frame(image, covered) if words & OPENINGS else None
    circles = tuple(level_circles(image, covered)) if words & TARGETS else ()
    opened = {w for mark in state.landmarks if not mark.points for w in words_of(mark.name)}
    lines = tuple(painted_lines(image, covered)) if opened & LINES else ()
    return Shown(frame, circles, lines)


def _in_air(stance: Stance, on: str) -> bool:
    """In the air so far as words can tell."""
    return on == "air" or (on == FLOOR and stance.aloft)


def is_ground(support: Support) -> bool:
    """Whether a support is the ground itself."""
    if support.shape is not None:
        return support.shape.kind == "floor"
    return support_kind(support.name) == "floor"
