"""The studio: a view over snapshots and a sender of commands, in the browser."""

from physagent_studio.studio.studio import Studio, serve

__all__ = ["Studio", "serve"]
