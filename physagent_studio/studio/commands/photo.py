"""What the photo's tools do: ask the finder, or post one group of edits."""

from __future__ import annotations

import base64
import binascii
import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from physagent_studio.errors import InputError
from physagent_studio.jobs import Executor
from physagent_studio.program import Edit, Grounding, apply
from physagent_studio.program.base import Name, Pixel, Pixels, Tilt
from physagent_studio.program.scene.state import FormKind
from physagent_studio.reconstruction import read_photo
from physagent_studio.reconstruction.grounding.similar_things import covered, similar
from physagent_studio.records import Case, Image
from physagent_studio.studio.commands.asking import FileText, Ticket, asked
from physagent_studio.studio.commands.program import open_program
from physagent_studio.studio.first_scene import disproved, marked, unwritten
from physagent_studio.studio.photo_desk import LOOKING, DeskApart
from physagent_studio.workbench import Snapshot, commands, photo_edits

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio


@asked("masks")
def find_masks(
    studio: Studio, browser: int, name: Name, grounding: Grounding, ticket: Ticket
) -> None:
    """The candidate masks that a grounding would give; the page hears of them on `masks`."""
    case, image = _photo(studio.snapshot)
    scene = marked(studio.snapshot)
    desk, shown = studio.photo_desk, studio.snapshot.scene
    out = {name, *disproved(scene, shown, name, grounding)}
    said = [(item.name, item.grounding) for item in scene.objects if item.name not in out]

    def find(*, whole: bool) -> dict[str, Any]:
        photo_edits.check_grounding(case, name, grounding)
        stop = partial(studio.finder.overtaken, browser, "masks") if whole else None
        return desk.masks(image, name, [*said, (name, grounding)], shown, whole, stop, early)

    def early(found: dict[str, Any]) -> None:
        studio.finder.tell_early(browser, "masks", ticket, found)

    studio.finder.ask(
        browser, "masks", ticket, partial(find, whole=False), partial(find, whole=True)
    )


@asked("edge")
def find_edge(studio: Studio, browser: int, start: Pixel, end: Pixel, ticket: Ticket) -> None:
    """The way along the picture's edges from an anchor to the pointer, told on `edge`."""
    _, image = _photo(studio.snapshot)
    desk = studio.photo_desk
    studio.finder.ask(browser, "edge", ticket, lambda: desk.way(image, start, end))


@asked("mask")
def take_mask(
    studio: Studio, browser: int, name: Name, grounding: Grounding, layer: bool = False
) -> None:
    """The grounding of an object or support as the person wants it; a new name is an object.

    layer: what is wanted is the layer of a stack that the clicks on all of the stack give.
    """

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        wrong = disproved(s.program.scene, s.scene, name, grounding)
        if wrong:
            _ask_for(studio, browser, name, min(wrong))
        return photo_edits.mask_edits(
            s.program, case, s.state.pinned, name, grounding, layer=layer, wrong=wrong
        )

    _post(studio, edits_of, f"mask of {name}")


def _ask_for(studio: Studio, browser: int, name: str, wrong: str) -> None:
    """Asks for the first of the things whose place another has taken."""
    spoken, other = name.replace("_", " "), wrong.replace("_", " ")
    text = f"The words had found {other} where {spoken} is: mark {other} as well."
    choose = {"do": "select", "kind": "object", "name": wrong}
    studio.say(browser, "info", text, (f"Choose {other}", choose))


@asked("like")
def find_alike(
    studio: Studio, browser: int, ticket: Ticket, name: Annotated[str, Field(max_length=64)] = ""
) -> None:
    """What looks like a thing and is not marked, told on `like`; name "": what the fill covers."""
    _, image = _photo(studio.snapshot)
    scene = studio.snapshot.scene
    named = {item.name for item in studio.snapshot.program.scene.objects}
    masks = {} if scene is None else {n: m for n, m in scene.masks.items() if n in named}

    def find() -> dict[str, Any]:
        if name:
            same = studio.apart.submit(similar, image, name, masks, limits=LOOKING)
            return {"name": name, "found": {name: same}}
        if scene is None or scene.plate is None:
            return {"name": "", "found": {}}
        found = studio.apart.submit(covered, image, scene.plate, masks, limits=LOOKING)
        return {"name": "", "found": found}

    studio.finder.ask(browser, "like", ticket, find)


@asked("alike")
def mark_alike(
    studio: Studio,
    browser: int,
    name: Name,
    boxes: Annotated[tuple[tuple[Pixels, Pixels, Pixels, Pixels], ...], Field(max_length=16)],
) -> None:
    """Things in these boxes are like the thing of that name, each one of its own."""

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        return photo_edits.alike_edits(s.program, case, s.state.pinned, name, boxes)

    _post(studio, edits_of, f"things like {name}")


