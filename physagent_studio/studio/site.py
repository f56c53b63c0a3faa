"""What the studio serves over HTTP besides viser: its page and the pictures of the session."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files

import cv2

from physagent_studio.records import Image
from physagent_studio.session import Store
from physagent_studio.studio.guard import Page
from physagent_studio.workbench import Snapshot

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


class Site:
    """Looks pages up; called on viser's event loop, so it only reads and encodes."""

    def __init__(self, snapshot: Callable[[], Snapshot], store: Store) -> None:
        self._snapshot = snapshot
        self._store = store
        self._files = _pages()
        self._pictures: dict[str, bytes] = {}

    def page(self, path: str) -> Page | None:
        """The page at a path, or None."""
        if path == "/":
            path = "/index.html"
        if path in self._files:
            return self._files[path]
        if path.startswith("/photo/"):
            return self._photo(path)
        return None

    def _photo(self, path: str) -> Page | None:
        case = self._snapshot().case
        if case is None or case.image is None or path != f"/photo/{case.image_hash}.jpg":
            return None
        if path not in self._pictures:
            self._pictures = {path: jpeg_of(case.image)}
        return Page("image/jpeg", self._pictures[path], cache=True)


def jpeg_of(image: Image, quality: int = 90) -> bytes:
    """The picture as JPEG."""
    ok, coded = cv2.imencode(".jpg", image[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert ok
    return coded.tobytes()


@lru_cache(maxsize=1)
def _pages() -> dict[str, Page]:
    """All files of `pages/`, by the path that they are served at."""
    folder = files("physagent_studio.studio") / "pages"
    found = {}
    for item in folder.iterdir():
        kind = TYPES.get("." + item.name.rpartition(".")[2])
        if kind is not None:
            found[f"/{item.name}"] = Page(kind, item.read_bytes())
    return found
