"""Durable sessions: the history of rounds and decisions in SQLite, arrays in files beside it.

`Session.save` writes a state with its rounds (`records.judgement.Round`) before the next phase
begins.
"""

from physagent_studio.session.files import FileStore
from physagent_studio.session.session import Session
from physagent_studio.session.store import SessionInfo, Store
