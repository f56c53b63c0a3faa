"""Fixtures for every room."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from physagent_studio.program import SceneState
    from physagent_studio.records import Case, Scene
    from physagent_studio.records.case import Image

# Before NumPy and OpenCV are imported: several processes of tests use the cores as it is, and
# threads that wait for each other cost processor time; results have the same bits.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")

ROOT = Path(__file__).resolve().parent.parent


LONG = ("browser", "agent", "workbench", "reconstruction", "benchmark", "studio", "cli")
"""Rooms whose tests take longest, longest first: two processes then end at the same time."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long rooms first."""

    def rank(item: pytest.Item) -> int:
        room = item.path.relative_to(ROOT / "tests").parts[0]
        return LONG.index(room) if room in LONG else len(LONG)

    items.sort(key=rank)


@pytest.fixture(autouse=True)
def _own_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test writes into the data folder of the person who runs it."""
    monkeypatch.setenv("PHYSAGENT_HOME", str(tmp_path / "physagent-home"))


@pytest.fixture(scope="session")
def repository() -> Path:
    """The checkout that the tests run from."""
    return ROOT


@pytest.fixture(scope="session")
def cases_dir() -> Path:
    """The folder of real photographs, which lies beside the checkout where there is one."""
    folder = ROOT.parent / "shared" / "cases"
    if not folder.is_dir():
        pytest.skip(f"the real photographs are not here ({folder})")
    return folder


@pytest.fixture(scope="session")
def prepared(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """A folder for what is made once for several processes of tests."""
    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / "prepared"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="module")
def shared_scenes(prepared: Path) -> Iterator[None]:
    """The examples' photographs are reconstructed once, for tests of what comes after that.

    Only what begins with no earlier scene is kept. Not for tests that change how a reconstruction
    is made, or hold one against another.
    """
    from physagent_studio import reconstruction
    from physagent_studio.session.arrays import pack_scene, unpack_scene

    made: Callable[..., Scene] = reconstruction.reconstruct

    def shared(case: Case, state: SceneState, **words: Any) -> Scene:
        if words.get("previous") is not None or words.get("assets"):
            return made(case, state, **words)
        file = prepared / reconstruction.scene_hash(case, state, words["learned"].key)
        if not file.exists():
            partial = prepared / f"{file.name}-{os.getpid()}"
            partial.write_bytes(pack_scene(made(case, state, **words)))
            partial.rename(file)
        return unpack_scene(file.read_bytes(), case.image)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reconstruction, "reconstruct", shared)
        yield


@contextmanager
def photo_left_as_it_is() -> Iterator[None]:
    """Behind things that leave, the photo stays: what to fill with what is half of a small scene.

    Only where nobody looks at the background, and not beside `shared_scenes`.
    """
    from physagent_studio.reconstruction.background import scene_plate

    def as_it_is(photo: Image, *_: object, **_by_name: object) -> Image:
        return photo.copy()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene_plate, "background", as_it_is)
        yield


@pytest.fixture(scope="module")
def unfilled() -> Iterator[None]:
    """`photo_left_as_it_is` for all tests of a file."""
    with photo_left_as_it_is():
        yield


@pytest.fixture
def unfilled_here() -> Iterator[None]:
    """`photo_left_as_it_is` for one test of a file whose others look at the background."""
    with photo_left_as_it_is():
        yield


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the Chromium for the browser tests."""
    from tests.run_all import find_browser

    path = find_browser()
    if path is None:
        pytest.skip("no Chromium here; `python3 launch.py test` installs one")
    return path
