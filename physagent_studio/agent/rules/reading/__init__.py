"""Reads English event prompts."""

from physagent_studio.agent.rules.reading.frames import EventFrame, Place, ReadClause, Reading
from physagent_studio.agent.rules.reading.names import Inventory, inventory
from physagent_studio.agent.rules.reading.reader import read

__all__ = ["EventFrame", "Inventory", "Place", "ReadClause", "Reading", "inventory", "read"]
