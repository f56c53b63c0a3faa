"""`physagent run`: the loop on the command line."""

from __future__ import annotations

import os
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import typer

from physagent_studio.agent.by_hand import in_order, waits_for
from physagent_studio.cli import output
from physagent_studio.cli.clips import render_session
from physagent_studio.cli.early import IMAGES, POLICIES, RunRequest, agent_name, is_session
from physagent_studio.cli.guard import CANCELLED, KEPT, NOT_REALISED, WAITING, say
from physagent_studio.cli.targets import case_of, with_horizon
from physagent_studio.cli.verdict import is_plain, tell
from physagent_studio.errors import Cancelled, InputError
from physagent_studio.exchange import (
    PeerSetup,
    annotated,
    load_peer,
    read_lessons,
)
from physagent_studio.jobs import Processes
from physagent_studio.reconstruction import reduction_of
from physagent_studio.records import Case, Doubt, LoopState
from physagent_studio.session import Session, Store
from physagent_studio.workbench.commands import (
    Advance,
    ApplyEdits,
    SetPolicy,
    Step,
    TakeRole,
)
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.journal import carry_out
from physagent_studio.workbench.report import asked_about, report_of, save_candidates, save_cut_out


def run_loop(request: RunRequest, workspace: Path | None, as_json: bool) -> int:
    """Runs until the loop ends, waits for a person or has to ask; the exit code."""
    started = time.perf_counter()
    session = peer = None
    try:
        peer = load_peer(request.target, request.objects, request.prompt, request.event)
        session = _session(request, Store(workspace), None if peer is None else peer.case)
        if session.read_only:
            raise InputError(f"{session.read_only}; close it there first")
        if not as_json:
            typer.echo(f"session {session.id}")
        desk, asked = _carried_out(request, session, peer, as_json)
        report = report_of(desk.state, session, time.perf_counter() - started)
        if peer is not None:
            report["left_out"] = list(peer.left_out)
    except (Cancelled, KeyboardInterrupt):
        if session is None or not as_json:
            raise
        report = report_of(session.load(), session, time.perf_counter() - started)
        output.print_json(report | {"outcome": "cancelled"})
        say(KEPT)
        return CANCELLED
    finally:
        if session is not None:
            session.close()
    if asked:
        report["pictures"] = [str(save_candidates(desk, doubt.name)) for doubt in asked]
    if as_json:
        output.print_json(report)
    else:
        tell(report, desk.state, asked=bool(asked), verbose=request.verbose)
    _write_pictures(request, desk, workspace, as_json)
    if asked or waits_for(desk.state):
        return WAITING
    return 0 if report["realised"] and is_plain(report) else NOT_REALISED


def _write_pictures(request: RunRequest, desk: Desk, workspace: Path | None, as_json: bool) -> None:
    """Writes the clip and the picture of the masks that were asked for, where there are such."""
    said: list[str] = []
    if request.masks is not None:
        made = save_cut_out(desk, request.masks)
        said.append(f"wrote {request.masks}" if made else "no masks: nothing was reconstructed")
    best = desk.state.best
    if request.out is not None and (best is None or best.rollout is None):
        said.append("no clip: nothing ran")
    elif request.out is not None:
        session = desk.session.id
        said.append(render_session(session, None, request.out, workspace, quiet=as_json))
    for line in said:
        # One JSON value stays one.
        typer.echo(line, err=as_json)


def _carried_out(
    request: RunRequest, session: Session, peer: PeerSetup | None, as_json: bool
) -> tuple[Desk, tuple[Doubt, ...]]:
    """The desk after the loop has gone on as far as it can, and what a person is asked about."""
    policy, agent = POLICIES[request.policy], agent_name(request.agent)
    # Its processes start when a search turns out to be long; one core goes on here.
    with (
        output.progress_control(as_json) as control,
        closing(Processes((os.cpu_count() or 1) - 1, keeping=True)) as spare,
    ):
        desk = Desk(session, control, evidence=request.draws, agent=agent, spare=spare)
        for role in in_order(request.by_hand):
            carry_out(desk, TakeRole(role), "person")
        carry_out(desk, Advance(policy, "simulate"), "person")
        if request.masks is not None:
            # What was cut out is there to be looked at while the search goes on.
            save_cut_out(desk, request.masks)
        if peer is not None and desk.state.phase == "simulate":
            edits = peer.edits_of_scheduled(desk.program)
            carry_out(desk, ApplyEdits(edits, "as the configuration says"), "person")
        asked = () if request.yes else asked_about(desk)
        if peer is not None and not asked and desk.state.draft is not None:
            # The configuration's numbers are a draft, which becomes the next round.
            carry_out(desk, SetPolicy(policy), "person")
            carry_out(desk, Step(), "person")
        elif not asked and desk.state.phase == "simulate":
            carry_out(desk, Advance(policy), "person")
    return desk, asked


def _session(request: RunRequest, store: Store, case: Case | None = None) -> Session:
    if is_session(request.target):
        given = _words_of_a_new_session(request)
        if given:
            raise InputError(
                f"session {request.target} goes on with the event and the marks that it has:"
                f" leave {given[0]} out, or run the case or the picture anew"
            )
        return store.open(request.target)
    chosen = case is not None
    if case is None:
        case = case_of(request.target, request.event, request.prompt, request.objects)
    if request.annotation is not None:
        if Path(request.target).suffix.lower() in IMAGES and reduction_of(request.target) > 1:
            raise InputError(
                f"{request.target} is read at a part of its size, so that the pixels of"
                " --annotation would be others; save it with at most 12 million pixels"
            )
        case = annotated(case, request.annotation)
    case = with_horizon(case, request.target, request.horizon)
    case = replace(case, seconds=request.seconds)
    if request.event is None and not chosen and len(case.events) > 1:
        names = ", ".join(name for name, _ in case.events)
        raise InputError(f"this case has several events; choose one with --event: {names}")
    if not case.prompt.strip():
        raise InputError(
            f"{request.target} has no event; write what shall happen into its case.yaml:"
            " `events: {falls: The ball falls.}`"
        )
    lessons = read_lessons(request.lessons) if request.lessons is not None else ()
    return store.create(case, LoopState(policy="auto", budget=request.rounds, lessons=lessons))


def _words_of_a_new_session(request: RunRequest) -> list[str]:
    """The options given that only a new session can follow."""
    options = {
        "--event": request.event,
        "--prompt": request.prompt,
        "--object": request.objects,
        "--annotation": request.annotation,
        "--horizon": request.horizon,
        "--seconds": request.seconds,
        "--lessons": request.lessons,
    }
    return [option for option, value in options.items() if value not in (None, "", ())]
