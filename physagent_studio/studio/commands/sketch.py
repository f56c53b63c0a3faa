"""A photo that no session has been made of yet: kept, and its things cut out to be looked at."""

from __future__ import annotations

import base64
import binascii
import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from physagent_studio.errors import InputError
from physagent_studio.jobs import Executor
from physagent_studio.program import Grounding
from physagent_studio.program.base import Name
from physagent_studio.reconstruction import read_photo
from physagent_studio.records import Image
from physagent_studio.studio.commands.asking import FileText, Ticket, asked
from physagent_studio.studio.desk_apart import DeskApart

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

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
