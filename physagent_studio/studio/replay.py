"""Files to take away: the session as one HTML page, and the scene as a recording."""

import base64
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from physagent_studio import __version__
from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange import Replay, ReplayCheck, ReplayRound, replay_html
from physagent_studio.jobs import hearing
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import dump_program
from physagent_studio.program.timing import pace_in_words, timing_of
from physagent_studio.records import Case, Rollout, Round, Scene
from physagent_studio.studio.guard import open_server, stop_server
from physagent_studio.studio.panels.checklist import checklist_of
from physagent_studio.studio.panels.rounds import OUTCOMES, decided_words, is_gentler, verdict_of
from physagent_studio.studio.panels.words import speaker
from physagent_studio.studio.scene.cameras import Pose, add_backdrop, pose_of
from physagent_studio.studio.scene.stage import Hands, Stage
from physagent_studio.studio.site import jpeg_of
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot, tasks
from physagent_studio.workbench.desk import Desk

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


MOST_ROUNDS = 12
"""The newest rounds of the path go into a replay; each is about a megabyte."""


def recording_of(desk: Desk) -> bytes:
    """What is on view, in motion, as a `.viser` file."""
    scene, rollout, _ = desk.on_view()
    return _recorded(desk, desk.program, scene, rollout, paged=False).data


def replay_of(desk: Desk) -> bytes:
    """The session's path of rounds as one HTML file.

    Raises:
        InputError: nothing has run. Cancelled: the person has cancelled.
    """
    path = [one for one in desk.state.path() if one.assessment is not None][-MOST_ROUNDS:]
    if not path:
        raise InputError("no round has run yet, so there is nothing to replay")
    made, viewer = [], None
    for number, item in enumerate(path):
        desk.control.progress("writing the replay", number / len(path))
        one, recording = _round_of(desk, item)
        made.append(one)
        viewer = recording.page if recording else viewer
    program, image = path[-1].program, desk.case.image
    camera = program.scene.camera
    replay = Replay(
        title=desk.session.title,
        prompt=program.event.prompt,
        outcome=OUTCOMES[desk.state.outcome],
        rounds=tuple(made),
        fps=program.clip.playback_fps,
        frames=program.clip.frames,
        size=(832, 480) if camera is None else camera.size,
        photo=b"" if image is None else jpeg_of(image, 88),
        viewer=viewer,
        version=f"Made with PhysAgent Studio {__version__}",
    )
    return replay_html(replay).encode("utf-8")


def _round_of(desk: Desk, item: Round) -> tuple[ReplayRound, Recording | None]:
    assert item.assessment is not None
    speak = speaker(item.program)
    one = ReplayRound(
        number=item.number,
        verdict=verdict_of(item),
        program=dump_program(item.program),
        checks=tuple(
            ReplayCheck(
                ok=row["ok"], clause=row["clause"], text=speak(row["text"]),
                measured=row["measured"], frame=row["frame"], always=row["always"],
                group=row["group"],
            )
            for row in checklist_of(item.assessment.checks, item.program)
            if not row["folded"]
        ),
        diagnosis=tuple(speak(one.text) for one in item.assessment.diagnosis),
        proposal=speak(item.proposal.rationale) if item.proposal else "",
        changes=tuple(speak(one.summary) for one in item.proposal.hunks) if item.proposal else (),
        decided=_decided(item),
        gentler=is_gentler(item.proposal),
        pace=pace_in_words(item.program.clip.time_factor),
        timing=timing_of(item.program.clip),
    )  # fmt: skip
    if item.scene is None or item.rollout is None:
        return one, None
    scene, rollout = desk.session.scene(item.scene), desk.session.rollout(item.rollout)
    recording = _recorded(desk, item.program, scene, rollout, paged=True)
    video = _video(desk, scene, rollout, item.program)
    return replace(one, video=video, recording=recording.data), recording


def _recorded(
    desk: Desk,
    program: PhysicalProgram,
    scene: Scene | None,
    rollout: Rollout | None,
    *,
    paged: bool,
) -> Recording:
    values = (desk.case, program, scene, rollout, paged)
    return desk.engine.carry_out("the recording", tasks.RENDERING, recorded, *values)


def _video(desk: Desk, scene: Scene, rollout: Rollout, program: PhysicalProgram) -> bytes:
    if scene.state.camera is None:
        return b""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        desk.engine.film(path, scene, rollout, program)
        return path.read_bytes()


def _decided(item: Round) -> str:
    decision = item.decision
    if decision is None:
        return ""
    words = f"{decided_words(item)} by {decision.author}"
    return f"{words}: {decision.reason}" if decision.reason else words
