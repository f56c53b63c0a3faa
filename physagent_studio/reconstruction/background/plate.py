"""The background plate: the photo with the objects filled in from their surroundings.

Large pieces of the photo, shifted in the picture or on the level plane that it shows, are laid over
the hole such that their seams are not seen, and put together by their steps at full size. Lines
that run behind the objects go on because what they are made of is copied along them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Support
from physagent_studio.reconstruction.background.bystanders import about_them, bystanders
from physagent_studio.reconstruction.background.cast_shadows import shaded
from physagent_studio.reconstruction.background.detached_shadows import detached
from physagent_studio.reconstruction.background.dimmed_ground import Shade, dimmed
from physagent_studio.reconstruction.background.edges_through import (
    drawn,
    restored,
    running_in,
    seen_beside,
)
from physagent_studio.reconstruction.background.floor_reflections import mirrored
from physagent_studio.reconstruction.background.leftovers import leftovers, scraps
from physagent_studio.reconstruction.background.lines_behind import (
    each_once,
    edges_of,
    lines_through,
)
from physagent_studio.reconstruction.background.mosaic import mosaic
from physagent_studio.reconstruction.background.shift_map import shift, to_level
from physagent_studio.reconstruction.background.soft_outlines import soft_width
from physagent_studio.reconstruction.background.structure import Structure
from physagent_studio.reconstruction.background.surfaces import SURFACE, surfaces
from physagent_studio.reconstruction.photo.line_segments import Segments, with_grain, with_hues
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image

NO_LINES: FloatArray = np.zeros((0, 2, 2))
Inpaint = Callable[[Image, BoolArray], Image]
"""Fills a hole (H, W) of a picture (H, W, 3) from what is around it."""


def background(
    photo: Image,
    masks: Sequence[BoolArray],
    camera: Camera | None = None,
    found: Segments | None = None,
    solid: Sequence[Support] = (),
    rooted: Sequence[BoolArray] = (),
    aloft: Sequence[BoolArray] = (),
    inpaint: Inpaint | None = None,
    between: Callable[[], None] = lambda: None,
) -> Image:
    """The photo (H, W, 3) without the masked things and the shade close around their feet.

    camera: with it, what lies on the floor or a table is filled in as seen from above. found: the
    photo's edges, to continue them. solid: supports whose edges go on, with a camera. rooted: those
    of the masks whose things stay where they are, with their shade and what is at their foot.
    aloft: those of the masks whose things are in the air: their shadows lie apart from them.
    inpaint: fills what lies on no known plane; without a camera none is known. between: called
    between steps that take a while, to be cancelled by raising.
    """
    faces, lines = None, NO_LINES
    if camera is not None and at_work("faces"):
        faces = surfaces(photo, hole_of(masks, photo.shape[:2]), camera, solid)
    found = None if found is None else with_grain(photo, with_hues(photo, found))
    edges = np.zeros(photo.shape[:2], bool)
    if camera is not None and faces is not None and at_work("dimmed ground"):
        light = _shade_of(photo, _loose(masks, [*rooted, *aloft]), camera, faces)
        photo, edges = light.lifted(photo), light.edges
    hole, shade = taken_out(photo, masks, faces, rooted, aloft)
    hole, shade = hole | edges, shade | edges
    between()
    if camera is not None and at_work("edges of supports"):
        lines = np.concatenate([lines, edges_of(photo, hole, camera, solid)])
    if found is not None and not hole.all():
        # In shade edges are still seen, so that what runs behind the things themselves ends there.
        things = hole_of(masks, hole.shape)
        for part in (hole, things) if at_work("lines of masks") else (hole,):
            lines = np.concatenate([lines, lines_through(photo, part, found, hole)])
        lines = each_once(lines)
    plate = fill(photo, hole, lines, camera, faces, between)
    if found is not None and at_work("edges seen"):
        things = np.any([*masks, np.zeros_like(hole)], axis=0)
        kept = seen_beside(photo, things, hole, found) & ~shade
        plate, hole = restored(photo, plate, kept), hole & ~kept
    if found is not None and at_work("strokes"):
        lines = each_once(np.concatenate([lines, running_in(hole, found)]))
        plate = drawn(photo, plate, hole, lines)
    if inpaint is not None:
        # Where no known plane is behind the hole.
        plate = inpaint(plate, hole if faces is None else hole & (faces == SURFACE.beyond_number))
    return plate


def _loose(masks: Sequence[BoolArray], rooted: Sequence[BoolArray]) -> list[BoolArray]:
    return [mask for mask in masks if not any(mask is other for other in rooted)]


def _shade_of(
    photo: Image, masks: Sequence[BoolArray], camera: Camera, faces: NDArray[np.int64]
) -> Shade:
    """The shade of things whose light is known, without what else stands in it."""
    hole = hole_of(masks, photo.shape[:2])
    light = dimmed(photo, masks, hole, to_level(camera), faces)
    if not at_work("bystanders") or not light.places.any():
        return light
    own = np.any([*masks, np.zeros_like(hole)], axis=0)
    return light.outside(bystanders(photo, own, hole | light.places))


def taken_out(
    photo: Image,
    masks: Sequence[BoolArray],
    faces: NDArray[np.int64] | None = None,
    rooted: Sequence[BoolArray] = (),
    aloft: Sequence[BoolArray] = (),
) -> tuple[BoolArray, BoolArray]:
    """(H, W) the masked things, what the masks have missed of them, their shade and mirror images.

    Also the shade by itself. faces: (H, W) as `surfaces` gives them. rooted, aloft: see
    `background`.
    """
    if not at_work("rooted"):
        rooted = ()
    loose = _loose(masks, rooted)
    hole = hole_of(loose, photo.shape[:2])
    if at_work("soft outlines"):
        for mask in loose:
            hole |= grow(mask, soft_width(photo, mask, _rim(hole.shape)))
    feet = _feet(rooted, hole.shape)
    # 1..8: of the outline's width, of what grows: single leaves and twigs are there
    spray_factor = 4
    for mask in rooted:
        beside = grow(mask, _rim(hole.shape)) | (
            grow(mask, spray_factor * _rim(hole.shape)) & ~feet
        )
        # Right below, the foot goes on into the ground, and stays there.
        beside[bounds(mask)[3] if mask.any() else 0 :] = False
        hole |= beside
    shade = np.zeros_like(hole)
    if not hole.any() or hole.all():
        return hole, shade
    if at_work("leftovers"):
        beside = leftovers(photo, loose, hole) | (leftovers(photo, rooted, hole) & ~feet)
        hole |= grow(beside, _rim(hole.shape))
    if at_work("floor reflections"):
        hole |= mirrored(photo, loose)
    if at_work("cast shadows"):
        shade = shaded(photo, loose, hole, faces)
        slit_px = 5  # 0..12: widest slit between a thing and its shade
        # The darkest shade is a line right at the foot: none of it shall be left between the two.
        if at_work("slits"):
            shade |= grow(shade, slit_px) & grow(hole, slit_px)
    if faces is not None and at_work("detached shadows"):
        shade |= detached(photo, aloft, hole | shade, faces)
    if at_work("scraps"):
        hole |= grow(scraps(photo, loose, hole | shade), 2)
    if at_work("bystanders"):
        things = hole_of(loose, photo.shape[:2])
        own = np.any([*loose, np.zeros_like(hole)], axis=0)
        others = bystanders(photo, own, hole | shade) & ~things
        theirs = others
        if at_work("shade of bystanders"):
            theirs = about_them(others, grow(things, _rim(hole.shape)), hole | shade)
        hole, shade = hole & ~theirs, shade & ~theirs
    return hole | shade, shade


def _feet(rooted: Sequence[BoolArray], shape: tuple[int, ...]) -> BoolArray:
    """(H, W) where what grows goes into the ground, with what grows beside it."""
    out = np.zeros(shape, bool)
    foot_share = 0.12  # 0.03..0.4: of what grows, from below, that keeps what is beside it
    for mask in rooted:
        if mask.any():
            _, y0, _, y1 = bounds(mask)
            out[y1 - round(foot_share * (y1 - y0)) :] = True
    return out


def fill(
    photo: Image,
    hole: BoolArray,
    lines: FloatArray = NO_LINES,
    camera: Camera | None = None,
    faces: NDArray[np.int64] | None = None,
    between: Callable[[], None] = lambda: None,
) -> Image:
    """The photo (H, W, 3) with the hole (H, W) filled; the rest is untouched.

    Every piece of the hole is filled by itself, nothing is copied from any of them. lines:
    (N, 2, 2) pixels, edges that go on behind the hole. camera, between: as for `background`.
    faces: (H, W) as `surfaces` gives them: what a face shows comes from that face.
    """
    if hole.all():
        return np.full_like(photo, 128)
    out = photo.copy()
    pieces = _apart(hole)
    roots = [float(np.count_nonzero(piece)) ** 0.5 for piece in pieces]
    for missing, root in zip(pieces, roots, strict=True):
        between()
        crop = _surroundings(missing)
        own = lines[_touching(missing, lines)] if len(lines) else lines
        origin = np.array([crop[1].start, crop[0].start])
        level = (
            to_level(camera) @ shift(*origin)
            if camera is not None and at_work("level shifts")
            else None
        )
        part = photo[crop].astype(np.float32)
        full = mosaic(
            part,
            missing[crop],
            hole[crop],
            Structure(own).moved(*origin.tolist()),
            level,
            max(0.4, root / sum(roots)),
            None if faces is None else faces[crop],
        )
        filled = np.clip(np.round(full), 0, 255).astype(np.uint8)
        out[crop][missing[crop]] = filled[missing[crop]]
    return out


def _apart(hole: BoolArray) -> list[BoolArray]:
    """The hole's pieces; those that nearly touch are one."""
    # 0.001..0.03: over the longer side, between two holes that are filled as one
    nearby_ratio = 0.006
    close = grow(hole, max(2, round(nearby_ratio * max(hole.shape))))
    count, labels = cv2.connectedComponents(close.astype(np.uint8))
    return [hole & (labels == k) for k in range(1, count)]


