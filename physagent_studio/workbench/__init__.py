"""Commands, one worker, current state: what command line, studio and benchmark all drive."""

from physagent_studio.workbench import commands
from physagent_studio.workbench.snapshot import Notice, Snapshot, Spending
from physagent_studio.workbench.workbench import Workbench
