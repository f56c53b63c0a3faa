"""The painter: panels over the hub and the scene through viser, from a snapshot and a view."""

import time
from typing import Any

import viser

from physagent_studio.program.text.document import dump_program
from physagent_studio.studio.hub import Hub
from physagent_studio.studio.library import Archive, earlier_round, fits, with_ghosts
from physagent_studio.studio.panels import (
    inspector,
    photo,
    plots,
    rounds,
    run,
    scene,
    timeline,
)
from physagent_studio.studio.panels.timeline import Pacings
from physagent_studio.studio.panels.words import without_paths
from physagent_studio.studio.scene.cameras import Cameras
from physagent_studio.studio.scene.places import poses_at
from physagent_studio.studio.scene.stage import Hands, Stage
from physagent_studio.studio.view import View
from physagent_studio.workbench import Notice, Snapshot

FACTS_EVERY = 0.2
"""Seconds between two updates of the measured facts while playing."""


class Painter:
    """Owns what is drawn; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer, hub: Hub, archive: Archive, hands: Hands) -> None:
        self._hub = hub
        self._archive = archive
        self._stage = Stage(server, hands)
        self._pacings = Pacings()
        self.cameras = Cameras()
        self._drawn: dict[str, tuple[object, ...]] = {}
        self._facts_at = 0.0
        self._session: str | None = None

    def paint(self, snapshot: Snapshot, view: View) -> None:
        """Everything; what has not changed costs nothing on the wire.

        The scene first: a hand that has let go waits for the new path, not for a table.
        """
        before = earlier_round(snapshot, view.compare)
        # A round is no comparison for itself.
        other_one = before is not None and before.id != snapshot.shown_round
        compared = before if view.compare and other_one else None
        earlier = self._archive.rollout(snapshot, before) if fits(snapshot, before) else None
        self._stage.draw(with_ghosts(snapshot), view, earlier)
        self._hub.publish("run", run.state_of(snapshot, self._archive.outputs(snapshot)))
        self._hub.publish("rounds", rounds.state_of(snapshot, compared))
        self._hub.publish("notices", [_notice(one) for one in snapshot.notices])
        document = (snapshot.program, snapshot.rollout, snapshot.scene, snapshot.read_only)
        if self._changed("timeline", (*document, snapshot.checks, snapshot.state.pinned)):
            pacing = self._pacings.of(snapshot.program, snapshot.rollout)
            self._hub.publish("timeline", timeline.state_of(snapshot, pacing))
        if self._changed("photo", (*document, snapshot.case)):
            self._hub.publish("photo", photo.state_of(snapshot))
        other = earlier if compared else snapshot.preview_rollout
        if self._changed("plots", (snapshot.rollout, other)):
            self._hub.publish(
                "plots", plots.state_of(snapshot, other, earlier=compared is not None)
            )
        text = (snapshot.session_id, snapshot.program, snapshot.yaml_problems)
        if self._changed("program", (*text, snapshot.read_only, snapshot.has_draft)):
            self._hub.publish("program", text_of(snapshot))
        self._hub.publish("scene", scene.state_of(snapshot, view))
        self._hub.publish("attempt", attempt_of(snapshot))
        with_photo = "photo" in view.shown
        if snapshot.session_id != self._session:
            self._session = snapshot.session_id
            self.cameras.reset()
        self.cameras.set_scene(snapshot.program, snapshot.scene, with_photo)
        self._facts_at = 0.0
        self.move(snapshot, view)

    def move(self, snapshot: Snapshot, view: View) -> None:
        """The playhead alone."""
        self._stage.pose(snapshot, view)
        self._hub.publish("playhead", playhead_of(snapshot, view))
        now = time.monotonic()
        if not view.playing or now - self._facts_at > FACTS_EVERY:
            self._facts_at = now
            self._hub.publish("inspector", inspector.state_of(snapshot, view))
        if view.selection.kind == "object":
            place = poses_at(snapshot, view.step).get(view.selection.name)
            if place is not None:
                self.cameras.follow(place[0])

    def attempt(self, snapshot: Snapshot, view: View) -> None:
        """What would come of the edit under the pointer, alone."""
        self._stage.attempt(snapshot, view)
        self._hub.publish("attempt", attempt_of(snapshot))

    def publish_library(self, value: dict[str, Any]) -> None:
        """The list of cases and sessions."""
        self._hub.publish("library", value)

    def _changed(self, channel: str, key: tuple[object, ...]) -> bool:
        old = self._drawn.get(channel)
        self._drawn[channel] = key
        return old is None or any(a is not b for a, b in zip(old, key, strict=True))


def playhead_of(snapshot: Snapshot, view: View) -> dict[str, Any]:
    """Where the playhead is, and what is selected."""
    clip = snapshot.program.clip
    frame = view.frame(clip)
    return {
        "step": view.step,
        "frame": frame,
        "frames": clip.frames,
        "seconds": round(view.step * clip.step_seconds, 3),
        "video": round(frame / clip.playback_fps, 3),
        "playing": view.playing,
        "speed": view.speed,
        "loop": view.loop,
        "loopStart": view.loop_start,
        "loopEnd": view.loop_end,
        "ready": snapshot.rollout is not None,
        "selection": {"kind": view.selection.kind, "name": view.selection.name},
        "compare": view.compare,
    }


def text_of(snapshot: Snapshot) -> dict[str, Any]:
    """The program's YAML text, its problems at their lines, and whether it may be applied."""
    return {
        "session": snapshot.session_id,
        # Of the program itself; a text that somebody only had checked is not it.
        "text": dump_program(snapshot.program),
        "problems": [
            {"line": one.line, "path": one.path, "message": one.message, "allowed": one.allowed}
            for one in snapshot.yaml_problems
        ],
        "readOnly": snapshot.read_only,
        "draft": snapshot.has_draft,
        "hash": snapshot.program.hash,
    }


def attempt_of(snapshot: Snapshot) -> dict[str, Any] | None:
    """How many demands the edit under the pointer would meet, or why it cannot be."""
    tried = snapshot.attempt
    if tried is None:
        return None
    demanded = [check for check in tried.checks if check.demanded and not check.always_on]
    holding = sum(check.ok for check in demanded)
    return {"problem": without_paths(tried.problem or ""), "holds": holding, "of": len(demanded)}


def _notice(notice: Notice) -> dict[str, Any]:
    return {"id": notice.id, "level": notice.level, "text": without_paths(notice.text)}
