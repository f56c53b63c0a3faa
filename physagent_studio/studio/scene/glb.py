"""A textured mesh as binary glTF whose picture looks on screen as it does in the photo.

The texture is a photograph, light and shade included, so it must not be lit again. viser's viewer
sends every colour through three.js's ACES film curve; the texture is therefore sent through the
inverse of that curve first and drawn unlit (`KHR_materials_unlit`), which leaves the photo's own
colours up to its brightest highlights and costs no light. What is brighter than 1 before the curve
goes into the factor of the texture: glTF would have it in 0 … 1, three.js multiplies by whatever
it is. These files are for the viewer alone.

Source of the curve: three.js r16x, `tonemapping_pars_fragment.glsl`, `ACESFilmicToneMapping`
(Stephen Hill's fit), exposure 1.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.exchange.gltf import INDICES, UNLIT, VERTICES, GltfWriter
from physagent_studio.records import Image, Mesh
from physagent_studio.rendering.light import linear_of, srgb_of
from physagent_studio.rendering.lit import vertex_light

# sRGB to ACES and back; the rows of Hill's fit.
_IN = np.array(
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
)
_OUT = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)  # fmt: skip
_BRIGHTEST = 0.92  # linear; beyond it the inverse grows without bound and 8 bits would band
EXPOSURE = 1 / 0.6


def before_film_curve(image: Image) -> tuple[Image, float]:
    """(h, w, 3) uint8 sRGB → the picture and the strength whose film curve is that image.

    The strength multiplies linear light, so that highlights above 1 fit into 8 bits.
    """
    wanted = np.minimum(linear_of(image.reshape(-1, 3) / 255.0), _BRIGHTEST)
    bent = wanted @ np.linalg.inv(_OUT).T
    # Solves (v² + p·v − q) / (r·v² + s·v + t) = bent for v ≥ 0.
    a = 1 - 0.983729 * bent
    b = 0.0245786 - 0.4329510 * bent
    c = -(0.000090537 + 0.238081 * bent)
    light = (-b + np.sqrt(np.maximum(b * b - 4 * a * c, 0))) / (2 * a)
    light = np.maximum(light @ np.linalg.inv(_IN).T / EXPOSURE, 0)
    strength = max(float(np.quantile(light, 0.999)), 1.0) if light.size else 1.0
    packed = np.clip(srgb_of(np.minimum(light / strength, 1)) * 255 + 0.5, 0, 255)
    return packed.astype(np.uint8).reshape(image.shape), strength


def glb_of(mesh: Mesh, *, quality: int = 92) -> bytes:
    """Binary glTF of a mesh: unlit where it has a texture, lit where it has a colour.

    A texture that is without light gets the photo's by its vertices, as it was built.
    """
    gltf = GltfWriter()
    attributes = {
        "POSITION": gltf.add_array(mesh.vertices.astype(np.float32), VERTICES),
        "NORMAL": gltf.add_array(_normals(mesh), VERTICES),
    }
    indices = gltf.add_array(mesh.faces.astype(np.uint32).ravel(), INDICES)
    if mesh.texture is not None and mesh.uv is not None:
        height, width = mesh.texture.shape[:2]
        uv = (mesh.uv / (width, height)).astype(np.float32)
        attributes["TEXCOORD_0"] = gltf.add_array(uv, VERTICES)
        picture, strength = before_film_curve(mesh.texture)
        ok, coded = cv2.imencode(".jpg", picture[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        assert ok
        view = gltf.add_bytes(coded.tobytes())
        source = gltf.add("images", {"bufferView": view, "mimeType": "image/jpeg"})
        gltf.add("textures", {"source": source})
        light = vertex_light(mesh)
        if light is not None:
            # Colours of vertices multiply linear light: near to what the curve makes of it.
            attributes["COLOR_0"] = gltf.add_array((light**2.2).astype(np.float32), VERTICES)
        gltf.extension(UNLIT)
        material = _unlit(strength)
    else:
        material = _lit(mesh.color)
    primitive = {
        "attributes": attributes,
        "indices": indices,
        "material": gltf.add("materials", material),
    }
    shape = gltf.add("meshes", {"primitives": [primitive]})
    node = gltf.add("nodes", {"mesh": shape})
    gltf.document["scene"] = gltf.add("scenes", {"nodes": [node]})
    return gltf.glb()


def _normals(mesh: Mesh) -> NDArray[np.float32]:
    corners = mesh.vertices[mesh.faces]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(normals, mesh.faces[:, corner], faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.ascontiguousarray(normals / np.maximum(lengths, 1e-20), np.float32)


def _unlit(strength: float) -> dict[str, object]:
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [strength, strength, strength, 1],
            "baseColorTexture": {"index": 0},
        },
        "doubleSided": True,
        "extensions": {UNLIT: {}},
    }


def _lit(color: tuple[int, int, int]) -> dict[str, object]:
    linear = linear_of(np.array(color) / 255.0)
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*map(float, linear), 1],
            "metallicFactor": 0,
            "roughnessFactor": 0.9,
        },
        "doubleSided": True,
    }
