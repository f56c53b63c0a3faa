"""Supports that are seen whole: which are boxes and wedges, and what stands on them."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from physagent_studio.knowledge import kind_of, support_kind
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SceneState
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.photo.regions import BoolArray, border_share, iou
from physagent_studio.reconstruction.shapes.meshes import support_mesh
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.supports.block import Block, Kind
from physagent_studio.reconstruction.supports.block_fit import Fit, fitted
from physagent_studio.reconstruction.supports.clicked import shape_of
from physagent_studio.reconstruction.supports.flights import Flight
from physagent_studio.reconstruction.supports.ramps import Profile, place_ramp
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class BlockSettings:
    """When a region is a box or a wedge that is seen whole."""

    # 0.5..1: of region covered and edges on edges; tops' parts reach .94, .65
    min_strict_shares: tuple[float, float] = (0.95, 0.75)
    # 0.5..1: the same for a ramp that its edges alone explain badly
    min_loose_shares: tuple[float, float] = (0.88, 0.55)
    min_gain: float = 0.3  # IoU, 0.05..0.6: of a wedge over the ramp by its edges
    # 0.5..1: a slope that fits so well needs no other region
    clear_shares: tuple[float, float] = (0.95, 0.85)
    # per log, 0..0.3: what a region gains by being larger: parts fit well too
    log_size_weight: float = 0.06
    min_area_share: float = 0.004  # 0.001..0.05: of the picture: smaller regions show no corners
    # log, 0.5..2: of height over length against the usual one, where its name tells that
    max_odd_height_log: float = 1.1
    max_cut_share: float = 0.03  # 0..0.2: of the outline on the picture's border


BLOCK = BlockSettings()


def blocks_of(
    image: Image,
    state: SceneState,
    camera: Camera,
    offers: Mapping[str, Sequence[BoolArray]],
    covered: BoolArray,
    profiles: Mapping[str, Profile],
    standing: Mapping[str, Sequence[Stance]] = MappingProxyType({}),
) -> dict[str, Block]:
    """The boxes and wedges of the supports with open shapes that are seen whole.

    Where a person has marked the top, this tells that it is no board on legs.

    profiles: outlines of ramps by their edges; a wedge has to show decidedly better. standing: what
    stands on each support: a body that does not carry all of it is only part of the support.
    """
    unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
    found: dict[str, Block] = {}
    for support in state.supports:
        kind = _KINDS.get(support_kind(support.name))
        if support.shape is not None or kind is None:
            continue
        masks = offers.get(support.name, ())
        rival = _shown(unit, profiles.get(support.name), masks, covered)
        loose = kind == "wedge" and rival is not None
        best = best_block(
            unit,
            image,
            masks,
            covered,
            kind,
            BLOCK.min_loose_shares if loose else BLOCK.min_strict_shares,
        )
        if best is not None:
            # What stands at an edge is seen a little beyond it.
            feet = [(one.foot, 0.25 * one.width) for one in standing.get(support.name, ())]
            whole = all(best[0].carries(camera, *one) for one in feet)
            best = best if whole and _is_as_high(support.name, best[0]) else None
        if best is not None and (rival is None or best[1] > rival + BLOCK.min_gain):
            found[support.name] = best[0]
    return found


def on_blocks(
    camera: Camera,
    state: SceneState,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    blocks: Mapping[str, Block],
    flights: Mapping[str, Flight] = MappingProxyType({}),
) -> dict[str, str]:
    """What each thing stands on, where a foot that was taken to be on the ground is seen on the
    top of a block, or on a ramp that a person has marked, and nobody has said otherwise."""
    out = dict(on)
    unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
    blocks = {**_marked_ramps(unit, state), **blocks}
    for name, stance in stances.items():
        item = state.object(name)
        if on[name] not in (FLOOR, *blocks) or (item is not None and item.support is not None):
            continue
        carriers = [b for b, block in blocks.items() if block.carries(camera, stance.foot)]
        carriers += [f for f, flight in flights.items() if flight.carries(camera, stance.foot)]
        # The upper of two steps hides what of the lower one is behind it.
        high = {b: block.size[2] for b, block in blocks.items()}
        out[name] = max(carriers, key=lambda b: high.get(b, 0.0), default=on[name])
    return out


def _marked_ramps(unit: Camera, state: SceneState) -> dict[str, Block]:
    """The slopes of the ramps that a person has marked, in camera heights."""
    found: dict[str, Block] = {}
    for support in state.supports:
        if support_kind(support.name) != "ramp":
            continue
        ramp = shape_of(support, unit, 0.0, 0.0)
        if not isinstance(ramp, Ramp):
            continue
        x = ramp.toe[0] + math.cos(ramp.yaw) * ramp.run / 2
        y = ramp.toe[1] + math.sin(ramp.yaw) * ramp.run / 2
        size = (ramp.run, ramp.width, ramp.rise)
        found[support.name] = Block(x, y, size, ramp.yaw, "wedge")
    return found


def _is_as_high(name: str, block: Block) -> bool:
    """Whether a block is about as high for its length as its name says; a table is no kerb.

    What reaches the floor as one body comes in all heights.
    """
    kind = kind_of(name)
    if kind is None or kind.top is None or kind.size is None or kind.base == "solid":
        return True
    usual, seen = kind.top / kind.size[0], block.size[2] / max(block.size[:2])
    return abs(math.log(seen / usual)) <= BLOCK.max_odd_height_log


_KINDS: dict[str, Kind] = {"slab": "box", "ramp": "wedge"}


def _shown(
    unit: Camera, profile: Profile | None, masks: Sequence[BoolArray], covered: BoolArray
) -> float | None:
    """How well a ramp by its edges covers one of the masks of its support: IoU."""
    ramp = place_ramp(unit, profile) if profile is not None else None
    if ramp is None:
        return None
    mesh = support_mesh(ramp, 10.0)
    drawn = silhouette(unit, mesh.vertices, mesh.faces) & ~covered
    return max((iou(drawn, mask & ~covered) for mask in masks), default=0.0)


def best_block(
    camera: Camera,
    image: Image,
    masks: Sequence[BoolArray],
    covered: BoolArray,
    kind: Kind = "box",
    least: tuple[float, float] = BLOCK.min_strict_shares,
) -> tuple[Block, float] | None:
    """The box or wedge that one of several masks of a support shows best, and how well (IoU).

    None where none does. camera: any height; only directions count. masks: (H, W), the likeliest
    first. covered: (H, W) pixels of things in front of it, which may hide any of it. least:
    overlap, and share of edges on edges of the picture, that are asked for.
    """
    best, cheapest, enough = None, math.inf, 0
    kinds: tuple[Kind, ...] = ("wedge", "slope") if kind == "wedge" else (kind,)
    if kind == "wedge":
        # Part of a slope is a slope: the largest region that is one counts.
        masks = sorted(masks, key=np.count_nonzero, reverse=True)
    for mask, one in itertools.product(masks, kinds):
        region = mask & ~covered
        size = int(np.count_nonzero(region))
        fit = Fit.of(camera, image, region, covered, one)
        values = fitted(fit, least) if size > enough and _is_whole(region) else None
        if values is None:
            continue
        cost = fit.cost(values) - (
            BLOCK.log_size_weight * math.log(size) if kind == "wedge" else 0.0
        )
        if cost < cheapest:
            block, cheapest = fit.block(values), cost
            best = (block, fit.overlap(block))
            if (
                kind == "wedge"
                and best[1] > BLOCK.clear_shares[0]
                and fit.on_edges(block) > BLOCK.clear_shares[1]
            ):
                enough = max(enough, size - 1)
    return best


def _is_whole(region: BoolArray) -> bool:
    return region.mean() > BLOCK.min_area_share and border_share(region) <= BLOCK.max_cut_share
