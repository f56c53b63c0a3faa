"""What the studio serves over HTTP besides viser: its page, pictures and files of the session."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files

from physagent_studio.jobs import Executor
from physagent_studio.session import Store
from physagent_studio.studio.library import Library, outputs_of
from physagent_studio.studio.pictures import Pictures, jpeg_of
from physagent_studio.studio.responses import Page
from physagent_studio.workbench import Snapshot

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
FRAME = re.compile(r"/frame/([\w-]{1,120})/(\d{1,5})\.jpg")
FACE = re.compile(r"/face/(session|case)/([\w-]{1,120})\.jpg")
SCENE_FACE = re.compile(r"/face/scene/([\w-]{1,120})/(\d{1,20})\.jpg")


class Site:
    """Looks pages up; what `guard.SLOW_PATHS` names comes on other threads than the rest."""

    def __init__(
        self,
        snapshot: Callable[[], Snapshot],
        store: Store,
        library: Library,
        apart: Executor | None = None,
    ) -> None:
        self._snapshot = snapshot
        self._store = store
        self._library = library
        self._files = _pages()
        self._photos: dict[str, bytes] = {}
        self._pictures = Pictures(snapshot, store, apart)

    def stop(self) -> None:
        """Draws nothing more for anybody."""
        self._pictures.stop()

    def page(self, path: str) -> Page | None:
        """The page at a path, or None."""
        if path == "/":
            path = "/index.html"
        if path in self._files:
            return self._files[path]
        if path.startswith("/photo/"):
            return self._photo(path)
        if match := FRAME.fullmatch(path):
            return _picture(self._pictures.frame(match[1], int(match[2])))
        if match := FACE.fullmatch(path):
            return _picture(self._face(match[1], match[2]))
        if match := SCENE_FACE.fullmatch(path):
            return _picture(self._pictures.scene(match[1], match[2]))
        if path.startswith("/file/"):
            return self._output(path.removeprefix("/file/"))
        return None

    def _photo(self, path: str) -> Page | None:
        case = self._snapshot().case
        if case is None or case.image is None or path != f"/photo/{case.image_hash}.jpg":
            return None
        if path not in self._photos:
            self._photos = {path: jpeg_of(case.image)}
        return _picture(self._photos[path])

    def _face(self, kind: str, name: str) -> bytes | None:
        if kind == "session":
            return self._pictures.face(name)
        path = self._library.photo_of(name)
        return None if path is None else self._pictures.example(path)

    def _output(self, name: str) -> Page | None:
        """A video or a replay that was made of the open session."""
        for one in outputs_of(self._store, self._snapshot().session_id):
            if one.path.name == name:
                return Page(one.mime, one.path.read_bytes(), download=name if one.save else "")
        return None


def _picture(data: bytes | None) -> Page | None:
    return None if data is None else Page("image/jpeg", data, cache=True)


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
