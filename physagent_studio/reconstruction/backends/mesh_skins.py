"""Textures of mesh files: bounded before they are decoded, and sewn onto what is kept of a mesh."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual.texture import TextureVisuals

from physagent_studio.errors import InputError
from physagent_studio.reconstruction.photo.header import read_header
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class SkinSettings:
    """What the pictures of a mesh file may ask for."""

    max_px: int = 4096 * 4096  # 1e6..1e8: of all pictures of a file together
    max_side_px: int = 2048  # 256..8192: of the texture that is kept, as large as browsers draw
    flat_px: int = 8  # 2..64: across a patch of one colour, so that neighbours do not bleed in
    grey_rgb: tuple[int, int, int] = (160, 160, 160)  # 0..255: of what has no colour


SKIN = SkinSettings()

PICTURES = (".png", ".jpg", ".jpeg")
_PICTURE = ("baseColorTexture", "image")
"""Where materials of glTF and of OBJ files have their colours."""


def glb_document(data: bytes) -> dict[str, Any]:
    """The JSON of a GLB file. Raises what `json` raises."""
    length = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + length])


def check_pictures(data: bytes, name: str, beside: Mapping[str, bytes]) -> None:
    """Refuses pictures that are none or too large, by their headers. Raises InputError."""
    pictures = {key: one for key, one in beside.items() if key.lower().endswith(PICTURES)}
    if name.lower().endswith(".glb"):
        document = glb_document(data)
        views = document.get("bufferViews", [])
        start = 20 + int.from_bytes(data[12:16], "little") + 8
        for number, image in enumerate(document.get("images", [])):
            view = views[image["bufferView"]]
            at = start + int(view.get("byteOffset", 0))
            pictures[f"picture {number} of {name}"] = data[at : at + int(view["byteLength"])]
    headers = [read_header(one, key) for key, one in pictures.items()]
    pixels = sum(one.width * one.height for one in headers)
    if pixels > SKIN.max_px:
        raise InputError(f"{name} has {pixels} pixels of textures; at most {SKIN.max_px} are read")


def skin_of(
    parts: list[trimesh.Trimesh], name: str
) -> tuple[NDArray[np.float64], NDArray[np.uint8]] | None:
    """Pixels (F, 3, 2) of the corners of all faces in one texture, and it (h, w, 3) RGB.

    What has a colour and no picture has a patch of it. None where nothing has either. Raises
    InputError for a picture that cannot be decoded.
    """
    paints = [_paint(part) for part in parts]
    if not any(paint is not None for paint in paints):
        return None
    distinct = {id(paint): paint for paint in paints}
    side = SKIN.max_side_px // math.ceil(math.sqrt(len(distinct)))
    try:
        patches = {key: _patch(paint, side) for key, paint in distinct.items()}
    except (OSError, SyntaxError, ValueError) as error:
        raise InputError(f"a texture of {name} cannot be decoded: {error}") from error
    tops = np.cumsum([0, *(len(patch) for patch in patches.values())])
    texture = np.zeros((tops[-1], max(patch.shape[1] for patch in patches.values()), 3), np.uint8)
    for top, patch in zip(tops, patches.values(), strict=False):
        texture[top : top + len(patch), : patch.shape[1]] = patch
    top_of = dict(zip(patches, tops, strict=False))
    corners = []
    for part, paint in zip(parts, paints, strict=True):
        height, width = patches[id(paint)].shape[:2]
        inside = _inside(part) * (width, height)
        # Half a pixel from the border there is nothing of the neighbour's.
        inside = np.clip(inside, 0.5, np.array([width, height]) - 0.5)
        inside[..., 1] += top_of[id(paint)]
        corners.append(inside)
    return np.concatenate(corners), texture


def _paint(part: trimesh.Trimesh) -> Any:
    """A part's picture, else its colour, RGB; None where it has neither."""
    visual: Any = part.visual
    if isinstance(visual, TextureVisuals):
        material: Any = visual.material
        pictures = (getattr(material, key, None) for key in _PICTURE)
        found = next((one for one in pictures if one is not None), None)
        known = visual.uv is not None and len(visual.uv) == len(part.vertices)
        if found is not None and known:
            return found
        return tuple(int(one) for one in material.main_color[:3])
    if visual.defined:
        return tuple(int(one) for one in np.asarray(visual.vertex_colors)[:, :3].mean(0))
    return None


def _patch(paint: Any, side: int) -> NDArray[np.uint8]:
    """A paint as a picture of at most so many pixels each way."""
    if paint is None or isinstance(paint, tuple):
        return np.full((SKIN.flat_px, SKIN.flat_px, 3), paint or SKIN.grey_rgb, np.uint8)
    paint.thumbnail((side, side))
    return np.asarray(paint.convert("RGB"), np.uint8)


def _inside(part: trimesh.Trimesh) -> NDArray[np.float64]:
    """(F, 3, 2) places of a part's corners in its picture, in shares from the top left corner.

    A face beyond the picture lies in a repetition of it.
    """
    told: Any = getattr(part.visual, "uv", None)
    places = np.full((len(part.vertices), 2), 0.5)
    if told is not None and told.shape == places.shape and np.isfinite(told).all():
        # trimesh counts from below.
        places = np.asarray(told, float) * (1, -1) + (0, 1)
    corners = places[part.faces]
    return corners - np.floor(corners.mean(1, keepdims=True))


def sewn(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
    pixels: NDArray[np.float64],
    texture: NDArray[np.uint8],
) -> Mesh:
    """The mesh with as many vertices at a place as the texture has there.

    pixels: (F, 3, 2) of the faces' corners.
    """
    rows = np.column_stack([faces.ravel(), pixels.reshape(-1, 2)])
    kept, corner = np.unique(rows, axis=0, return_inverse=True)
    places, uv = vertices[kept[:, 0].astype(np.int64)], kept[:, 1:].astype(np.float64)
    return Mesh(places, corner.reshape(-1, 3).astype(np.int32), uv, texture)
