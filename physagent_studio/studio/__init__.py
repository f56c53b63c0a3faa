"""The studio: a view over snapshots and a sender of commands, in the browser.

A click on a page (`pages/*.js`, sent by `wire.js`) is read and carried out by `commands`,
becomes edits or a command (`workbench.photo_edits`), and comes back as state for the `panels`.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio, serve

__all__ = ["Studio", "serve"]


def __getattr__(name: str) -> Any:
    """Both are loaded when they are asked for: `access` and `doorway` come without them."""
    if name in __all__:
        from physagent_studio.studio import studio

        return getattr(studio, name)
    raise AttributeError(name)
