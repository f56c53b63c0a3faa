"""One colour for each thing, wherever it is drawn: its own, kept apart from the others'.

What the photo or the scene shows a thing in is its colour, a little clearer than it is, so that a
line of it is seen. Where two are alike the later one is lighter or darker.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.records import Mesh
from physagent_studio.studio.scene.primitives import color_of
from physagent_studio.workbench import Snapshot

Color = tuple[int, int, int]
APART = 22.0
"""Distance in CIE L*a*b* from which on two small squares are told apart at a glance."""
DARKEST, LIGHTEST = 35.0, 82.0
"""Lightness L* within which a line is seen on white and on nearly black."""
CLEARER = 1.4
"""What a* and b* are multiplied by: a mean over light and shade is duller than the thing looks."""
STEP = 11.0
"""Steps of L* in which a colour is made lighter or darker."""


def colours_of(snapshot: Snapshot) -> dict[str, Color]:
    """The colour of each thing of the scene on view, by its name."""
    names = dict.fromkeys(item.name for item in snapshot.program.scene.objects)
    if snapshot.rollout is not None:  # of what was taken out since, the path is still drawn
        names |= dict.fromkeys(snapshot.rollout.objects)
    return own_colours(tuple(names), {} if snapshot.scene is None else snapshot.scene.meshes)


def own_colours(names: Sequence[str], meshes: Mapping[str, Mesh]) -> dict[str, Color]:
    """Colours of things, in their order, from what they are drawn as; without it by their names."""
    own = tuple(meshes[name].color if name in meshes else color_of(name) for name in names)
    return dict(zip(names, apart(own), strict=True))


@lru_cache(maxsize=16)
def apart(colours: tuple[Color, ...]) -> tuple[Color, ...]:
    """The same colours, clearer, and where two are alike the later one lighter or darker."""
    levels = np.arange(DARKEST, LIGHTEST + 1, STEP)
    taken: list[NDArray[np.float64]] = []
    for colour in colours:
        lab = _lab(colour) * [1.0, CLEARER, CLEARER]
        lab[0] = np.clip(lab[0], DARKEST, LIGHTEST)
        nearest = sorted(levels, key=lambda level, own=lab[0]: abs(level - own))
        tries = [lab, *(np.array([level, *lab[1:]]) for level in nearest)]
        free = [min((float(np.linalg.norm(t - o)) for o in taken), default=APART) for t in tries]
        at = next((at for at, room in enumerate(free) if room >= APART), int(np.argmax(free)))
        taken.append(tries[at])
    return tuple(_rgb(lab) for lab in taken)


def _lab(colour: Color) -> NDArray[np.float64]:
    pixel = np.array(colour, np.float32).reshape(1, 1, 3) / 255
    return cv2.cvtColor(pixel, cv2.COLOR_RGB2LAB)[0, 0].astype(np.float64)


def _rgb(lab: NDArray[np.float64]) -> Color:
    pixel = cv2.cvtColor(lab.astype(np.float32).reshape(1, 1, 3), cv2.COLOR_LAB2RGB)[0, 0]
    red, green, blue = (round(float(part) * 255) for part in np.clip(pixel, 0, 1))
    return red, green, blue
