"""Files to take away: the session as one HTML page, and the scene as a recording."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

from physagent_studio import __version__
from physagent_studio.errors import InputError
from physagent_studio.exchange import Replay, ReplayCheck, ReplayRound, replay_html
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import dump_program
from physagent_studio.program.timing import timing_of
from physagent_studio.records import Rollout, Round, Scene
from physagent_studio.studio.panels.checklist import checklist_of
from physagent_studio.studio.panels.pacing import pace_in_words
from physagent_studio.studio.panels.rounds import OUTCOMES, decided_words, is_gentler, verdict_of
from physagent_studio.studio.panels.words import speaker
from physagent_studio.studio.pictures import jpeg_of
from physagent_studio.studio.recording import Recording, recorded
from physagent_studio.workbench import tasks
from physagent_studio.workbench.desk import Desk

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
