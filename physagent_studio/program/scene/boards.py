"""Hollow shapes: which they are, and the boards of a box that is open at the top."""

from physagent_studio.program.scene import forms

Size3 = tuple[float, float, float]


def is_hollow(shape: forms.Shape | forms.SupportShape | None) -> bool:
    """Whether other things can be in it: an open vessel, a ring."""
    if isinstance(shape, forms.Vessel):
        return True
    walled = (
        isinstance(shape, forms.Box | forms.Frustum | forms.Revolved) and shape.wall is not None
    )
    return walled or isinstance(shape, forms.Torus)


def rails_of(slab: forms.Slab) -> tuple[tuple[Size3, Size3], ...]:
    """The bars (centre, edge lengths) of a slab in its own frame: two rails, or the whole box."""
    x, y, z = slab.size
    if slab.rail is None:
        return (((0.0, 0.0, 0.0), (x, y, z)),)
    wide = min(slab.rail, 0.5 * min(x, y))
    off = (min(x, y) - wide) / 2
    if x >= y:
        return tuple(((0.0, side * off, 0.0), (x, wide, z)) for side in (-1, 1))
    return tuple(((side * off, 0.0, 0.0), (wide, y, z)) for side in (-1, 1))


def open_box(size: Size3, wall: float) -> tuple[tuple[Size3, Size3], ...]:
    """The boards (centre, edge lengths) of a box that is open at the top: bottom and four sides.

    wall: thickness of the boards, m; at most what fits into the box.
    """
    x, y, z = size
    wall = min(wall, 0.45 * min(x, y), 0.9 * z)
    rise = z - wall
    middle = wall / 2
    return (
        ((0.0, 0.0, (wall - z) / 2), (x, y, wall)),
        ((0.0, (y - wall) / 2, middle), (x, wall, rise)),
        ((0.0, (wall - y) / 2, middle), (x, wall, rise)),
        (((x - wall) / 2, 0.0, middle), (wall, y - 2 * wall, rise)),
        (((wall - x) / 2, 0.0, middle), (wall, y - 2 * wall, rise)),
    )
