"""The camera as the picture shows it: its cues gathered from masks, edges, names and words."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.knowledge import Usual, is_splayed, is_table, kind_of, support_kind
from physagent_studio.language import SceneHints, seen_by
from physagent_studio.program.base import Source
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.camera import estimate as camera_cues
from physagent_studio.reconstruction.camera import right_angles
from physagent_studio.reconstruction.camera.outlines import Outline, outline_of
from physagent_studio.reconstruction.camera.roll import Levelled, roll_of
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.photo.ellipses import Ellipse, level_circles, rim_of
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.supports import clicked as clicked_supports
from physagent_studio.reconstruction.supports import seen_ends
from physagent_studio.reconstruction.supports.boxed_tops import round_top
from physagent_studio.reconstruction.supports.ramps import Profile, find_profile
from physagent_studio.reconstruction.supports.stances import TOLD_NOTHING, Stance
from physagent_studio.reconstruction.survey.frames import find_frame
from physagent_studio.reconstruction.survey.landmarks import Shown
from physagent_studio.reconstruction.survey.painted_lines import painted_lines
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Case, Image


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """What is seen before anything is understood.

    stances: of every object and every support that is an open vessel. masks: (H, W), of both.
    regions: masks of the supports that were clicked. found: straight edges. covered: (H, W)
    pixels of all objects. offers: all masks of each clicked support, the likeliest first. told:
    what the sentence says of all this.
    """

    image: Image
    stances: Mapping[str, Stance]
    masks: Mapping[str, BoolArray]
    regions: Mapping[str, BoolArray]
    found: Segments
    covered: BoolArray
    offers: Mapping[str, Sequence[BoolArray]]
    told: SceneHints = TOLD_NOTHING

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, pixels."""
        return self.image.shape[1], self.image.shape[0]


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """What the horizon is read from, beside the look itself.

    on: what each object stands on. root: the support at the bottom of its stack. usual: sizes.
    """

    look: Look
    on: Mapping[str, str]
    root: Mapping[str, str]
    usual: Mapping[str, Usual]
    profiles: Mapping[str, Profile]
    shown: Shown

    def horizon(self, case: Case, state: SceneState) -> camera_cues.Horizon:
        """The horizon as a person gave it or as the picture shows it."""
        focal = case.focal or camera_cues.usual_focal(self.look.size)
        if state.camera is not None:
            camera = state.camera
            return camera_cues.Horizon(camera.horizon, 1.0, camera.focal, camera.roll)
        roll = math.radians(state.roll)
        if state.horizon is not None:
            return camera_cues.Horizon(state.horizon, 1.0, focal, roll)
        level = Levelled(self.look.size, roll or roll_of(self.look.found, self.look.size))
        circles = [
            camera_cues.Disc(level.row((e.x, e.y)), e.flatness) for e in self._circles(state)
        ]
        found = camera_cues.estimate(
            self.look.size,
            self.look.found,
            self._standing(state, level),
            [level.row(profile.toe) for profile in self.profiles.values()],
            circles,
            case.focal,
            [level.edges(edges) for edges in self._right_angles(state)],
            self._outlines(state, focal, level.roll) if at_work("outlines") else (),
        )
        return level.tilted(found)

    def _circles(self, state: SceneState) -> list[Ellipse]:
        """Level circles: those that are painted, round tops, and the rims of plates and lids."""
        if not at_work("rims"):
            return [*self.shown.circles, *self.shown.tops]
        rims: list[Ellipse] = []
        for name, stance in self.look.stances.items():
            usual = self.usual[name]
            loose = self._is_ramp(state, self.root[name]) or self._in_air(stance) or stance.leans
            if usual.flat is None or usual.shapes[:1] != ("cylinder",) or loose:
                continue
            others = self.look.covered & ~self.look.masks[name]
            rim = rim_of(self.look.masks[name], others)
            rims += [] if rim is None else [without_side(rim, usual.flat)]
        return [*self.shown.circles, *self.shown.tops, *rims]

    def _standing(self, state: SceneState, level: Levelled) -> list[camera_cues.Standing]:
        """Things of known size on level planes, a goal among them."""
        out = []
        for name, stance in self.look.stances.items():
            on = self.on[name]
            ramp = self._is_ramp(state, on)
            if (
                on in self.look.stances
                or self._in_air(stance)
                or (ramp and on not in self.profiles)
            ):
                continue
            row = level.row(self.profiles[on].toe if ramp else stance.foot)
            plane = FLOOR if ramp else self.root[name]
            size = self.usual[name]
            lies = _is_looked_down_on(name, size)
            out.append(
                camera_cues.Standing(row, stance.extent, size.metres, size.spread, plane, lies)
            )
        marks = seen_by(" ".join(mark.name for mark in state.landmarks))
        frame = self.shown.frame
        goal_m = 2.3  # 1.8..2.6: high: goals are 2.44, smaller ones 2
        goal_spread_log = 0.15  # 0.05..0.4: of that
        if frame is not None and "measured_frame" in marks:
            out.append(
                camera_cues.Standing(frame.foot, frame.height, goal_m, goal_spread_log, FLOOR)
            )
        return out

    def _outlines(self, state: SceneState, focal: float, roll: float) -> list[Outline]:
        """The outlines of things of known forms that stand upright and are seen whole."""
        out = []
        for name, stance in self.look.stances.items():
            loose = self._is_ramp(state, self.root[name]) or self._in_air(stance) or stance.leans
            if loose or self._is_hidden(stance):
                continue
            found = outline_of(self.look.masks[name], self.usual[name], focal, roll)
            out += [found] if found is not None else []
        return out

    def _is_hidden(self, stance: Stance) -> bool:
        """Whether another thing adjoins that it does not stand on, and may hide a part of it."""
        mask = self.look.masks[stance.name].astype(np.uint8)
        near = cv2.dilate(mask, np.ones((5, 5), np.uint8)).astype(bool)
        others = (name for name in self.look.masks if name not in (stance.name, stance.on))
        return any((near & self.look.masks[name]).any() for name in others)

    def _right_angles(self, state: SceneState) -> list[right_angles.Edges]:
        """The edges of what is upright and right-angled, and of all that is no thing at all."""
        upright, others = [], []
        for name, stance in self.look.stances.items():
            loose = self._is_ramp(state, self.root[name]) or self._in_air(stance) or stance.leans
            regular = not loose and _is_upright(self.usual[name])
            (upright if regular else others).append(self.look.masks[name])
        for support in state.supports:
            if self._is_ramp(state, support.name) or is_splayed(support.name):
                others += self.look.offers.get(support.name, ())
            elif support.name in self.look.regions:
                upright.append(self.look.regions[support.name])
        lines = [(p.toe, p.top, p.end, (p.end[0], p.toe[1])) for p in self.profiles.values()]
        return right_angles.edges_by_thing(
            self.look.found, self.look.size, upright, [*others, *self._drawn(lines)]
        )

    def _drawn(self, outlines: Sequence[Sequence[tuple[float, float]]]) -> list[BoolArray]:
        """Masks (H, W) of outlines in pixels."""
        out = []
        for outline in outlines:
            canvas = np.zeros(self.look.image.shape[:2], np.uint8)
            cv2.fillPoly(canvas, [np.round(np.array(outline)).astype(np.int32)], 1)
            out.append(canvas.astype(bool))
        return out

    def _in_air(self, stance: Stance) -> bool:
        """In the air so far as words and what is seen around the foot can tell."""
        on = self.on[stance.name]
        return on == AIR or (on == FLOOR and stance.aloft)

    def _is_ramp(self, state: SceneState, name: str) -> bool:
        support = state.support(name)
        if support is not None and support.shape is not None:
            return support.shape.kind == "ramp"
        return support is not None and support_kind(name) == "ramp"


