"""Where the files that ship with the package lie, and where a person's own are kept."""

import os
from importlib.resources import files
from pathlib import Path

import platformdirs

from physagent_studio.errors import StudioError


def data_folder() -> Path:
    """`$PHYSAGENT_HOME`, else the user's data folder."""
    home = os.environ.get("PHYSAGENT_HOME")
    return Path(home) if home else Path(platformdirs.user_data_dir("physagent", appauthor=False))


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
