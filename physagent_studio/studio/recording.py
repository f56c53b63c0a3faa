"""The scene of a round in motion, as a `.viser` recording and as a page that plays one."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.jobs import hearing
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, Rollout, Scene
from physagent_studio.studio.guard import open_server, stop_server
from physagent_studio.studio.scene.cameras import Pose, add_backdrop, pose_of
from physagent_studio.studio.scene.stage import Hands, Stage
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot

SHOWN = frozenset({"photo", "supports", "trails", "labels"})
EMBED = 'window.__VISER_EMBED_DATA__="'
"""Where viser's standalone page holds its recording, in base64 up to the next quote."""

DRESSES = """<script>%s;(() => { let inner; Object.defineProperty(window, "__viserMutable", {
configurable: true, get: () => inner, set(state) { inner = state;
state.scene.onBeforeRender = () => window.studioDress(state.nodeRefFromName); } }); })()</script>"""
"""Has viser's standalone page put the photo on what deforms, like the studio's own."""

QUIET = "<style>.mantine-Notifications-root{display:none!important}</style></head>"


@dataclass(frozen=True, slots=True)
class Recording:
    """data: a `.viser` file. page: viser's own page around it, cut where the base64 goes in."""

    data: bytes
    page: tuple[str, str]


def record(
    snapshot: Snapshot, cancelled: Callable[[], bool] = lambda: False, *, paged: bool = False
) -> Recording:
    """The round on view of a snapshot, frame by frame at the clip's playback speed.

    paged: it is for the page that comes with it, which puts the photo on what deforms; other
    players of a `.viser` file show that in its main colours.

    A server of viser's holds the scene meanwhile: on this machine, behind the guard, nobody in it.

    Raises:
        InputError: nothing has run. Cancelled: `cancelled` said so.
    """
    rollout = snapshot.rollout
    if rollout is None:
        raise InputError("nothing was simulated yet, so there is nothing to record")
    server = open_server(0, lambda _path: None, _nobody)
    try:
        stage = Stage(server, Hands(_nothing, _nothing, _nothing, _nothing), dressed=paged)
        clip = snapshot.program.clip
        view = View(shown=SHOWN)
        _look(server.initial_camera, pose_of(snapshot.program, "photo", _aspect(snapshot)))
        camera, scene = snapshot.program.scene.camera, snapshot.scene
        if camera is not None and scene is not None and scene.plate is not None:
            add_backdrop(server.scene, snapshot.program, camera, scene.plate)
        stage.draw(snapshot, view, None)
        serializer = server.get_scene_serializer()
        for frame in range(clip.frames):
            if cancelled():
                raise Cancelled("cancelled")
            stage.pose(snapshot, view.at_frame(frame, clip))
            serializer.insert_sleep(1 / clip.playback_fps)
        return _packed(serializer.as_html())
    finally:
        stop_server(server)


def recorded(
    case: Case, program: PhysicalProgram, scene: Scene | None, rollout: Rollout | None, paged: bool
) -> Recording:
    """`record` as a task of `jobs`: a server in the process that carries it out."""
    shown = Snapshot(revision=0, case=case, program=program, scene=scene, rollout=rollout)
    return record(shown, hearing()[0], paged=paged)


def _packed(page: str) -> Recording:
    before, found, rest = page.partition(EMBED)
    text, _, after = rest.partition('"')
    if not found:
        raise InputError("this version of viser makes no standalone page that is understood here")
    before = before.replace("<head>", "<head>" + _dressing(), 1)
    after = after.replace("</head>", QUIET, 1)
    return Recording(base64.b64decode(text), (before + EMBED, '"' + after))


def _dressing() -> str:
    script = files("physagent_studio.studio") / "pages" / "dressing.js"
    return DRESSES.replace("%s", script.read_text("utf-8"), 1)


def _look(camera: object, pose: Pose) -> None:
    for name, value in (
        ("position", pose.eye), ("look_at", pose.target), ("up", pose.up), ("fov", pose.fov)
    ):  # fmt: skip
        setattr(camera, name, float(value) if np.ndim(value) == 0 else value)


def _aspect(snapshot: Snapshot) -> float:
    camera = snapshot.program.scene.camera
    return 16 / 9 if camera is None else camera.size[0] / camera.size[1]


def _nothing(*_args: object) -> None:
    """Nobody clicks in a recording."""


async def _nobody(_connection: object, _role: object) -> None:
    """Nobody speaks with the server of a recording."""
