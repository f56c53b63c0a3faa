"""A thing stands, hangs, floats or falls: what its switch and its ground line do."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from physagent_studio.studio.commands.directing import carry, open_program
from physagent_studio.studio.intents import aloft as asked
from physagent_studio.workbench.aloft_edits import carriage_edits, ground_edits, height_edits

if TYPE_CHECKING:
    from physagent_studio.studio.commands.actions import Studio


def hold(intent: asked.Hold, studio: Studio, browser: int) -> None:
    """Sets how a thing is held when the event begins."""
    pinned = studio.snapshot.state.pinned
    edits = carriage_edits(open_program(studio), pinned, intent.name, intent.how)
    if edits:
        carry(studio, edits, f"{_called(intent.name)} {intent.how}", keep=True)


def ground(intent: asked.Ground, studio: Studio, browser: int) -> None:
    """Puts a thing above a place of the ground, along its line of sight."""
    edits = ground_edits(open_program(studio), intent.name, intent.end)
    carry(studio, edits, f"ground line of {_called(intent.name)}", keep=intent.keep)


def lift(intent: asked.Raise, studio: Studio, browser: int) -> None:
    """Raises or lowers a thing along its line of sight."""
    edits = height_edits(open_program(studio), intent.name, intent.height)
    carry(studio, edits, f"height of {_called(intent.name)}", keep=True)


def _called(name: str) -> str:
    return name.replace("_", " ")


ACTIONS: dict[type, Callable[..., None]] = {
    asked.Hold: hold,
    asked.Ground: ground,
    asked.Raise: lift,
}
"""What each intent does."""
