"""Durable sessions: the history of rounds and decisions in SQLite, arrays in files beside it."""

from physagent_studio.session.files import FileStore
from physagent_studio.session.session import Session
from physagent_studio.session.store import SessionInfo, Store

__all__ = ["FileStore", "Session", "SessionInfo", "Store"]
