"""Reads English event prompts."""

from physagent_studio.language.frames import EDGES, SLOPE_ENDS, EventFrame, Place, Reading
from physagent_studio.language.hints import SceneHints, hints, seen_by
from physagent_studio.language.reader import read
from physagent_studio.language.reference.names import inventory
from physagent_studio.language.reference.stock import Inventory
