"""Open vessels: what things fall into is hollow, by its name or because the sentence needs it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.knowledge import Usual, has_lid, is_open, words_of
from physagent_studio.program.scene.state import Box, Cylinder, Frustum, Revolved, Shape
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.shapes.meshes import mesh_of

WALL, THINNEST = 0.06, 0.0015
"""Thickness of a wall over the width of the rim, and the thinnest, m."""

CAN_BE_HOLLOW = ("box", "cylinder", "frustum", "revolved")
"""Kinds of forms that walls can be given."""
_BLOWS = "bump|crash|run|slam|knock|smash|bang|plough|plow|ram|hit|drive|collide"
_INTO = re.compile(
    r"\b(?P<verb>\w+)?\s*\b(?:into|inside|in)\s+"
    r"(?:the\s+|an?\s+|its\s+|this\s+)?(?P<what>(?:\w+\s+){0,3}\w+)"
)


def is_vessel(name: str, prompt: str) -> bool:
    """Whether a thing of that name is open at the top, as the sentence uses it."""
    return is_open(name) or (has_lid(name) and _gone_into(words_of(name)[-1], prompt))


def _gone_into(noun: str, prompt: str) -> bool:
    """Whether the sentence has something go into a thing: not hit it."""
    for found in _INTO.finditer(prompt.lower()):
        verb = found.group("verb") or ""
        if re.match(rf"(?:{_BLOWS})", verb):
            continue
        # "Into the pyramid of cans" is into the pyramid.
        what = re.split(r"\b(?:of|with|and|on|near|behind)\b", found.group("what"))[0]
        if noun in words_of(what.strip().replace(" ", "_")):
            return True
    return False


def hollow_kinds(usual: Usual) -> Usual:
    """What is usual for a vessel: only forms that can be hollow, with a rim for turned ones."""
    kinds = tuple(kind for kind in usual.shapes if kind in CAN_BE_HOLLOW)
    turned = ("bowl",) if "revolved" in kinds else ()
    return replace(usual, shapes=(*turned, *kinds) or ("bowl", "frustum", "box"))


def hollow_first(found: Sequence[Form]) -> Form:
    """The best of several forms, best first, that can be hollow; the best of all where none can."""
    return next((form for form in found if _hollow(form.shape) is not None), found[0])


def opened(form: Form) -> Form:
    """The form with walls and a bottom, open at the top; what cannot be hollow stays as it is."""
    shape = _hollow(form.shape)
    if shape is None:
        return form
    return replace(form, kind=shape.kind, shape=shape, mesh=mesh_of(shape))


def _hollow(shape: Shape) -> Shape | None:
    match shape:
        case Cylinder(radius=radius, height=height):
            return Frustum(
                bottom_radius=radius, top_radius=radius, height=height, wall=_wall(radius, height)
            )
        case Frustum(top_radius=radius, height=height) if radius >= 0.5 * shape.bottom_radius:
            return shape.model_copy(update={"wall": _wall(radius, height)})
        case Revolved(profile=profile):
            height = abs(profile[-1][0] - profile[0][0])
            return shape.model_copy(update={"wall": _wall(profile[-1][1], height)})
        case Box(size=(x, y, z)):
            return shape.model_copy(update={"wall": _wall(min(x, y) / 2, z)})
        case _:
            return None


def _wall(radius: float, height: float) -> float:
    return min(max(2 * WALL * radius, THINNEST), 0.3 * height, 0.4 * radius)
