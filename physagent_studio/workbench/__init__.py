"""Commands, one worker, current state: what command line, studio and benchmark all drive."""

from physagent_studio.workbench import commands
from physagent_studio.workbench.snapshot import Notice, Snapshot
from physagent_studio.workbench.workbench import Workbench

__all__ = ["Notice", "Snapshot", "Workbench", "commands"]