def without_side(rim: Ellipse, thin: float) -> Ellipse:
    """The upper rim of a disc whose outline is seen. thin: its height over its width.

    The outline is sin a + thin · cos a as high as wide, where one looks down on it by a.
    """
    high = min(rim.flatness / math.hypot(1.0, thin), 1.0)
    slope = max(math.asin(high) - math.atan(thin), 0.0)
    return replace(rim, height=rim.width * math.sin(slope))


def _is_looked_down_on(name: str, usual: Usual) -> bool:
    """Whether it is a small thing that lies rather than stands, and no animal."""
    max_small_m = 0.7  # 0.3..1.5: what is longer is seen from a distance, as a log is
    kind = kind_of(name)
    alive = kind is not None and kind.is_alive
    return usual.lies is not None and usual.metres < max_small_m and not alive


def _is_upright(usual: Usual) -> bool:
    """Whether a thing's straight edges are upright or level: boxes, cans, what nothing is known of.

    Cups and buckets taper, legs are splayed, and what has no usual form has edges any way.
    """
    straight = "box" in usual.shapes or (
        "cylinder" in usual.shapes and "frustum" not in usual.shapes
    )
    return straight or not usual.known


def unit_camera(
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
        roll=horizon.roll,
        source=_source(state),
        # A horizon that a person gave is known; one that was tried for a repair is not.
        confirmed=state.horizon is not None
        and (state.horizon == case.horizon or state.horizon_source == "person"),
        horizon_sigma=horizon.sigma,
    )


def _source(state: SceneState) -> Source:
    if state.horizon is None:
        return "estimated"
    return "person" if state.horizon_source == "person" else "given"


def profiles_of(state: SceneState, found: Segments, size: tuple[int, int]) -> dict[str, Profile]:
    """The outlines of the ramps whose edges are seen or marked."""
    out: dict[str, Profile] = {}
    for support in state.supports:
        if support.shape is None and support_kind(support.name) == "ramp":
            clicks = support.grounding.inside
            profile = clicked_supports.profile_of(support) or find_profile(found, clicks, size)
            if profile is not None:
                out[support.name] = profile
    return out


def shown_in(look: Look, state: SceneState) -> Shown:
    """Frames and circles, looked for where the sentence or an open landmark names one."""
    marks = [(mark, seen_by(mark.name)) for mark in state.landmarks]
    asked = look.told.seen.union(*(seen for _, seen in marks))
    frame = find_frame(look.image, look.covered) if "frame" in asked else None
    circles = tuple(level_circles(look.image, look.covered)) if "circle" in asked else ()
    lined = any("line" in seen for mark, seen in marks if not mark.points)
    lines = tuple(painted_lines(look.image, look.covered)) if lined else ()
    return Shown(frame, circles, lines, tuple(_round_tops(look, state)))


def _round_tops(look: Look, state: SceneState) -> Iterator[Ellipse]:
    """The tops of tables in boxes that are round."""
    for support in state.supports:
        box = support.grounding.box
        open_table = support.shape is None and is_table(support.name)
        if box is not None and open_table and at_work("round tops"):
            top = round_top(seen_ends.Shown(look.image, look.covered), box)
            if top is not None:
                yield top
