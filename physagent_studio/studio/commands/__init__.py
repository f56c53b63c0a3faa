"""Everything that a browser may ask for; importing this knows all of it."""

from physagent_studio.studio.commands import (
    directing,
    looking,
    mesh,
    photo,
    program,
    sessions,
)
from physagent_studio.studio.commands.asking import read_letter
