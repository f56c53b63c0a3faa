"""How far two bodies of a scene are apart, and whether one is on the other.

What a sentence asks of a scene is asked again and again, of many states that have the same bodies:
answers are kept by the bodies' values.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene import shapes
from physagent_studio.program.scene.state import Shape, SupportShape


@dataclass(frozen=True, slots=True)
class Body:
    """form: an object's shape, position (m) and rotation (wxyz), or a support's shape."""

    form: tuple[Shape, tuple[float, ...], tuple[float, ...]] | SupportShape

    def placed(self) -> shapes.Placed:
        """The body where it stands."""
        if not isinstance(self.form, tuple):
            return shapes.place_support(self.form)
        shape, position, rotation = self.form
        matrices = matrix_of(rotation)[None]
        return shapes.Placed(shapes.outline_of(shape), None, np.array([position], float), matrices)


@lru_cache(maxsize=4096)
def gap(first: Body, second: Body) -> float:
    """Distance of two bodies' surfaces, m; 0 or less where they touch."""
    return float(shapes.gap(first.placed(), second.placed())[0])


@lru_cache(maxsize=4096)
def is_on(body: Body, other: Body) -> bool:
    """Whether a body is as good as in touch with another, for its own size."""
    size = size_of(body.form[0]) if isinstance(body.form, tuple) else 0.0
    return gap(body, other) < max(0.02, 0.15 * size)


def size_of(shape: Shape) -> float:
    """Mean edge of a shape's bounding box, m."""
    return float(shapes.outline_of(shape).size.mean())
