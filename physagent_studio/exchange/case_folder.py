"""A case: a folder with `case.yaml` and a photo, or a bare photo with clicks."""

import difflib
from collections.abc import Mapping
from pathlib import Path

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_clicks import horizon_of, scale_of
from physagent_studio.exchange.case_reader import (
    MAX_PROMPT,
    RESERVED,
    CaseReader,
    box_fault,
    check_inside,
    clipped,
    same_spot,
    slug,
)
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction import read_photo, read_scaled, stated_focal
from physagent_studio.records.case import Case

_FILES = ("case.yaml", "case.yml")


def load_case(folder: Path | str, event: str | None = None) -> Case:
    """The case in a folder (or in its `case.yaml`), with the prompt of one of its events.

    event: None takes the first.

    Raises:
        InputError: in one sentence, with file and line: what is wrong and what is allowed.
    """
    path = _case_file(Path(folder))
    reader = CaseReader(path)
    image = reader.image_path()
    pixels, image_hash = read_photo(image)
    reader.check_size(image, (pixels.shape[1], pixels.shape[0]))
    size = (pixels.shape[1], pixels.shape[0])
    objects = reader.objects(size)
    supports = reader.supports(size)
    landmarks = reader.landmarks(size)
    reader.check_names()
    horizon = horizon_of(reader, size)
    scale = scale_of(reader, [name for name, _ in objects])
    events = reader.events()
    name, prompt = pick_event(events, event, str(path))
    return Case(
        name=slug(path.parent.resolve().name) or "case",
        image=pixels,
        image_hash=image_hash,
        objects=objects,
        supports=supports,
        landmarks=landmarks,
        prompt=prompt,
        event=name,
        events=events,
        horizon=None if horizon is None else horizon.row,
        roll=0.0 if horizon is None else horizon.roll,
        scale=scale,
        focal=stated_focal(image, size),
    )


def case_from_image(path: Path | str, prompt: str, objects: Mapping[str, Grounding]) -> Case:
    """A case from a photo, a sentence, and clicks or a box per object name, pixels of the file.

    Raises:
        InputError: no readable picture, no object, a mark outside the picture, an empty prompt.
    """
    path = Path(path)
    pixels, image_hash, factor = read_scaled(path)
    size = (pixels.shape[1], pixels.shape[0])
    if not prompt.strip():
        raise InputError("the prompt is empty; say in a sentence what shall happen")
    if len(prompt) > MAX_PROMPT:
        raise InputError(f"the prompt has {len(prompt)} characters (at most {MAX_PROMPT})")
    if not objects:
        raise InputError("no object was named; give at least one as name@x,y")
    grounded: dict[str, Grounding] = {}
    for given, said in objects.items():
        name = slug(given)
        if not name or name in RESERVED:
            raise InputError(f"'{given}' cannot name an object (letters, digits, _ and -)")
        if name in grounded:
            raise InputError(f"object '{name}' is given twice")
        whole = (size[0] * factor, size[1] * factor)
        for click in said.points:
            check_inside(click.x, click.y, whole, f"object '{name}'")
        if said.box is not None:
            said = said.model_copy(update={"box": clipped(said.box, whole)})
        if said.box is not None and (fault := box_fault(said.box, whole)):
            raise InputError(f"object '{name}': {fault}")
        before = [(slug(one), objects[one].points) for one in list(objects)[: len(grounded)]]
        if twice := same_spot(before, said.points):
            raise InputError(f"object '{name}': {twice}")
        if not said.shows_something:
            raise InputError(f"object '{name}' has neither a click inside it (label 1) nor a box")
        grounded[name] = _scaled(said, factor)
    return Case(
        name=slug(path.stem) or "image",
        image=pixels,
        image_hash=image_hash,
        objects=tuple(grounded.items()),
        prompt=prompt.strip(),
        focal=stated_focal(path, size),
    )


def _scaled(said: Grounding, factor: int) -> Grounding:
    """Clicks and box in pixels of the picture as read, which may be smaller than its file."""
    points = (c.model_copy(update={"x": c.x / factor, "y": c.y / factor}) for c in said.points)
    if said.box is None:
        return Grounding(points=tuple(points))
    left, top, right, bottom = (value / factor for value in said.box)
    return Grounding(points=tuple(points), box=(left, top, right, bottom))


def pick_event(
    events: tuple[tuple[str, str], ...], wanted: str | None, where: str
) -> tuple[str, str]:
    """(name, prompt) of the wanted event, or of the first; ("", "") where there is none."""
    if wanted is None:
        return events[0] if events else ("", "")
    for name, prompt in events:
        if name == wanted:
            return name, prompt
    known = [name for name, _ in events]
    near = difflib.get_close_matches(wanted, known, 1, 0.5)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    raise InputError(f"{where} has no event '{wanted}' (known: {', '.join(known) or 'none'}{hint})")


def _case_file(path: Path) -> Path:
    if path.is_dir():
        for name in _FILES:
            if (path / name).is_file():
                return path / name
        raise InputError(f"{path} has no case.yaml, so it is no case folder")
    if path.is_file():
        return path
    raise InputError(f"{path} does not exist; a case is a folder with a case.yaml")
