"""How a clip is shown when it leaves."""

from dataclasses import dataclass
from typing import Literal

from physagent_studio.errors import InputError

Way = Literal["crop", "letterbox"]
"""How another size is got to: by cutting off what is too much, or with bars beside the picture."""


@dataclass(frozen=True, slots=True)
class ClipLook:
    """size: (width, height), None for the photo's own. way: how it is got to. shutter: the share
    of the time to the next frame over which what moves is blurred, 0 … 1. samples: rays for each
    pixel of a clip that is path traced; None where it is drawn.

    Raises:
        InputError: a shutter that is open for longer than a frame.
    """

    size: tuple[int, int] | None = None
    way: Way = "crop"
    shutter: float = 0.0
    samples: int | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.shutter <= 1:
            raise InputError(f"a shutter of {self.shutter:g} is none: 0 to 1 of a frame")


AS_DRAWN = ClipLook()
"""In the photo's own size, without blur."""
