"""Reads English event prompts."""

from physagent_studio.agent.rules.reading.frames import EventFrame, Place, ReadClause, Reading
from physagent_studio.agent.rules.reading.names import inventory
from physagent_studio.agent.rules.reading.reader import read
from physagent_studio.agent.rules.reading.stock import Inventory

__all__ = ["EventFrame", "Inventory", "Place", "ReadClause", "Reading", "inventory", "read"]
