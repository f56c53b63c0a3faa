"""What the tests of the roles share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from physagent_studio.agent.vlm import VlmGenerator
from physagent_studio.agent.vlm.line import Line
from physagent_studio.program import PhysicalProgram
from tests.agent.vlm import scripted, world
from tests.agent.vlm.server import Model, ModelServer, says

Serve = Callable[[Model], ModelServer]
Connect = Callable[..., Line]
MAGNITUDE = "event.actions.push.velocity.magnitude"


def replies(*contents: Any) -> Model:
    """A model that says these one after the other, the last one again and again."""
    return lambda asked: says(contents[min(asked.number, len(contents) - 1)])


def program(serve: Serve, connect: Connect, **event: float) -> PhysicalProgram:
    """The first program of a competent model; keywords go to `scripted.event`."""
    server = serve(replies(scripted.scene(), scripted.event(**event)))
    return VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
