"""Puts the three roles together from settings."""

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.vlm.config import Settings, load_settings
from physagent_studio.agent.vlm.generator import VlmGenerator
from physagent_studio.agent.vlm.line import Answers, Line
from physagent_studio.agent.vlm.planner import VlmPlanner
from physagent_studio.agent.vlm.spending import CallLog, CallRecord, Ledger
from physagent_studio.agent.vlm.tape import Tape
from physagent_studio.agent.vlm.verifier import VlmVerifier
from physagent_studio.agent.vlm.wire import check_installed
from physagent_studio.errors import InputError
from physagent_studio.records.loop_state import ROLES, RoleName

Record = Callable[[CallRecord], None]


def crew_from_environment(
    cancelled: Callable[[], bool],
    record: Record | None = None,
    *,
    default: Crew | None = None,
    earlier: Iterable[CallRecord] = (),
    environ: Mapping[str, str] = os.environ,
    answers: Answers | None = None,
) -> Crew:
    """The crew that environment and config file describe.

    cancelled: polled while a call is under way. record: told of every call, with its cost.
    default: plays the roles that `PHYSAGENT_VLM_ROLES` does not name. earlier: what this session
    has recorded so far, so that its limits hold over all of its crews. answers: where answers are
    kept and found again, should their phase be cut short.

    Raises:
        BackendMissing: the `openai` package or the configuration is missing; says what to do.
        InputError: a setting is wrong.
    """
    settings = load_settings(environ)
    if settings.tape is None or settings.tape.mode != "replay":
        check_installed()
    roles = chosen_roles(environ.get("PHYSAGENT_VLM_ROLES", ""))
    missing = [role for role in ROLES if role not in roles]
    if missing and default is None:
        raise InputError(
            f"PHYSAGENT_VLM_ROLES leaves out {', '.join(missing)}, and nobody else is there"
        )
    crew = crew_of(settings, Ledger.of(settings.limits, earlier), cancelled, record, answers)
    if default is None:
        return crew
    return Crew(
        generator=crew.generator if "generator" in roles else default.generator,
        verifier=crew.verifier if "verifier" in roles else default.verifier,
        planner=crew.planner if "planner" in roles else default.planner,
        director=default.director,
    )


def crew_of(
    settings: Settings,
    ledger: Ledger,
    cancelled: Callable[[], bool] = lambda: False,
    record: Record | None = None,
    answers: Answers | None = None,
) -> Crew:
    """All three roles, sharing one ledger."""
    tape = settings.tape
    listeners = [one for one in (record, CallLog(settings.log) if settings.log else None) if one]

    def tell(entry: CallRecord) -> None:
        for listener in listeners:
            listener(entry)

    line = partial(
        Line,
        ledger=ledger,
        cancelled=cancelled,
        record=tell,
        tape=Tape(tape.folder, tape.mode == "replay") if tape else None,
        kept=answers,
    )
    ends = settings.endpoints
    return Crew(
        generator=VlmGenerator(line("generator", ends["generator"])),
        verifier=VlmVerifier(line("verifier", ends["verifier"]), settings.frames),
        planner=VlmPlanner(line("planner", ends["planner"])),
    )


def chosen_roles(text: str) -> tuple[RoleName, ...]:
    """The roles that a list such as "generator,planner" names; all for an empty one."""
    words = [word.strip() for word in text.split(",") if word.strip()]
    strange = [word for word in words if word not in ROLES]
    if strange:
        known = ", ".join(ROLES)
        raise InputError(f"PHYSAGENT_VLM_ROLES: there is no role {', '.join(strange)} ({known})")
    return tuple(role for role in ROLES if role in words) if words else ROLES
