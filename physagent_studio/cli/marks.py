"""What `--object` says: where in the photo a thing is, and what it is called."""

import math
import re

from physagent_studio.errors import InputError
from physagent_studio.program import Click, Grounding


def parse_objects(words: tuple[str, ...]) -> dict[str, Grounding]:
    """What each name is tied to: `name@x,y` a click inside the thing, `name@x,y,0` one outside,
    `name@x0,y0,x1,y1` a box around it, and `name` alone nothing."""
    marks: dict[str, Grounding] = {}
    for word in words:
        name, at, place = word.rpartition("@") if "@" in word else (word, "", "")
        key = "_".join(name.split())
        if not key or (not at and re.search(r"\d\s*,\s*\d", word)):
            # "marble 240,330": the numbers are no part of a name.
            raise _bad_object(word)
        said = marks.get(key, Grounding())
        marks[key] = _with_mark(said, word, place) if at else said
    return marks


def _with_mark(said: Grounding, word: str, place: str) -> Grounding:
    """The grounding with a word's two to four numbers added. Raises InputError for any others."""
    try:
        numbers = [float(one) for one in place.split(",")]
        if len(numbers) == 4:
            if said.box is not None:
                raise InputError(f'--object "{word}" is a second box for one thing; it takes one')
            return Grounding(points=said.points, box=_corners(word, numbers))
        x, y, label = numbers if len(numbers) == 3 else (*numbers, 1.0)
        click = Click.model_validate({"x": x, "y": y, "label": int(label)})
        if label != click.label:
            raise ValueError(label)
    except (ValueError, OverflowError):
        raise _bad_object(word) from None
    return Grounding(points=(*said.points, click), box=said.box)


def _corners(word: str, numbers: list[float]) -> tuple[float, float, float, float]:
    """A box from any two opposite corners: left, top, right, bottom, pixels."""
    if not all(math.isfinite(one) for one in numbers):
        raise ValueError(numbers)
    left, right = sorted(numbers[::2])
    top, bottom = sorted(numbers[1::2])
    if left == right or top == bottom:
        raise InputError(
            f'--object "{word}" is an empty box, {right - left:g} px wide and {bottom - top:g} px'
            " high; its two corners must differ in x and in y"
        )
    return left, top, right, bottom


def _bad_object(word: str) -> InputError:
    return InputError(
        f'--object "{word}" is not of the form "name@x,y" (a click) or "name@x0,y0,x1,y1" (two'
        " corners of a box) in pixels, or a name alone"
    )