def _touching(hole: BoolArray, lines: FloatArray) -> BoolArray:
    """(N,) which lines (N, 2, 2) run through the hole."""
    share = np.linspace(0, 1, 60)[:, None, None]
    along = (lines[:, 0] + share * (lines[:, 1] - lines[:, 0])).astype(int)
    x = along[..., 0].clip(0, hole.shape[1] - 1)
    y = along[..., 1].clip(0, hole.shape[0] - 1)
    return np.asarray(hole[y, x].any(axis=0), bool)


def hole_of(masks: Sequence[BoolArray], shape: tuple[int, int]) -> BoolArray:
    """All objects together, widened over their soft outline and what they keep dark below."""
    union = np.zeros(shape, bool)
    for mask in masks:
        union |= mask
        if mask.any():
            union |= _contact(mask) if at_work("contact shade") else False
    return _without_gaps(grow(union, _rim(shape)), _rim(shape))


def _without_gaps(hole: BoolArray, rim: int) -> BoolArray:
    """The hole (H, W) with what it encloses where that is narrow: panes, and slits in masks."""
    if not at_work("narrow gaps"):
        return hole
    count, labels = cv2.connectedComponents((~hole).astype(np.uint8), connectivity=4)
    edge = np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()])
    within = ~np.isin(np.arange(count), edge)
    wide = np.unique(labels[shrink(~hole, rim)])
    within[[0, *wide]] = False
    return hole | np.isin(labels, np.flatnonzero(within))


def _rim(shape: tuple[int, ...]) -> int:
    """Width of a thing's soft outline, pixels."""
    return max(3, round(0.008 * max(shape)))


def _contact(mask: BoolArray) -> BoolArray:
    """The dark line below a thing that stands: the light does not get in there."""
    x0, y0, x1, y1 = bounds(mask)
    low = mask.copy()
    low[: y1 - max(1, round(0.15 * (y1 - y0)))] = False
    return grow(low, max(1, round(0.03 * min(x1 - x0, y1 - y0))))


def _surroundings(hole: BoolArray) -> tuple[slice, slice]:
    """The part of the picture that the fill may copy from."""
    x0, y0, x1, y1 = bounds(hole)
    margin = max(60, round(0.9 * max(x1 - x0, y1 - y0)))
    rows = slice(max(0, y0 - margin), min(hole.shape[0], y1 + margin))
    return rows, slice(max(0, x0 - margin), min(hole.shape[1], x1 + margin))
