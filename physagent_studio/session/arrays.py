"""Scenes, pictures and cases as bytes: compressed NumPy archives and PNG, never pickles."""

import dataclasses
import io
import json
from functools import cache
from types import MappingProxyType
from typing import Any, get_type_hints

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter
from pydantic_core import to_jsonable_python

from physagent_studio.arrays import BoolArray
from physagent_studio.program import SceneState
from physagent_studio.records import (
    Candidate,
    Case,
    Finding,
    Image,
    LearnedUse,
    Mesh,
    Scene,
    Shading,
    ShapeOffer,
)


def png(image: Image) -> bytes:
    """RGB (H, W, 3) uint8 as a PNG file."""
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def from_png(data: bytes) -> Image:
    """The RGB pixels of a PNG that `png` wrote."""
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8)


def pack(arrays: dict[str, NDArray[Any]], meta: dict[str, Any]) -> bytes:
    """Arrays and JSON-able facts as one compressed archive with reproducible bytes."""
    stream = io.BytesIO()
    text = json.dumps(meta, sort_keys=True)
    np.savez_compressed(stream, __meta__=np.frombuffer(text.encode(), np.uint8), **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def unpack(data: bytes) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """What `pack` packed."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files if key != "__meta__"}
        return arrays, json.loads(archive["__meta__"].tobytes())


def unpack_facts(data: bytes) -> dict[str, Any]:
    """The facts of what `pack` packed, without reading its arrays."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        return json.loads(archive["__meta__"].tobytes())


def pack_frames(frames: tuple[Image, ...]) -> bytes:
    """Pictures as JPEG in one archive: evidence for eyes, so lossy is fine."""
    encoded = {
        f"{index:03d}": cv2.imencode(
            ".jpg", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 88]
        )[1].ravel()
        for index, frame in enumerate(frames)
    }
    return pack(encoded, {"frames": len(frames)})


def unpack_frames(data: bytes) -> tuple[Image, ...]:
    """The pictures of `pack_frames`, RGB."""
    arrays, _ = unpack(data)
    return tuple(from_png(arrays[key].tobytes()) for key in sorted(arrays))


def pack_scene(scene: Scene) -> bytes:
    """A scene with all its arrays; the photo is the case's and is not repeated."""
    arrays: dict[str, NDArray[Any]] = {}
    if scene.plate is not None:
        arrays["plate"] = np.frombuffer(png(scene.plate), np.uint8)
    for name, mask in scene.masks.items():
        arrays[f"mask/{name}"] = np.packbits(mask)
    for room, meshes in (("mesh", scene.meshes), ("support", scene.support_meshes)):
        for name, mesh in meshes.items():
            arrays |= _mesh_arrays(f"{room}/{name}", mesh)
    candidates: dict[str, list[tuple[float, str]]] = {}
    for name, offered in scene.candidates.items():
        candidates[name] = [(item.score, item.method) for item in offered]
        for index, item in enumerate(offered):
            arrays[f"candidate/{name}/{index}"] = np.packbits(item.mask)
    shape = next((list(mask.shape) for mask in scene.masks.values()), None)
    meta = {
        "state": scene.state.model_dump(mode="json"),
        "hash": scene.hash,
        "mask_shape": shape,
        "masks": list(scene.masks),
        "colors": {n: m.color for n, m in (scene.meshes | scene.support_meshes).items()},
        "shadings": {
            f"{room}/{name}": [shading.terms, shading.towards, shading.built]
            for room, meshes in (("mesh", scene.meshes), ("support", scene.support_meshes))
            for name, mesh in meshes.items()
            if (shading := mesh.shading) is not None
        },
        "meshes": list(scene.meshes),
        "support_meshes": list(scene.support_meshes),
        "candidates": candidates,
        "shapes": {
            name: [dataclasses.asdict(one) for one in offers]
            for name, offers in scene.shapes.items()
        },
        "sureness": dict(scene.sureness),
        "findings": [dataclasses.asdict(item) for item in scene.findings],
    }
    if scene.learned:
        meta["learned"] = [dataclasses.asdict(item) for item in scene.learned]
    return pack(arrays, meta)


