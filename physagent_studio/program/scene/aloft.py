"""How a thing is held when the event begins: it stands, hangs, floats, or nothing holds it.

`SceneObject.aloft` and its `support` say it together, and this file is where they are read and
written. A thing that hangs stays where it is until the first action on it begins; one that floats
has no weight; one that nothing holds falls at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from physagent_studio.program.scene.state import SceneObject

AIR = "air"
"""What a thing is said to stand on that stands on nothing."""

Aloft = Literal["hangs", "floats"]
"""What keeps a thing in the air; None for nothing does."""

Carriage = Literal["stands", "hangs", "floats", "falls"]
"""How a thing is held; it falls where it is in the air and nothing keeps it there."""


def carriage_of(item: SceneObject) -> Carriage:
    """How a thing is held when the event begins."""
    if item.aloft is not None:
        return item.aloft
    return "falls" if item.support == AIR else "stands"


def in_air(item: SceneObject) -> bool:
    """Whether a thing stands on nothing when the event begins."""
    return item.support == AIR


def hangs(item: SceneObject) -> bool:
    """Whether something that is not modelled holds it; what is pinned by its body hangs anyway."""
    return item.aloft == "hangs" and getattr(item.body, "pinned", "none") == "none"


def problem_of(item: SceneObject) -> str:
    """What contradicts itself, as "field|message|allowed"; "" where nothing does."""
    if item.aloft is not None and item.support != AIR:
        return f"aloft|what {item.aloft} stands on nothing|support: {AIR}, or no aloft"
    if item.aloft == "floats" and item.body.kind != "rigid":
        return "aloft|only what is rigid floats|hangs, or a rigid body"
    return ""
