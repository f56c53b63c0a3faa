"""Programs of older versions: what has to be done to their data, a version at a time.

Within a version fields are only added, and what a program does not say has its default: so far all
programs that were ever written are of version 1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from physagent_studio.errors import Problem, ProgramError

VERSION = 1
FROM: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""By version: plain data of a program of the next one."""


def brought_up(data: Any, line: int | None = None) -> Any:
    """Plain data of the present version; what is no program of an older one is left as it is.

    line: where its text names the version. Raises ProgramError for a program of a newer version.
    """
    version = data.get("version", VERSION) if isinstance(data, dict) else VERSION
    if type(version) is not int:
        return data
    if version > VERSION:
        message = f"the program is of version {version}, which a newer physagent has written"
        raise ProgramError((Problem("version", message, f"1 … {VERSION}", line),))
    while version < VERSION and version in FROM:
        data = FROM[version](data) | {"version": version + 1}
        version += 1
    return data
