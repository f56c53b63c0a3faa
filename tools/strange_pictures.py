"""Draw ten pictures of things no rule was written for: OUT/<name>/{input.png, case.yaml, masks/}.

Beside each picture and its sentence lies one mask per thing, 255 where it is what a pinhole sees.
Run as `python tools/strange_pictures.py OUT [NAME ...]`. The same seeds give the same bits.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray
from photoreal.develop import develop
from photoreal.fields import Array, Body, Eye, Field, Finish, Lamp, Part, World, identities
from photoreal.fields import radiance as traced
from photoreal.noise import layered, solid, solid_layered
from photoreal.props import (
    Colour,
    Rng,
    Triple,
    ball,
    brick,
    cloth,
    cubic,
    cut,
    egg,
    even,
    eye_at,
    faces,
    flat_wall,
    grainy,
    grit,
    indoors,
    joined,
    melted,
    outdoors,
    picked,
    printed,
    ring,
    rod,
    skirting,
    slab,
    spread,
    stripes,
    sun,
    tiled,
    turned,
    window,
    written,
)
from photoreal.textures import boards, linear, plaster
from photoreal.toys import board, bookcase, locomotive, painted_block


@dataclass(frozen=True)
class Scene:
    """A picture to be taken. supports: names that are clicked as supports, not as objects."""

    bodies: list[Body]
    eye: Eye
    lamps: list[Lamp]
    sky: Field
    event: tuple[str, str]
    supports: tuple[str, ...] = ()
    balance: Colour = (1.0, 1.0, 1.0)
    exposure: float = 0.34


# The ten scenes.


def beach_ball(rng: Rng) -> Scene:
    """Six panels of colour on glossy stoneware, a white wall far behind."""
    panels = [(206, 40, 44), (238, 234, 224), (244, 188, 30), (238, 234, 224), (32, 96, 178),
              (52, 150, 84)]  # fmt: skip
    tints = np.stack([linear(c) for c in panels])

    def paint(p: Array) -> Array:
        angle = np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) * 6
        colour = tints[np.floor(angle).astype(int) % 6]
        seam = np.abs(angle - np.rint(angle)) * np.hypot(p[:, 0], p[:, 1]) < 0.0016
        colour = colour * np.where(seam, 0.7, 1)[:, None]
        colour[np.abs(p[:, 2]) > 0.147] = linear((236, 232, 222))
        return colour * (1 + 0.03 * solid_layered(p * 30, 4))[:, None]

    def creases(p: Array) -> Array:
        angle = np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) * 6
        away = np.abs(angle - np.rint(angle)) * np.hypot(p[:, 0], p[:, 1])
        return (-0.0012 * np.exp(-((away / 0.006) ** 2)) * (np.abs(p[:, 2]) < 0.147)).astype(
            np.float32
        )

    vinyl = Finish(paint, 0.045, 0.2, relief=creases)
    stone = tiled(rng, (165, 165), [(196, 178, 152), (188, 166, 138), (204, 188, 164)],
                  (120, 110, 98))  # fmt: skip
    wall = plaster(rng, (1200, 1600), 0.0025, (214, 206, 188))
    bodies = [
        Body(cubic(0.161), (Part(ball(0.16), vinyl),), (-0.22, 1.45, 0.16), turned(20, 28, 35),
             "beach_ball"),
        slab((5, 4, 0.05), (0.1, 2, -0.05), spread(stone, 0.002, (5, 4, 0.05), tiles=True)),
        flat_wall(3.3, wall, 0.0025), skirting(3.3, (226, 222, 212)),
        bookcase(rng, (0.42, 0.18, 0.42), (1.05, 3.1, 0.42)),
    ]  # fmt: skip
    eye = eye_at((832, 480), 36, 0.60, 17, 1.4, 0.004)
    event = ("rolls", "The beach ball rolls to the right and stops.")
    return Scene(bodies, eye, [window(-2.2, 1.2, 1.5, 7)], indoors(0.6), event)


def tin_can(rng: Rng) -> Scene:
    """A labelled tin near the right edge of a plank table, a carpet far below."""
    width, height = 900, 380
    label = np.empty((height, width, 3), np.float32)
    label[:] = linear((186, 44, 34))
    label[:70], label[-56:] = linear((240, 226, 190)), linear((36, 92, 58))
    for u in range(0, width, 450):
        cv2.ellipse(
            label, (u + 225, 215), (150, 84), 0, 0, 360, linear((244, 232, 204)).tolist(), -1
        )
        cv2.circle(label, (u + 215, 244), 36, linear((214, 66, 38)).tolist(), -1, cv2.LINE_AA)
        cv2.circle(label, (u + 262, 250), 30, linear((196, 48, 32)).tolist(), -1, cv2.LINE_AA)
        cv2.ellipse(label, (u + 226, 208), (22, 7), 20, 0, 360, linear((60, 120, 48)).tolist(), -1)
        ink = written("TOMATOES", (width, height), 1.5, 4, (u + 100, 52))[..., None]
        label = label * (1 - ink) + linear((40, 62, 44)) * ink
    label = label * (1 + 0.03 * layered(rng, (height, width), (60, 60)))[..., None]

    def paper(p: Array) -> Array:
        u = (np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) + 0.52) * width
        return picked(label.astype(np.float32), (0.046 - p[:, 2]) / 0.092 * height, u)

    def ribs(p: Array) -> Array:
        return (0.0006 * np.cos(np.hypot(p[:, 0], p[:, 1]) * 900)).astype(np.float32)

    tin = Finish(even((206, 206, 202)), rough=0.3, metal=True, relief=ribs)
    parts = (
        Part(rod(0.0372, 0.046), Finish(paper, 0.045, 0.32)),
        Part(joined(rod(0.0362, 0.051), cut(rod(0.0365, 0.0535), rod(0.0352, 0.06)),
                    ring(0.0366, 0.0016, 2, (0, 0, 0.053)),
                    ring(0.0366, 0.0016, 2, (0, 0, -0.053))), tin),
    )  # fmt: skip
    half = (0.55, 0.36, 0.016)
    wood = boards(rng, (1.2, 0.9), 0.0007)
    pile = cloth(rng, stripes([90, 14, 60, 14], [(96, 104, 122), (190, 182, 164), (70, 78, 98),
                                                 (190, 182, 164)], 1000), 5, 5e-4)  # fmt: skip
    legs = Finish(even((120, 80, 50)))
    bodies = [
        Body((0.039, 0.039, 0.056), parts, (0.13, 0.74, 0.0552), turned(-62), "can"),
        slab(half, (-0.33, 0.86, -0.016), spread(wood, 0.0007, half), "table"),
        slab((0.025, 0.025, 0.34), (0.17, 0.55, -0.37), legs),
        slab((0.025, 0.025, 0.34), (0.17, 1.15, -0.37), legs),
        slab((5, 5, 0.05), (0, 2, -0.76), spread(pile, 0.003, (5, 5, 0.05))),
        flat_wall(2.7, plaster(rng, (900, 1400), 0.003, (176, 190, 184)), 0.003, -0.71),
        skirting(2.7, (228, 226, 220), 0.1, -0.71),
        bookcase(rng, (0.3, 0.15, 0.62), (1.15, 2.5, -0.09)),
    ]
    eye = eye_at((720, 480), 40, 0.36, 21, 0.74)
    event = ("pushed_off", "The can is pushed off the table.")
    lamps = [window(-1.6, 0.5, 0.9, 6.5)]
    return Scene(bodies, eye, lamps, indoors(0.5), event, ("table",))


def toy_train(rng: Rng) -> Scene:
    """A painted wooden locomotive, seen from its left, on a striped carpet."""
    pattern = stripes([70, 12, 40, 12, 70, 30], [(150, 60, 52), (222, 204, 168), (56, 70, 88),
                      (222, 204, 168), (150, 60, 52), (196, 142, 76)], 1400)  # fmt: skip
    pile = cloth(rng, pattern, 4, 6e-4)
    bodies = [
        Body((0.155, 0.062, 0.082), locomotive(), (0.05, 0.72, 0.0795), turned(-9), "toy_train"),
        slab((4, 4, 0.05), (0, 2, -0.05), spread(pile, 0.0012, (4, 4, 0.05))),
        flat_wall(2.2, plaster(rng, (900, 1400), 0.003, (206, 198, 214)), 0.003),
        skirting(2.2, (236, 234, 230), 0.12),
        bookcase(rng, (0.45, 0.12, 0.5), (-0.42, 2.07, 0.5)),
    ]
    eye = eye_at((832, 480), 34, 0.27, 13, 0.72)
    event = ("drives", "The toy train drives to the left.")
    return Scene(bodies, eye, [window(1.5, 0.2, 1.0, 6)], indoors(0.5), event, exposure=0.25)


def blocks(rng: Rng) -> Scene:
    """Three stained blocks with letters, not quite straight, on a linen cloth."""
    side, bodies, foot = 0.064, [], 0.0
    for name, stain, letter, x, yaw in (
        ("bottom_block", (70, 120, 190), "C", 0.0, 24), ("middle_block", (222, 168, 70), "B",
         0.004, 8), ("top_block", (196, 74, 62), "A", -0.003, 36),
    ):  # fmt: skip
        finish = painted_block(rng, side, stain, letter)
        part = Part(brick(cubic(side / 2), 0.004), finish)
        place = (-0.05 + x, 0.62, foot + side / 2)
        reach = cubic(side / 2 + 0.001)
        bodies.append(Body(reach, (part,), place, turned(yaw), name))
        foot += side
    linen = cloth(rng, stripes([170, 22, 14, 22], [(206, 198, 176), (86, 112, 104),
                  (206, 198, 176), (86, 112, 104)], 1140).swapaxes(0, 1), 3, 2e-4)  # fmt: skip
    bodies += [
        slab((4, 4, 0.05), (0, 2, -0.05), spread(linen, 0.0008, (4, 4, 0.05))),
        flat_wall(1.9, plaster(rng, (900, 1400), 0.003, (150, 164, 178)), 0.003),
        bookcase(rng, (0.36, 0.14, 0.5), (0.5, 1.75, 0.5)),
    ]
    eye = eye_at((720, 480), 40, 0.24, 14, 0.6)
    event = ("falls_over", "The tower of blocks falls over to the right.")
    return Scene(bodies, eye, [window(-1.2, 0.1, 0.9, 6.5)], indoors(0.5), event)


def mug(rng: Rng) -> Scene:
    """A two-glaze mug of coffee on granite before metro tiles."""

    def glaze(p: Array) -> Array:
        angle = np.arctan2(p[:, 1], p[:, 0])
        edge = 0.004 * np.sin(3 * angle + 1) + 0.003 * np.sin(8 * angle) + 0.006
        top = np.clip((p[:, 2] - edge) / 0.0016, 0, 1)[:, None]
        fleck = (solid(p * 900, 5) > 0.62)[:, None] * 0.5
        lower = linear((224, 214, 194)) * (1 - fleck) + linear((96, 66, 44)) * fleck
        upper = linear((36, 96, 112)) * (1 + 0.3 * solid_layered(p * [60, 60, 20], 6))[:, None]
        colour = lower * (1 - top) + upper * top
        colour[p[:, 2] < -0.041] = linear((168, 120, 86))
        return np.clip(colour, 0, 1).astype(np.float32)

    cup = cut(rod(0.041, 0.047, edge=0.004), rod(0.0372, 0.047, centre=(0, 0, 0.006)))
    handle = cut(ring(0.026, 0.0058, 1, (0.044, 0, 0)), rod(0.039, 0.06))
    stone = grit(rng, [(84, 80, 78), (140, 126, 112), (40, 39, 41), (176, 166, 154)], 4)
    metro = tiled(rng, (50, 100), [(228, 230, 226), (222, 226, 222)], (150, 148, 142), count=12,
                  shift=0.5, cloud=0.01)  # fmt: skip
    half = (3, 0.42, 0.02)
    bodies = [
        Body((0.078, 0.043, 0.048), (
            Part(cup, Finish(glaze, 0.05, 0.14, relief=grainy(8e-5, 90))),
            Part(handle, Finish(glaze, 0.05, 0.14)),
            Part(rod(0.0374, 0.02, centre=(0, 0, 0.012)), Finish(even((44, 24, 14)), 0.03, 0.02)),
        ), (0.09, 0.62, 0.047), turned(-24), "mug"),
        slab(half, (0, 0.83, -0.02), spread(stone, 0.0006, half, rough=0.18)),
        flat_wall(1.25, metro, 0.0015, -0.02, tiles=True),
        Body((0.05, 0.05, 0.2), (Part(joined(rod(0.045, 0.075, centre=(0, 0, -0.125), edge=0.006),
             rod(0.018, 0.012, centre=(0, 0, -0.04))), Finish(even((196, 120, 84)), rough=0.3)),),
             (-0.3, 1.05, 0.2)),
    ]  # fmt: skip
    eye = eye_at((720, 480), 28, 0.3, 23, 0.6)
    event = ("slides", "The mug slides to the left and comes to rest.")
    lamps = [window(1.5, 0.4, 0.8, 6), Lamp((0, 1.0, 0.9), (0.6, 0, 0), (0, 0.05, 0), (7, 6, 4.6))]
    return Scene(bodies, eye, lamps, indoors(0.45, 1.04), event, balance=(1, 0.99, 0.97))


def lemon_and_glass(rng: Rng) -> Scene:
    """A lemon and an empty tumbler on a checked cloth."""

    tips = joined(ball(0.0065, (0.0425, 0, 0)), ball(0.006, (-0.042, 0, 0)))
    lemon = melted(egg((0.042, 0.0315, 0.0315)), tips, 0.014)

    def peel(p: Array) -> Array:
        tone = np.clip(0.5 + 0.4 * solid_layered(p * 45, 2), 0, 1)[:, None]
        end = np.clip((np.abs(p[:, :1]) - 0.036) / 0.012, 0, 1)
        colour = linear((246, 206, 34)) * (1 - tone) + linear((232, 182, 20)) * tone
        return (colour * (1 - end) + linear((176, 170, 44)) * end).astype(np.float32)

    glass = cut(rod(0.036, 0.055, taper=0.08), rod(0.0332, 0.055, centre=(0, 0, 0.012), taper=0.08))
    check = stripes([24, 24], [(255, 255, 255), (0, 0, 0)], 1440)[..., 0] > 0.5
    both = check.astype(int) + check.T
    tones = np.stack([linear(c) for c in ((236, 232, 224), (126, 158, 196), (44, 84, 142))])
    linen = cloth(rng, tones[both], 3, 2e-4)
    bodies = [
        Body((0.052, 0.036, 0.036), (Part(lemon, Finish(peel, 0.045, 0.3,
             relief=grainy(3.5e-4, 420), grain=3e-4)),), (-0.13, 0.62, 0.0325), turned(62, 4),
             "lemon"),
        Body((0.043, 0.043, 0.056), (Part(glass, Finish(even((255, 255, 255)), clear=True)),),
             (0.09, 0.64, 0.0555), name="glass"),
        slab((1.2, 0.55, 0.02), (0, 0.9, -0.02), spread(linen, 0.0008, (1.2, 0.55, 0.02))),
        flat_wall(2.4, plaster(rng, (900, 1400), 0.003, (190, 160, 132)), 0.003, -0.7),
        slab((0.4, 0.02, 0.3), (0.45, 2.36, 0.25), Finish(even((70, 84, 74)), rough=0.2)),
    ]  # fmt: skip
    eye = eye_at((832, 480), 27, 0.25, 16, 0.62)
    event = ("knocks_over", "The lemon rolls into the glass and knocks it over.")
    return Scene(bodies, eye, [window(-1.3, 0.5, 0.8, 6)], indoors(0.55), event)


def box_and_ball(rng: Rng) -> Scene:
    """A taped parcel on floor boards, and a marbled ball near its right edge."""
    half, cell = (0.15, 0.11, 0.10), 420
    fibre = layered(rng, (2 * cell, 3 * cell), (3, 30), 3)
    flute = np.sin(np.arange(3 * cell) / 3)[None, :] * 0.02
    atlas = linear((184, 140, 94)) * (1 + 0.05 * fibre + flute)[..., None]
    atlas = atlas * (1 + 0.06 * layered(rng, (2 * cell, 3 * cell), (90, 90)))[..., None]
    front = written("FRAGILE", (cell, cell), 2.2, 6, (60, 330))
    for x in (130, 210):
        cv2.arrowedLine(front, (x, 220), (x, 110), 0.9, 9, cv2.LINE_AA, 0, 0.4)
    cv2.rectangle(front, (270, 100), (350, 220), 0.9, 6, cv2.LINE_AA)
    atlas = printed(atlas.astype(np.float32), front, (60, 40, 30), 0.85, "013")
    tape = np.zeros((2 * cell, 3 * cell), np.float32)
    tape[cell : 2 * cell, cell : 2 * cell][175:245] = 1
    tape[:cell, :cell][300:, 175:245] = tape[:cell, cell : 2 * cell][300:, 175:245] = 1
    atlas += (linear((206, 180, 130)) * 1.05 - atlas) * 0.75 * tape[..., None]
    atlas[cell + 208 : cell + 211, cell : 2 * cell] *= 0.45

    def marble(p: Array) -> Array:
        wave = np.sin(3 * np.arctan2(p[:, 1], p[:, 0]) + 55 * p[:, 2])
        part = np.clip(wave * np.hypot(p[:, 0], p[:, 1]) / 0.0016 + 0.5, 0, 1)[:, None]
        colour = linear((34, 104, 160)) * (1 - part) + linear((226, 92, 58)) * part
        colour[np.abs(p[:, 2]) < 0.005] = linear((238, 226, 196))
        return (colour * (1 + 0.06 * solid_layered(p * 60, 11))[:, None]).astype(np.float32)

    wood = boards(rng, (3.2, 3.2), 0.002, light=(196, 168, 132), dark=(120, 88, 58))
    card = Part(brick(half, 0.003), Finish(faces(half, atlas.astype(np.float32)), 0.03, 0.7,
                relief=grainy(2e-4, 60)))  # fmt: skip
    bodies = [
        Body((0.151, 0.111, 0.101), (card,), (-0.12, 1.15, 0.0995), turned(-17),
             "cardboard_box"),
        Body(cubic(0.051), (Part(ball(0.05), Finish(marble, 0.045, 0.22)),), (-0.05, 1.13, 0.25),
             turned(30, 20), "ball"),
        slab((4, 4, 0.05), (0.3, 2, -0.05), spread(wood, 0.002, (4, 4, 0.05), rough=0.35)),
        flat_wall(2.5, plaster(rng, (900, 1400), 0.003, (172, 184, 160)), 0.003),
        skirting(2.5, (232, 230, 224), 0.1),
    ]  # fmt: skip
    eye = eye_at((720, 480), 34, 0.60, 21, 1.1)
    event = ("rolls_off", "The ball rolls off the box and drops to the floor.")
    return Scene(bodies, eye, [window(-1.7, 0.6, 1.3, 7)], indoors(0.55), event)


def orange(rng: Rng) -> Scene:
    """An orange in mid-air over a round garden table in the sun."""

    def peel(p: Array) -> Array:
        tone = np.clip(0.5 + 0.5 * solid_layered(p * 35, 2), 0, 1)[:, None]
        star = np.clip(1 - np.hypot(p[:, 0], p[:, 1]) / 0.005, 0, 1)[:, None] * (p[:, 2:] > 0)
        colour = linear((242, 138, 22)) * (1 - tone) + linear((230, 116, 16)) * tone
        return (colour * (1 - star) + linear((92, 110, 50)) * star).astype(np.float32)

    def dimple(p: Array) -> Array:
        pit = np.clip(solid(p * 520, 7) - 0.1, 0, 1) * -6e-4
        stem = -0.004 * np.exp(-((np.hypot(p[:, 0], p[:, 1]) / 0.006) ** 2)) * (p[:, 2] > 0)
        return (pit + stem).astype(np.float32)

    def leaves(p: Array) -> Array:
        tone = np.clip(0.35 + 0.5 * solid_layered(p * [5, 5, 6], 21, 5), 0, 1)[:, None]
        fine = 1 + 0.5 * solid_layered(p * 45, 25)[:, None]
        colour = linear((30, 46, 26)) * (1 - tone) + linear((122, 142, 86)) * tone
        return (colour * fine).astype(np.float32)

    half = (0.62, 0.62, 0.018)
    wood = boards(rng, (1.6, 1.6), 0.001, light=(176, 158, 134), dark=(108, 92, 76))
    board = spread(wood, 0.001, half)
    lawn = cloth(rng, stripes([60, 60], [(92, 112, 62), (100, 120, 66)], 960), 4, 2e-3)
    bodies = [
        Body(cubic(0.041), (Part(ball(0.04), Finish(peel, 0.045, 0.33, relief=dimple,
             grain=3e-4)),), (-0.03, 0.82, 0.235), turned(0, 30, 38), "orange"),
        Body(half, (Part(rod(0.61, 0.017, edge=0.006), board),), (0.05, 1.0, -0.017), turned(24),
             "table"),
        slab((20, 20, 0.05), (0, 5, -0.77), spread(lawn, 0.004, (20, 20, 0.05))),
        slab((12, 0.4, 1.2), (0, 6.5, 0.45), Finish(leaves, rough=0.8)),
    ]  # fmt: skip
    eye = eye_at((720, 480), 36, 0.36, 13, 0.85, 0.007)
    event = ("falls", "The orange falls onto the table and bounces.")
    lamps = [sun(-0.6, -0.35, 1.1, 2300)]
    return Scene(bodies, eye, lamps, outdoors, event, ("table",), exposure=0.36)


def skateboard(rng: Rng) -> Scene:
    """A skateboard from the side on asphalt, a kerb and a brick wall behind."""

    tar = grit(rng, [(96, 94, 92), (124, 120, 116), (64, 63, 63), (138, 133, 126)], 2.6)
    kerb = grit(rng, [(168, 164, 156), (190, 186, 176), (130, 128, 122)], 4)
    brickwork = tiled(rng, (32, 94), [(150, 82, 62), (164, 96, 72), (132, 72, 58), (172, 112, 84)],
                      (178, 170, 156), count=14, shift=0.5)  # fmt: skip
    walk = (9, 0.8, 0.06)
    bodies = [
        Body((0.41, 0.102, 0.08), board(), (-0.1, 1.45, 0.073), turned(7), name="skateboard"),
        slab((9, 6, 0.05), (0, 3, -0.05), spread(tar, 0.0016, (9, 6, 0.05))),
        slab(walk, (0, 3.3, 0.06), spread(kerb, 0.0025, walk)),
        flat_wall(4.1, brickwork, 0.0025, tiles=True),
    ]  # fmt: skip
    eye = eye_at((832, 480), 33, 0.34, 9, 1.45, 0.004)
    event = ("rolls", "The skateboard rolls slowly to the right.")
    return Scene(
        bodies,
        eye,
        [sun(0.75, -0.5, 1.0, 2300)],
        outdoors,
        event,
        exposure=0.30,
        balance=(1.07, 1, 0.9),
    )


def billiards(rng: Rng) -> Scene:
    """A white and a red ball on worn green cloth, others and a cushion behind, lamps above."""

    def enamel(colour: Colour, stripe: bool = False, number: str = "") -> Finish:
        sheet = written(number, (120, 120), 2.4, 7, (36, 86))

        def paint(p: Array) -> Array:
            tone = even(colour, 0.02, 40)(p)
            if stripe:
                tone[np.abs(p[:, 2]) > 0.016] = linear((236, 230, 212))
            if number:
                disc = (np.hypot(p[:, 0], p[:, 2]) < 0.0115) & (p[:, 1] < 0)
                ink = picked(sheet, 60 - p[:, 2] * 4400, 60 + p[:, 0] * 4400)[:, None]
                print_ = linear((238, 232, 214)) * (1 - ink) + linear((24, 22, 22)) * ink
                tone = np.where(disc[:, None], print_, tone)
            return tone.astype(np.float32)

        return Finish(paint, 0.05, 0.07)

    def placed(x: float, y: float, finish: Finish, turn: Triple, name: str | None = None) -> Body:
        part = Part(ball(0.0286), finish)
        return Body(cubic(0.029), (part,), (x, y, 0.0284), turned(*turn), name)

    baize = cloth(
        rng, np.tile(linear((28, 112, 72)), (1400, 1400, 1)).astype(np.float32), 2.2, 9e-5
    )
    felt = spread(baize, 0.0008, (2, 2, 0.02))
    half = (2, 0.09, 0.03)
    rail = boards(rng, (2, 0.4), 0.0012, light=(150, 84, 48), dark=(66, 30, 18))
    pearl = Finish(even((232, 228, 214)), rough=0.2)
    bodies = [
        placed(-0.15, 0.66, enamel((238, 232, 214)), (20, 10, 0), "white_ball"),
        placed(0.06, 0.70, enamel((178, 26, 28), number="3"), (24, 12, 20), "red_ball"),
        placed(0.27, 0.98, enamel((226, 168, 32), True, "9"), (-40, 30, 20)),
        placed(-0.02, 1.18, enamel((26, 26, 28), number="8"), (30, -20, 10)),
        slab((2, 0.85, 0.02), (0, 0.82, -0.02), felt),
        slab((2, 0.03, 0.018), (0, 1.5, 0.018), felt),
        slab(half, (0, 1.6, 0.012), spread(rail, 0.0012, half, rough=0.3)),
        *(slab((0.008, 0.008, 0.0005), (x, 1.6, 0.0424), pearl) for x in (-0.5, -0.1, 0.3, 0.7)),
        flat_wall(3.6, plaster(rng, (900, 1400), 0.003, (96, 62, 54)), 0.003, -0.8),
    ]
    eye = eye_at((832, 480), 27, 0.24, 14, 0.68, 0.0035)
    event = ("hits", "The white ball rolls to the right and hits the red ball.")
    lamps = [Lamp((x, 0.9, 1.0), (0.22, 0, 0), (0, 0.16, 0), (11, 9.6, 7.4)) for x in (-0.5, 0.5)]
    balance = (0.97, 1.0, 1.08)
    return Scene(bodies, eye, lamps, indoors(0.16, 1.05), event, balance=balance, exposure=0.17)


SCENES: dict[str, Callable[[Rng], Scene]] = {
    "beach_ball": beach_ball, "tin_can": tin_can, "toy_train": toy_train, "blocks": blocks,
    "mug": mug, "lemon_and_glass": lemon_and_glass, "box_and_ball": box_and_ball,
    "orange": orange, "skateboard": skateboard, "billiards": billiards,
}  # fmt: skip


MANY_PARTS = {"mug": 3, "glass": 3, "toy_train": 4, "skateboard": 3, "beach_ball": 3}
"""Clicks on things of many parts or colours; one on all others."""


def clicks(mask: NDArray[np.bool_], count: int) -> list[list[int]]:
    """The pixels deepest inside a mask, each away from those before it, as [x, y, 1]."""
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)
    rows, columns = np.indices(depth.shape)
    apart = 0.25 * float(np.sqrt(mask.sum()))
    found: list[list[int]] = []
    for _ in range(count):
        y, x = np.unravel_index(int(depth.argmax()), depth.shape)
        found.append([int(x) - 1, int(y) - 1, 1])
        depth[np.hypot(rows - y, columns - x) < 2 * apart] = 0
    return [one for one in found if mask[one[1], one[0]]]


def write(name: str, out: Path, samples: int, factor: float) -> None:
    """Draw one scene into `out`/`name`."""
    seed = 100 + list(SCENES).index(name)
    scene = SCENES[name](np.random.default_rng(seed))
    eye = scene.eye.scaled(factor)
    world = World(scene.bodies, scene.lamps, scene.sky)
    light = traced(world, eye, samples=samples, seed=seed)
    exposure = scene.exposure / float(np.percentile(light.mean(-1), 60))
    picture = develop(light, exposure=exposure, balance=scene.balance, seed=seed, blur=0.5)
    folder = out / name
    (folder / "masks").mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "input.png"), picture[..., ::-1])
    numbers = identities(world, eye)
    points: dict[str, list[list[int]]] = {}
    for number, body in enumerate(scene.bodies):
        if body.name is not None:
            mask = numbers == number
            points[body.name] = clicks(mask, MANY_PARTS.get(body.name, 1))
            cv2.imwrite(str(folder / "masks" / f"{body.name}.png"), mask.astype(np.uint8) * 255)
    case = {
        "image": "input.png",
        "size": list(eye.size),
        "objects": {n: {"points": p} for n, p in points.items() if n not in scene.supports},
        "supports": {n: {"points": points[n]} for n in scene.supports},
        "events": dict([scene.event]),
    }
    (folder / "case.yaml").write_text(yaml.safe_dump(case, sort_keys=False, width=1000))


def main() -> None:
    """Read the command line and draw the scenes that are asked for, all by default."""
    parser = argparse.ArgumentParser(description="Draw ten strange pictures as cases.")
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*", default=list(SCENES), help=", ".join(SCENES))
    parser.add_argument("--samples", type=int, default=20, help="paths per pixel")
    parser.add_argument("--scale", type=float, default=1.0, help="of the picture's sides")
    args = parser.parse_args()
    for name in args.names:
        start = time.monotonic()
        write(name, args.out, args.samples, args.scale)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
