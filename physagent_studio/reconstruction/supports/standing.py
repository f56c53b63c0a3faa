"""What stands on what: on supports, on one another, in the air, and where that is on the ground."""

from collections.abc import Mapping

import numpy as np

from physagent_studio.knowledge import Usual, support_kind
from physagent_studio.program.scene.aloft import AIR, in_air
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.reconstruction.camera.rays import depth_of, on_plane
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.supports.ramps import Profile
from physagent_studio.reconstruction.supports.stances import Stance


def standing_on(
    state: SceneState,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    profiles: Mapping[str, Profile],
) -> dict[str, str]:
    """What each object stands on, by name: as stated, another object, a support, else the floor."""
    on: dict[str, str] = {}
    for name, stance in stances.items():
        item = state.object(name)
        if item is not None and item.support is not None and not _belied(item, stance):
            on[name] = item.support
        elif stance.on is not None:
            on[name] = stance.on
        else:
            on[name] = _support_below(state, stance, regions, profiles) or FLOOR
    return on


def _belied(item: SceneObject, stance: Stance) -> bool:
    """Whether a thing that falls onto another, by the words, is seen to lie on it already."""
    guessed = in_air(item) and item.source == "estimated"
    return guessed and stance.on is not None and not stance.aloft


def support_under(stance: Stance, profiles: Mapping[str, Profile]) -> str | None:
    """The ramp over which something in the air is seen."""
    spans = {name: p.surface(stance.foot[0]) for name, p in profiles.items()}
    over = [name for name, row in spans.items() if row is not None and row > stance.box[1]]
    return over[0] if over else None


def _support_below(
    state: SceneState,
    stance: Stance,
    regions: Mapping[str, BoolArray],
    profiles: Mapping[str, Profile],
) -> str | None:
    """The support whose region or profile lies right under the foot."""
    best: tuple[float, str] | None = None
    for support in state.supports:
        if support_kind(support.name) == "floor":
            continue
        if support.name in profiles:
            row = profiles[support.name].surface(stance.foot[0])
            near = max(6.0, 0.25 * stance.height)
            on_it = profiles[support.name].carries(*stance.foot)
            on_it |= _is_within(stance, regions.get(support.name))
            share = 1.0 if on_it or (row is not None and abs(row - stance.foot[1]) < near) else 0.0
        else:
            share = _share_near(stance, regions.get(support.name))
        if share > 0.3 and (best is None or share > best[0]):
            best = (share, support.name)
    return best[1] if best else None


def _is_within(stance: Stance, region: BoolArray | None) -> bool:
    """Whether a foot is seen well within what a slope covers: the slope goes on below it and to
    both sides, as it would not where the thing stood before or behind it."""
    if region is None or not region.any():
        return False
    x0, _, x1, _ = stance.box
    bottom, middle, reach = int(stance.foot[1]), int(stance.foot[0]), max(4, (x1 - x0) // 4)
    rows = slice(bottom + 1, bottom + 1 + reach)
    around = region[rows, max(0, middle - 2 * reach) : middle + 2 * reach]
    return bool(around.size) and float(around.mean()) > 0.95


def _share_near(stance: Stance, region: BoolArray | None) -> float:
    """How surely the foot stands on what a support's region shows, 0 … 1.

    Certain where the strip right under the foot belongs to the region; likely where the region
    comes close to the foot, for a thing at an edge has the front of the table under it.
    """
    if region is None or not region.any():
        return 0.0
    x0, _, x1, _ = stance.box
    bottom, middle = int(stance.foot[1]), int(stance.foot[0])
    quarter = max(2, (x1 - x0) // 4)
    rows = slice(bottom + 1, bottom + 2 + max(5, round(0.12 * stance.height)))
    strip = grow(region, 2)[rows, max(0, middle - quarter) : middle + quarter]
    under = float(strip.mean()) if strip.size else 0.0
    ys, xs = np.nonzero(region)
    distance = float(np.hypot(xs - stance.foot[0], ys - stance.foot[1]).min())
    near = 0.6 * max(0.0, 1 - distance / (0.9 * stance.extent))
    return max(under, near)


def root_of(name: str, on: Mapping[str, str]) -> str:
    """The support at the bottom of a stack."""
    seen = {name}
    below = on[name]
    while below in on and below not in seen:
        seen.add(below)
        below = on[below]
    return below


def lifted(
    unit: Camera,
    state: SceneState,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    usual: Mapping[str, Usual],
) -> dict[str, str]:
    """Objects that the picture shows in the air: words say so, or the floor is out of reach."""
    out = dict(on)
    given = {item.name for item in state.objects if item.support is not None}
    for name, stance in stances.items():
        if name in given or on[name] != FLOOR:
            continue
        place = on_plane(unit, [stance.foot], 0.0)[0]
        if (
            stance.aloft
            or not np.isfinite(place).all()
            or (
                stance.over is not None
                and (stance.lands or _too_large(unit, stances, out, usual, name))
            )
        ):
            out[name] = AIR
    return out


def _too_large(
    unit: Camera,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    usual: Mapping[str, Usual],
    name: str,
) -> bool:
    """Whether an object would be less plausible on the floor than above what it is seen over."""
    over = stances[name].over
    if over is None or on.get(over, FLOOR) != FLOOR:
        return True
    far = depth_of(unit, on_plane(unit, [stances[name].foot], 0.0)[0])
    near = depth_of(unit, on_plane(unit, [stances[over].foot], 0.0)[0])
    reference = np.log(usual[over].metres / (stances[over].extent * near))
    spread = float(np.hypot(usual[name].spread, usual[over].spread))
    off = [
        abs(np.log(usual[name].metres / (stances[name].extent * depth)) - reference) / spread
        for depth in (far, near)
    ]
    return bool(off[0] > 4.0 and off[1] < 0.5 * off[0])


def ground_pixel(
    name: str,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    under: Mapping[str, str | None],
    profiles: Mapping[str, Profile],
) -> tuple[float, float] | None:
    """The pixel on the level plane at the object's depth: its own foot, or that of its stack."""
    for _ in range(len(stances) + 1):
        below = on[name]
        if below in stances:
            name = below
        elif below == AIR:
            over = under.get(name)
            if over is not None and over in profiles:
                return profiles[over].toe
            if over is None or over not in stances:
                return None
            name = over
        elif below in profiles:
            return profiles[below].toe
        else:
            return stances[name].foot
    return None
