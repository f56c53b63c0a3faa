"""The one boundary where any failure becomes a sentence that a person is shown."""

import logging
from collections.abc import Callable
from typing import TypeVar

from physagent_studio.errors import StudioError

log = logging.getLogger(__name__)
Result = TypeVar("Result")


def guarded(
    act: Callable[[], Result], failed: Callable[[str], Result], what: str = "an act"
) -> Result:
    """What `act` gives, or what `failed` makes of the sentence that says why not.

    what: names the act in the log, which gets the traceback of what is no `StudioError`.
    """
    try:
        return act()
    except StudioError as error:
        return failed(str(error))
    # Broad on purpose: behind it are threads that serve people, and whatever raises in a library
    # below must neither end them nor go by in silence.
    except Exception as error:
        log.exception("%s failed", what)
        return failed(f"Something went wrong on our side: {error!r}. Nothing is lost.")
