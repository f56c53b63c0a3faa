"""Where the files that ship with the package lie."""

from importlib.resources import files
from pathlib import Path

from physagent_studio.errors import StudioError


def assets_dir() -> Path:
    """The folder of bundled cases, programs and pictures.

    A wheel carries it inside the package, a checkout has it beside the package.

    Raises:
        StudioError: neither place has it, so the installation is incomplete.
    """
    package = Path(str(files("physagent_studio")))
    places = (package / "assets", package.parent / "assets")
    for place in places:
        if place.is_dir():
            return place
    raise StudioError(f"the bundled assets are missing: looked in {places[0]} and {places[1]}")
