"""The files of OpenCV's model zoo that can be used: where they lie, and what has to be in them."""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

from physagent_studio.assets import data_folder
from physagent_studio.errors import InputError, StudioError

Condition = Literal["absent", "partial", "damaged", "ready"]
"""Of a file: not there, begun to be fetched, there with another content, fine."""
HOME = "https://huggingface.co/opencv"
"""Where the zoo keeps its files: its organisation, a repository a model."""


class ModelFailed(StudioError):
    """A learned model could not be loaded or gave nothing of use; the embedded way goes on."""


@dataclass(frozen=True, slots=True)
class ZooModel:
    """One file. size: bytes. url: its official home. purpose: what it is for, in a few words."""

    name: str
    file: str
    size: int
    sha256: str
    url: str
    purpose: str


ZOO: dict[str, ZooModel] = {
    "efficientsam": ZooModel(
        name="efficientsam",
        file="image_segmentation_efficientsam_ti_2025april.onnx",
        size=48_312_857,
        sha256="4eb496e0a7259d435b49b66faf1754aa45a5c382a34558ddda9a8c6fe5915d77",
        url=f"{HOME}/image_segmentation_efficientsam/resolve/main/"
        "image_segmentation_efficientsam_ti_2025april.onnx",
        purpose="masks from clicks and boxes",
    ),
    "lama": ZooModel(
        name="lama",
        file="inpainting_lama_2025jan.onnx",
        size=92_591_623,
        sha256="7df918ac3921d3daf0aae1d219776cf0dc4e4935f035af81841b40adcf74fdf2",
        url=f"{HOME}/inpainting_lama/resolve/main/inpainting_lama_2025jan.onnx",
        purpose="the background above the horizon",
    ),
}
"""Both under Apache-2.0 in the zoo; sizes and hashes are those that its repository records."""


def model_named(name: str) -> ZooModel:
    """The model of that name. Raises InputError for an unknown one."""
    if name not in ZOO:
        raise InputError(f"there is no model '{name}'; known: {', '.join(ZOO)}")
    return ZOO[name]


def models_folder() -> Path:
    """Where the files are kept, in the user's data folder."""
    return data_folder() / "models"


def path_of(model: ZooModel, folder: Path | None = None) -> Path:
    """The place of a model's file, whether it is there or not."""
    return (folder or models_folder()) / model.file


def part_of(path: Path) -> Path:
    """The place of what has been fetched of a file so far."""
    return path.with_name(path.name + ".part")


def condition(model: ZooModel, folder: Path | None = None) -> Condition:
    """How it stands with a model's file, by its content."""
    path = path_of(model, folder)
    if not path.is_file():
        return "partial" if part_of(path).is_file() else "absent"
    return "ready" if is_sound(model, path) else "damaged"


def is_sound(model: ZooModel, path: Path) -> bool:
    """Whether a file has the model's size and SHA-256."""
    found = path.stat()
    return found.st_size == model.size and _digest(path, found.st_mtime_ns) == model.sha256


def content(model: ZooModel, folder: Path | None = None) -> bytes:
    """What a model's file holds; what is loaded is what was checked, not the file read twice.

    Raises ModelFailed where it cannot be read or is not what it should be.
    """
    path = path_of(model, folder)
    try:
        data = path.read_bytes() if path.stat().st_size == model.size else b""
    except OSError as error:
        raise ModelFailed(f"{path} cannot be read: {error.strerror}") from error
    if hashlib.sha256(data).hexdigest() != model.sha256:
        raise ModelFailed(damaged(model, path))
    return data


def damaged(model: ZooModel, path: Path) -> str:
    """What is told of a file with another content than it should have."""
    return (
        f"{path} is not the file of {model.name} (its SHA-256 is another) and is not used;"
        f" `physagent models fetch {model.name}` replaces it"
    )


@lru_cache(maxsize=16)
def _digest(path: Path, modified: int) -> str:
    """SHA-256 of a file. modified: when it was written, ns; another one is read anew."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
