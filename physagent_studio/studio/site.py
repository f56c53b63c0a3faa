"""What the studio serves over HTTP besides viser: its page, pictures and files of the session."""

import re
import threading
from collections import OrderedDict
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import cv2
import numpy as np

from physagent_studio.errors import InputError, StudioError
from physagent_studio.jobs import Executor, Inline
from physagent_studio.records import Image, Rollout, Round, Scene
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.session import FileStore, Store
from physagent_studio.session.arrays import from_png, unpack_frames, unpack_scene
from physagent_studio.studio.door import Page
from physagent_studio.studio.library import Library, outputs_of
from physagent_studio.workbench import Snapshot, tasks
from physagent_studio.workbench.engine import Engine

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
FRAME = re.compile(r"/frame/([\w-]{1,120})/(\d{1,5})\.jpg")
FACE_PATH = re.compile(r"/face/(session|case)/([\w-]{1,120})\.jpg")
SCENE_FACE_PATH = re.compile(r"/face/scene/([\w-]{1,120})/(\d{1,20})\.jpg")


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
        if match := FACE_PATH.fullmatch(path):
            return _picture(self._face(match[1], match[2]))
        if match := SCENE_FACE_PATH.fullmatch(path):
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


EVERY = 3
"""The verifier is shown x1, x4 … x79 of the paper: every third frame from the first."""
WIDTH = 240
"""Width of a sampled frame on the page, pixels."""
FACE = 112
"""Width of a face in the list of sessions, pixels."""
KEPT = 1500
"""Pictures that stay in memory, some 10 kB each."""


class Pictures:
    """JPEGs by what they show; None where there is nothing to show."""

    def __init__(
        self, snapshot: Callable[[], Snapshot], store: Store, apart: Executor | None = None
    ) -> None:
        """apart: who renders; without one this process does."""
        self._apart = apart or Inline()
        self._snapshot = snapshot
        self._store = store
        self._made: OrderedDict[str, bytes] = OrderedDict()
        self._lock = threading.Lock()
        self._drawing: tuple[str, Scene, Rollout] | None = None
        self._stopped = False

    def stop(self) -> None:
        """Makes nothing more: whoever still waits for a frame gets none, so the server may end."""
        self._stopped = True

    def frame(self, tag: str, number: int) -> bytes | None:
        """Frame `number` of the round of the open session that `tag_of` gave that tag."""
        with self._lock:
            key = f"{tag}/{number}"
            if key not in self._made and (self._stopped or not self._make_frames(tag, number)):
                return None
            return self._get(key)

    def face(self, session_id: str) -> bytes | None:
        """The photo that a session began with."""
        with self._lock:
            key = f"session {session_id}"
            if key not in self._made:
                try:
                    data = self._store.photo(session_id)
                except StudioError:
                    return None
                if data is None:
                    return None
                self._keep(key, from_png(data), FACE)
            return self._get(key)

    def scene(self, session_id: str, stamp: str) -> bytes | None:
        """How the scene of a session without a photo begins; stamp: of its last change."""
        with self._lock:
            key = f"scene {session_id} {stamp}"
            if key not in self._made:
                picture = self._scene_of(session_id)
                if picture is None:
                    return None
                self._keep(key, picture, FACE)
            return self._get(key)

    def _scene_of(self, session_id: str) -> Image | None:
        if session_id not in self._store:
            return None
        try:
            session = self._store.open(session_id, writing=False)
        except StudioError:
            return None
        try:
            state = session.load()
            program = state.draft or (state.current.program if state.current else None)
            if program is None or not program.scene.objects:
                return None
            engine = Engine(session, session.case, executor=self._apart)
            return engine.view(engine.reconstruct(program.scene, None))
        except StudioError:
            return None
        finally:
            session.close()

    def example(self, path: Path) -> bytes | None:
        """The photo of a bundled case."""
        with self._lock:
            key = f"example {path}"
            if key not in self._made:
                picture = cv2.imread(str(path), cv2.IMREAD_REDUCED_COLOR_4)
                if picture is None:
                    return None
                self._keep(key, np.asarray(picture[:, :, ::-1], np.uint8), FACE)
            return self._get(key)

    # --- making, under the lock ----------------------------------------------------------------

    def _get(self, key: str) -> bytes | None:
        if key in self._made:
            self._made.move_to_end(key)
        return self._made.get(key)

    def _keep(self, key: str, picture: Image, width: int) -> None:
        rows = max(1, round(picture.shape[0] * width / picture.shape[1]))
        small = cv2.resize(picture, (width, rows), interpolation=cv2.INTER_AREA)
        self._made[key] = jpeg_of(np.asarray(small, np.uint8), 82)
        while len(self._made) > KEPT:
            self._made.popitem(last=False)

    def _make_frames(self, tag: str, number: int) -> bool:
        snapshot = self._snapshot()
        key = tag.rpartition("-")[0]
        item = next((one for one in snapshot.state.rounds if one.id == key), None)
        if item is not None and tag_of(item) != tag:
            return False
        inside = item is not None and number in range(0, item.program.clip.frames, EVERY)
        if item is None or not inside or snapshot.session_id is None:
            return False
        try:
            if item.frames and self._unpack(tag, snapshot.session_id, item.frames):
                return f"{tag}/{number}" in self._made
            return self._draw(tag, number, snapshot, item)
        except StudioError:
            return False

    def _unpack(self, tag: str, session_id: str, key: str) -> bool:
        """What the verifier was shown, as the session keeps it."""
        frames = unpack_frames(self._files(session_id).get(key))
        for index, picture in enumerate(frames):
            self._keep(f"{tag}/{index * EVERY}", picture, WIDTH)
        return bool(frames)

    def _draw(self, tag: str, number: int, snapshot: Snapshot, item: Round) -> bool:
        """A frame that no verifier asked for, rendered now."""
        if self._drawing is None or self._drawing[0] != tag:
            if item.scene is None or item.rollout is None or snapshot.session_id is None:
                return False
            files = self._files(snapshot.session_id)
            image = snapshot.case.image if snapshot.case else None
            scene = unpack_scene(files.get(item.scene), image)
            rollout = rollout_from_bytes(files.get(item.rollout))
            self._drawing = (tag, scene, rollout)
        values = (*self._drawing[1:], number)
        picture = self._apart.submit(tasks.framed, *values, limits=tasks.RENDERING)
        self._keep(f"{tag}/{number}", picture, WIDTH)
        return True

    def _files(self, session_id: str) -> FileStore:
        if session_id not in self._store:
            raise InputError(f"there is no session '{session_id}'")
        return FileStore(self._store.root / "sessions" / session_id / "files")


def tag_of(item: Round) -> str:
    """Names the frames of a round in addresses; another run of it gets another tag."""
    return f"{item.id}-{(item.frames or item.rollout or '')[:16]}"


def strip_of(item: Round) -> dict[str, object] | None:
    """The sampled frames of a round and where they are; None where nothing can be shown."""
    if item.rollout is None or item.program.scene.camera is None:
        return None
    frames = list(range(0, item.program.clip.frames, EVERY))
    size = list(item.program.scene.camera.size)
    return {"at": f"frame/{tag_of(item)}/", "frames": frames, "size": size}


def jpeg_of(image: Image, quality: int = 90) -> bytes:
    """The picture (RGB) as JPEG."""
    ok, coded = cv2.imencode(".jpg", image[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert ok
    return coded.tobytes()
