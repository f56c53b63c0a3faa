"""The studio: one thread between browsers and the workbench.

Browsers send intents and the workbench sends snapshots; both land in one queue. This thread takes
them off, turns intents into commands or into changes of the view, and draws: panels as JSON over
the hub, the scene through viser. Nothing else touches any of these, so no callback can race.
"""

import queue
import socket
import threading
import time
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import viser
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import InputError
from physagent_studio.jobs import Executor, Inline, shared
from physagent_studio.program import Edit
from physagent_studio.studio.access import Access
from physagent_studio.studio.commands import program, read_letter
from physagent_studio.studio.commands.mesh import MeshDesk
from physagent_studio.studio.commands.photo import Sketches
from physagent_studio.studio.first_scene import Act, Waiting
from physagent_studio.studio.guard import close_client, open_server, stop_server, token_of
from physagent_studio.studio.hub import Hub
from physagent_studio.studio.library import Archive, Library
from physagent_studio.studio.painter import Painter
from physagent_studio.studio.panels.words import without_paths
from physagent_studio.studio.photo_desk import DeskApart, Finder
from physagent_studio.studio.scene.stage import Hands
from physagent_studio.studio.site import Site
from physagent_studio.studio.view import Selection, View, advance
from physagent_studio.workbench import Snapshot, Workbench
from physagent_studio.workbench.boundary import guarded
from physagent_studio.workbench.snapshot import differ_by_attempt
from physagent_studio.workbench.versions import Sender, sent_by

TICK = 1 / 31
"""Seconds between two frames of playback: thirty a second, and one to spare."""


Offer = tuple[str, dict[str, Any]]
"""What a notice offers: the words on its button, and the message that it sends."""


@dataclass(frozen=True, eq=False, slots=True)
class _Heard:
    browser: int
    text: str


@dataclass(frozen=True, eq=False, slots=True)
class _Call:
    """Something to do on the studio's thread."""

    act: Callable[[], None]
    hand: int | None = None
    ends: bool = False