@asked("horizon")
def set_horizon(
    studio: Studio,
    browser: int,
    row: Pixels,
    roll: Tilt | None = None,
) -> None:
    """The horizon's row in the middle column, pixels.

    roll: degrees by which it rises to the right; None leaves that as it is.
    """

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        return photo_edits.horizon_edits(s.program, case, s.state.pinned, row, roll)

    _post(studio, edits_of, "horizon")


@asked("size")
def set_size(
    studio: Studio, browser: int, name: Name, metres: Annotated[float, Field(gt=0, le=1e4)]
) -> None:
    """How large an object is, m, and with it everything."""

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        return photo_edits.size_edits(s.program, case, s.state.pinned, name, metres)

    _post(studio, edits_of, f"size of {name}")


@asked("ramp")
def place_ramp(
    studio: Studio, browser: int, toe: Pixel, foot: Pixel, top: Pixel, name: Name | None = None
) -> None:
    """A ramp by three clicks; without a name a new one."""

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        marks = (toe, foot, top)
        return photo_edits.ramp_edits(s.program, case, s.state.pinned, name or "", marks)

    _post(studio, edits_of, "ramp")


@asked("form")
def switch_form(studio: Studio, browser: int, name: Name, kind: FormKind | None = None) -> None:
    """Another kind of shape for an object; None is the next one."""

    def edits_of(s: Snapshot, case: Case) -> tuple[Edit, ...]:
        offers = () if s.scene is None else s.scene.shapes.get(name, ())
        return photo_edits.form_edits(s.program, s.state.pinned, name, kind, offers)

    _post(studio, edits_of, f"shape of {name}")


def _post(
    studio: Studio, edits_of: Callable[[Snapshot, Case], tuple[Edit, ...]], reason: str
) -> None:
    """Checks a group of edits while the person still looks, then has it carried out."""
    snapshot = studio.snapshot
    case, _ = _photo(snapshot)
    if unwritten(snapshot):
        if snapshot.busy is None:
            raise InputError(f"the {reason} needs a scene to belong to: press Start to make one")
        # What it changes is being made now.
        studio.once_written(lambda: _post(studio, edits_of, reason))
        return
    program = open_program(studio)
    edits = edits_of(snapshot, case)
    apply(program, edits)
    studio.workbench.post(commands.ApplyEdits(edits, reason))


def _photo(snapshot: Snapshot) -> tuple[Case, Image]:
    if snapshot.case is None or snapshot.case.image is None:
        raise InputError("this program has no photo")
    return snapshot.case, snapshot.case.image


PHOTO_BYTES = 16 * 2**20
SIGNATURES = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp"}
BEFORE = 4
"""Browsers whose photos are kept at a time; whoever comes back shows it again."""


class Sketches:
    """The photo that each browser looks at in the dialog for a new session."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._paths: dict[int, Path] = {}
        self._desks: dict[Path, tuple[Image, DeskApart]] = {}

    def keep(self, browser: int, path: Path) -> None:
        """Remembers which photo a browser shows."""
        self._paths.pop(browser, None)
        self._paths[browser] = path
        for old in list(self._paths)[:-BEFORE]:
            del self._paths[old]
        self._desks = {p: d for p, d in self._desks.items() if p in self._paths.values()}

    def desk(self, browser: int) -> tuple[Image, DeskApart]:
        """The photo's pixels, and who looks for masks in it; read when they are first wanted."""
        path = self._paths.get(browser)
        if path is None:
            raise InputError("choose the photo again")
        if path not in self._desks:
            self._desks[path] = (read_photo(path)[0], DeskApart(self._executor))
        return self._desks[path]


def kept_photo(text: str, folder: Path) -> Path:
    """The file of a photo that came as base64, kept by its content."""
    try:
        photo = base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise InputError("the photo did not arrive whole; try again") from error
    if len(photo) > PHOTO_BYTES:
        raise InputError(f"the photo has {len(photo) / 2**20:.1f} MB; at most 16 are allowed")
    suffix = next((end for start, end in SIGNATURES.items() if photo.startswith(start)), None)
    if suffix is None:
        raise InputError("this is no PNG, JPEG or WebP picture")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{hashlib.sha256(photo).hexdigest()[:24]}{suffix}"
    path.write_bytes(photo)
    return path


@asked("sketch")
def sketch(studio: Studio, browser: int, photo: FileText) -> None:
    """A photo (base64) that a new session may be made of: kept to look for masks in."""
    path = kept_photo(photo, studio.workbench.store.root / "photos")
    studio.sketches.keep(browser, path)


@asked("sketch_masks")
def masks(
    studio: Studio,
    browser: int,
    name: Name,
    said: Annotated[tuple[tuple[Name, Grounding], ...], Field(max_length=100)],
    ticket: Ticket,
) -> None:
    """The candidate masks of a thing in that photo; the page hears of them on `sketch`.

    said: all things that are marked in it.
    """

    def find() -> dict[str, Any]:
        image, desk = studio.sketches.desk(browser)
        return desk.masks(image, name, list(said), whole=False)

    studio.finder.ask(browser, "sketch", ticket, find)