def unpack_scene(data: bytes, photo: Image | None) -> Scene:
    """The scene of `pack_scene`, with the case's photo put back."""
    arrays, meta = unpack(data)
    shape = tuple(meta["mask_shape"] or (0, 0))

    def mask(key: str) -> BoolArray:
        return np.unpackbits(arrays[key], count=shape[0] * shape[1]).reshape(shape).astype(bool)

    candidates = {
        name: tuple(
            Candidate(mask(f"candidate/{name}/{index}"), score, method)
            for index, (score, method) in enumerate(offered)
        )
        for name, offered in meta["candidates"].items()
    }
    return Scene(
        state=SceneState.model_validate(meta["state"]),
        photo=photo,
        plate=from_png(arrays["plate"].tobytes()) if "plate" in arrays else None,
        masks=MappingProxyType({name: mask(f"mask/{name}") for name in meta["masks"]}),
        meshes=_meshes(arrays, "mesh", meta["meshes"], meta),
        support_meshes=_meshes(arrays, "support", meta["support_meshes"], meta),
        candidates=MappingProxyType(candidates),
        findings=tuple(Finding(**item) for item in meta["findings"]),
        hash=meta["hash"],
        shapes=MappingProxyType(
            {
                name: tuple(ShapeOffer(**one) for one in offers)
                for name, offers in meta.get("shapes", {}).items()
            }
        ),
        sureness=MappingProxyType(meta.get("sureness", {})),
        learned=tuple(
            LearnedUse(item["model"], tuple(item["made"]), item["failed"])
            for item in meta.get("learned", ())
        ),
    )


def pack_mesh(mesh: Mesh) -> bytes:
    """The form of an object, with its texture if it has one; equal forms have equal bytes."""
    arrays = {key[1:]: one for key, one in _mesh_arrays("", mesh).items()}
    return pack(arrays, {"color": mesh.color})


def unpack_mesh(data: bytes) -> Mesh:
    """The mesh of `pack_mesh`."""
    arrays, meta = unpack(data)
    named = {f"/{key}": one for key, one in arrays.items()}
    return _meshes(named, "", [""], {"colors": {"": meta["color"]}})[""]


def _mesh_arrays(key: str, mesh: Mesh) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        f"{key}/vertices": mesh.vertices,
        f"{key}/faces": mesh.faces,
    }
    if mesh.uv is not None and mesh.texture is not None:
        arrays[f"{key}/uv"] = mesh.uv
        arrays[f"{key}/texture"] = np.frombuffer(png(mesh.texture), np.uint8)
    if mesh.shading is not None and mesh.shading.gloss is not None:
        arrays[f"{key}/gloss"] = mesh.shading.gloss
    if mesh.shading is not None and mesh.shading.shade is not None:
        arrays[f"{key}/shade"] = mesh.shading.shade
    if mesh.solid is not None:
        arrays[f"{key}/solid_vertices"], arrays[f"{key}/solid_faces"] = mesh.solid
    return arrays


def _meshes(
    arrays: dict[str, NDArray[Any]], room: str, names: list[str], meta: dict[str, Any]
) -> MappingProxyType[str, Mesh]:
    meshes, colors = {}, meta["colors"]
    for name in names:
        key = f"{room}/{name}" if room else ""
        texture = arrays.get(f"{key}/texture")
        solid = [arrays.get(f"{key}/solid_{part}") for part in ("vertices", "faces")]
        meshes[name] = Mesh(
            vertices=arrays[f"{key}/vertices"],
            faces=arrays[f"{key}/faces"],
            uv=arrays.get(f"{key}/uv"),
            texture=None if texture is None else from_png(texture.tobytes()),
            color=(colors[name][0], colors[name][1], colors[name][2]),
            # Scenes of before have none.
            shading=_shading(arrays, key, meta.get("shadings", {}).get(key)),
            solid=None if solid[0] is None or solid[1] is None else (solid[0], solid[1]),
        )
    return MappingProxyType(meshes)


def _shading(arrays: dict[str, NDArray[Any]], key: str, stored: list[Any] | None) -> Shading | None:
    if stored is None:
        return None
    terms, (x, y, z), (w, i, j, k) = stored
    rows = tuple(tuple(row) for row in terms)
    return Shading(
        rows, (x, y, z), (w, i, j, k), arrays.get(f"{key}/gloss"), arrays.get(f"{key}/shade")
    )


@cache
def _kept_of_case() -> dict[str, TypeAdapter[Any]]:
    """How each field is read but the picture and the focal length that its file states."""
    hints = get_type_hints(Case)
    return {name: TypeAdapter(hints[name]) for name in hints if name not in ("image", "focal")}


def case_json(case: Case) -> dict[str, Any]:
    """Everything of a case but its pixels."""
    stated = {name: getattr(case, name) for name in _kept_of_case()}
    # What older cases do not know is left out where it is not set: they are stored as before.
    return to_jsonable_python({k: v for k, v in stated.items() if k != "seconds" or v is not None})


def case_from_json(data: dict[str, Any], image: Image | None) -> Case:
    """The case of `case_json`; a field that it has not has its default."""
    known = {name: how for name, how in _kept_of_case().items() if name in data}
    return Case(
        image=image, **{name: how.validate_python(data[name]) for name, how in known.items()}
    )