class Studio:
    """A running studio. `address` is where it is; `stop` ends it, the workbench stays."""

    def __init__(
        self,
        workbench: Workbench,
        port: int | socket.socket | None = None,
        access: Access | None = None,
        apart: Executor | None = None,
    ) -> None:
        """apart: who looks for masks and draws small pictures; without one this process does."""
        self.workbench = workbench
        self.access = access or Access()
        self.view = View()
        self.snapshot: Snapshot = workbench.snapshot()
        self.tokens: dict[int, str] = {}
        self.presenting: set[int] = set()
        self._viewers: dict[str, int] = {}
        self._grasped: dict[int, int] = {}
        self.library = Library(workbench.store)
        self._inbox: queue.Queue[_Heard | _Call | Snapshot | None] = queue.Queue()
        self.hub = Hub(
            self._heard,
            lambda _count: self.later(self._let_go),
            lambda browser: self.later(lambda: self._forget(browser)),
            workbench.backlog.full,
        )
        self.finder = Finder(self.hub.tell)
        self.apart = apart or Inline()
        self.photo_desk = DeskApart(self.apart)
        self.mesh_desk = MeshDesk()
        self.sketches = Sketches(self.apart)
        self._waiting = Waiting()
        self._site = Site(workbench.snapshot, workbench.store, self.library, self.apart)
        self._server = open_server(port, self._site.page, self.hub.talk, self.access)
        hands = Hands(self._picked, self._edited, self._wished, self.later)
        self.painter = Painter(self._server, self.hub, Archive(workbench.store), hands)
        self._server.on_client_connect(self._came)
        self._server.on_client_disconnect(self._went)
        self._thread = threading.Thread(target=self._work, name="studio", daemon=True)
        self._thread.start()
        self._unsubscribe = workbench.subscribe(self._inbox.put)

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return self.access.link(self._server.get_port())

    def stop(self) -> None:
        """Ends serving; what the workbench holds is untouched."""
        self._unsubscribe()
        self._inbox.put(None)
        self._thread.join(timeout=5)
        self.finder.stop()
        self._site.stop()
        stop_server(self._server)

    # --- from other threads: only enqueue ------------------------------------------------------

    def _heard(self, browser: int, text: str) -> None:
        self._inbox.put(_Heard(browser, text))

    def _picked(self, kind: str, name: str) -> None:
        self._inbox.put(_Call(lambda: self.select(kind, name)))

    def _edited(self, edits: tuple[Edit, ...], reason: str, ends: bool) -> None:
        """Something was dragged in the scene; called on the studio's thread."""
        if not ends:
            self.workbench.try_out(edits or None)
        elif edits:
            self._guarded(None, lambda: program.change(self, -1, edits, reason))
        else:
            self.workbench.try_out(None)

    def _wished(self, name: str, position: FloatArray, ends: bool) -> None:
        """A thing was dragged to where it should be now; called on the studio's thread."""
        if ends:
            x, y, z = (float(f"{part:.4g}") for part in position)
            self._guarded(None, lambda: program.wish(self, -1, name, (x, y, z)))

    def _let_go(self) -> None:
        """A tab that is closed in the middle of a drag ends what it tried."""
        if self.snapshot.attempt is not None:
            self.workbench.try_out(None)

    def _forget(self, browser: int) -> None:
        """Nothing is kept of a browser that has gone."""
        self.tokens.pop(browser, None)
        self.presenting.discard(browser)
        self.mesh_desk.forget(browser)

    def later(self, act: Callable[[], None], hand: int | None = None, ends: bool = False) -> None:
        self._inbox.put(_Call(act, hand, ends))

    def _sender(self, call: _Call) -> Sender:
        """A hand in the scene has seen what was there when it took hold."""
        if call.hand is None:
            return Sender()
        seen = self._grasped.setdefault(call.hand, self.snapshot.version)
        if call.ends:
            del self._grasped[call.hand]
        token = next((key for key, number in self._viewers.items() if number == call.hand), "")
        browser = next((one for one, own in self.tokens.items() if own == token), None)
        return Sender(browser, seen, lambda text: self.say(browser, "error", text))

    def _came(self, client: viser.ClientHandle) -> None:
        close_client(client)
        cameras = self.painter.cameras
        client.camera.on_update(
            lambda _camera: self._inbox.put(_Call(lambda: cameras.moved(client.client_id)))
        )
        token = token_of(self._server, client)

        def arrive() -> None:
            self._viewers[token] = client.client_id
            cameras.add(client)

        self._inbox.put(_Call(arrive))

    def _went(self, client: viser.ClientHandle) -> None:
        def leave() -> None:
            self.painter.cameras.remove(client.client_id)
            self._grasped.pop(client.client_id, None)
            gone = [key for key, number in self._viewers.items() if number == client.client_id]
            for key in gone:
                del self._viewers[key]

        self._inbox.put(_Call(leave))

    # --- the studio's thread -------------------------------------------------------------------

    def _work(self) -> None:
        moment, rest, due = time.monotonic(), 0.0, 0.0
        self.painter.paint(self.snapshot, self.view)
        while True:
            batch = self._take(max(due - time.monotonic(), 0.0) if self.view.playing else None)
            if None in batch:
                return
            now = time.monotonic()
            if self.view.playing and now >= due:
                # Drawing takes its time too: the next frame is due a tick after this one was.
                due = max(due + TICK, now)
                rest = self._tick(now - moment + rest)
                moment = now
            elif not self.view.playing:
                moment, due = now, now + TICK
            self._handle([item for item in batch if item is not None])

    def _take(self, patience: float | None) -> list[_Heard | _Call | Snapshot | None]:
        """Everything that has arrived, waiting for the first of it."""
        batch: list[_Heard | _Call | Snapshot | None] = []
        try:
            batch.append(self._inbox.get(timeout=patience))
            while True:
                batch.append(self._inbox.get_nowait())
        except queue.Empty:
            return batch

    def _tick(self, seconds: float) -> float:
        """Moves the playhead; returns the time that was too short for a step."""
        clip = self.snapshot.program.clip
        before = self.view
        pace = before.speed * clip.time_factor / clip.step_seconds
        whole = round(seconds * pace)
        if whole == 0:
            return seconds
        self.set_view(advance(before, clip, seconds))
        return seconds - whole / pace

    def _handle(self, batch: list[_Heard | _Call | Snapshot]) -> None:
        newest = next((item for item in reversed(batch) if isinstance(item, Snapshot)), None)
        if newest is not None:
            self._accept(newest)
        heard = [item for item in batch if isinstance(item, _Heard)]
        for position, item in enumerate(heard):
            later = heard[position + 1 :]
            self._guarded(item.browser, lambda item=item, later=later: self._listen(item, later))
            self.hub.done_with(item.text)
        for item in batch:
            if isinstance(item, _Call):
                with sent_by(self._sender(item)):
                    self._guarded(None, item.act)

    def _guarded(self, browser: int | None, act: Callable[[], None]) -> None:
        """Whatever fails becomes a notice that the person sees."""
        guarded(act, lambda text: self.say(browser, "error", text), "the studio")

    def _listen(self, item: _Heard, later: list[_Heard]) -> None:
        # A burst of scrubs, or of what is tried, comes down to the last one.
        for word in ('"do":"scrub"', '"do":"try"', '"keep":false'):
            if word in item.text and any(word in one.text for one in later):
                return
        asked, seen = read_letter(item.text)
        watches = self.hub.role(item.browser) == "viewer"
        if watches and asked.may != "follow":
            raise InputError("you are here to watch; whoever has the other address changes things")
        if item.browser in self.presenting and asked.may == "change":
            raise InputError("this page presents and changes nothing; Escape ends that")

        def refused(text: str) -> None:
            self.answer(item.browser, asked.ticket, text)
            self.say(item.browser, "error", text)

        with sent_by(Sender(item.browser, seen, refused, len(item.text))):
            asked.carry_out(self, item.browser)

    def _accept(self, snapshot: Snapshot) -> None:
        if snapshot.session_id != self.snapshot.session_id:
            self.view = replace(View(), shown=self.view.shown, speed=self.view.speed)
        fresh = snapshot.rollout is not self.snapshot.rollout
        only_tried = differ_by_attempt(self.snapshot, snapshot)
        self.snapshot = snapshot
        if only_tried:
            self._guarded(None, lambda: self.painter.attempt(snapshot, self.view))
            return
        if fresh and self.view.step > snapshot.program.clip.steps:
            self.view = replace(self.view, step=0)
        self._guarded(None, self.repaint)
        for act in self._waiting.due(snapshot):
            self._guarded(None, act)

    def repaint(self) -> None:
        """Draws everything anew from the snapshot and the view."""
        self.painter.paint(self.snapshot, self.view)
        self.painter.publish_library(self.library.listing(self.snapshot))
        self.hub.publish("version", self.snapshot.version)

    # --- for what is asked ---------------------------------------------------------------------

    def set_view(self, view: View) -> None:
        """Takes over a view and draws what it changes."""
        old, self.view = self.view, view
        if (
            (old.shown, old.drawn) != (view.shown, view.drawn)
            or old.selection != view.selection
            or old.compare != view.compare
            or old.hidden != view.hidden
        ):
            self.painter.paint(self.snapshot, view)
        else:
            self.painter.move(self.snapshot, view)

    def select(self, kind: str, name: str) -> None:
        """Selects a thing in all views."""
        self.set_view(replace(self.view, selection=Selection(kind, name)))

    def once_written(self, act: Act) -> None:
        """Does something on this thread once the session's first program is there."""
        self._waiting.add(self.snapshot.session_id, act)

    def viewer_of(self, browser: int) -> int:
        """The number of the 3D view in a browser's page; −1 where it is not there yet."""
        return self._viewers.get(self.tokens.get(browser, ""), -1)

    def say(self, browser: int | None, level: str, text: str, offer: Offer | None = None) -> None:
        """A passing notice, to one browser or all, with something to do about it."""
        notice: dict[str, JsonValue] = {"level": level, "text": without_paths(text)}
        if offer is not None:
            notice |= {"offer": offer[0], "do": offer[1]}
        self.hub.tell(browser, "say", notice)

    def tell(self, browser: int, channel: str, value: JsonValue) -> None:
        """Tells one page something that it asked for."""
        self.hub.tell(browser, channel, value)

    def answer(self, browser: int, ticket: int | None, problem: str | None) -> None:
        """Tells a page what became of an edit that it has already drawn."""
        if ticket is not None:
            self.hub.tell(
                browser, "answer", {"ticket": ticket, "problem": problem and without_paths(problem)}
            )


def serve(
    workbench: Workbench,
    access: Access | None = None,
    port: int | socket.socket | None = None,
    open_browser: bool = False,
    apart: Executor | None = None,
) -> Studio:
    """Serves the studio, on loopback unless `access` says more; port None: the next from 8080, or a
    socket that listens already. apart: see `Studio`.

    Raises:
        InputError: a port that is busy, or an address that this machine does not have.
    """
    # The first photo of a stranger shall not wait for the process that decodes it.
    shared().warm("physagent_studio.jobs.decoders")
    studio = Studio(workbench, port, access, apart)
    if open_browser:
        webbrowser.open(studio.address)
    return studio
