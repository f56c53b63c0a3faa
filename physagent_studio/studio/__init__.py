"""The studio: a view over snapshots and a sender of commands, in the browser.

A click on a page (`pages/*.js`, sent by `wire.js`) arrives as an intent (`intents`), becomes
edits or a command (`commands`, `workbench.photo_edits`), and comes back as state for the
`panels`.
"""

from physagent_studio.studio.studio import Studio, serve

__all__ = ["Studio", "serve"]
