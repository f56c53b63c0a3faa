"""A contact sheet of a reconstruction: photo, masks, overlay, render over plate, other view."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.rotations import quaternion_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.shapes.silhouettes import in_world, look
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.compositor import lens_of
from physagent_studio.rendering.light import LIGHT
from physagent_studio.rendering.raster import rasterise
from physagent_studio.rendering.sheets import contact_sheet as tiled
from physagent_studio.rendering.sheets import marked
from physagent_studio.rendering.skin import Skin


@dataclass(frozen=True, slots=True)
class SheetSettings:
    """How a contact sheet is drawn."""

    # 0..255: of things in turn, told apart by everyone
    colors_rgb: tuple[tuple[int, int, int], ...] = (
        (230, 60, 50),
        (50, 180, 70),
        (60, 110, 240),
        (240, 190, 30),
        (180, 70, 210),
    )
    panel_px: int = 560  # 200..1200: width of a panel, of which three fit a screen


SHEET = SheetSettings()


def contact_sheet(scene: Scene) -> Image:
    """Six panels in two rows: photo with clicks, masks, overlay; render, plate, view from the side.

    Returns (h, w, 3) uint8 RGB.
    """
    assert scene.photo is not None
    assert scene.state.camera is not None
    camera = scene.state.camera
    known = (*scene.state.objects, *scene.state.supports)
    clicks = [(item.name, click) for item in known for click in item.grounding.points]
    camera_words = (
        f"photo: horizon {camera.horizon:.0f} +- {camera.horizon_sigma or 0:.0f} px, "
        f"height {camera.position[2]:.2f} m, scale {scene.state.scale.reference}"
    )
    panels = {
        camera_words: marked(scene.photo, clicks),
        "masks": _masks(scene),
        "overlay": _overlay(scene, camera),
        "render over plate": _render(scene, camera, scene.plate),
        "plate": scene.plate if scene.plate is not None else scene.photo,
        "other view": _render(scene, _other(scene, camera), None),
    }
    return tiled(list(panels.values()), list(panels), 3, SHEET.panel_px)


def _masks(scene: Scene) -> Image:
    assert scene.photo is not None
    out = (scene.photo * 0.35).astype(np.uint8)
    for index, mask in enumerate(scene.masks.values()):
        color = np.array(SHEET.colors_rgb[index % len(SHEET.colors_rgb)])
        out[mask] = (0.5 * scene.photo[mask] + 0.5 * color).astype(np.uint8)
    return out


def _bodies(scene: Scene) -> dict[str, tuple[NDArray, NDArray]]:
    return {
        item.name: (in_world(item, scene.meshes[item.name]), scene.meshes[item.name].faces)
        for item in scene.state.objects
        if item.name in scene.meshes and item.position is not None
    }


def _overlay(scene: Scene, camera: Camera) -> Image:
    """Outlines of masks (white) and of the placed bodies (coloured), supports and horizon."""
    assert scene.photo is not None
    out = scene.photo.copy()
    right = out.shape[1]
    start, end = (round(camera.horizon_at(column)) for column in (0, right))
    if any(0 <= row < out.shape[0] for row in (start, end)):
        cv2.line(out, (0, start), (right, end), (0, 255, 255), 1)
    for item in scene.state.supports:
        if item.shape is not None and item.shape.kind in ("box", "ramp"):
            _wire(out, camera, scene.support_meshes[item.name])
    seen = look(camera, _bodies(scene))
    for index, name in enumerate(_bodies(scene)):
        _outline(out, scene.masks[name], (255, 255, 255))
        _outline(out, seen.owner == index, SHEET.colors_rgb[index % len(SHEET.colors_rgb)])
    return out


def _outline(image: Image, mask: NDArray[np.bool_], color: tuple[int, int, int]) -> None:
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(image, found, -1, color, 1, cv2.LINE_AA)


def _wire(image: Image, camera: Camera, mesh: Mesh) -> None:
    pixels, depth = camera.project(mesh.vertices)
    for face in mesh.faces:
        if depth[face].min() > 0.01:
            spots = np.clip(pixels[face], -20000, 20000).astype(np.int32)
            cv2.polylines(image, [spots], True, (255, 0, 255), 1, cv2.LINE_AA)


def _render(scene: Scene, camera: Camera, background: Image | None) -> Image:
    """The textured bodies over a background; without one, over grey with the supports' frames."""
    width, height = camera.size
    out = np.full((height, width, 3), 215, np.uint8) if background is None else background.copy()
    if background is None:
        for item in scene.state.supports:
            if item.shape is not None:
                _wire(out, camera, scene.support_meshes[item.name])
    shown = [item for item in scene.state.objects if item.name in _bodies(scene)]
    meshes = [scene.meshes[item.name] for item in shown]
    batch, turns = Batch.of(meshes), np.array([item.rotation for item in shown]).reshape(-1, 4)
    world = batch.placed(np.array([item.position for item in shown]).reshape(-1, 3), turns)
    lens = lens_of(camera)
    points = (world - np.asarray(camera.position)) @ camera.matrix
    hits = rasterise(points, batch.faces, lens, batch.one_sided)
    skin = Skin.of(batch, meshes, LIGHT, turns, points, lens)
    out.reshape(-1, 3)[hits.pixel] = skin.colors(hits, turns, None)
    return out


def _other(scene: Scene, camera: Camera) -> Camera:
    """The same lens from the right and above, looking at the middle of the objects."""
    places = [item.position for item in scene.state.objects if item.position is not None]
    middle = np.mean(places, axis=0) if places else np.array([0.0, 3.0, 0.0])
    eye = np.asarray(camera.position)
    away = middle - eye
    turn = np.radians(50)
    cos, sin = np.cos(turn), np.sin(turn)
    back = np.array([-away[0] * cos + away[1] * sin, -away[0] * sin - away[1] * cos, 0.0])
    far = float(np.linalg.norm(away))
    place = middle + back / max(float(np.linalg.norm(back)), 1e-9) * far * 1.15
    place[2] = middle[2] + 0.45 * far
    forward = (middle - place) / np.linalg.norm(middle - place)
    right = np.cross(forward, (0, 0, 1.0))
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    rotation = quaternion_of(np.stack([right, down, forward], 1))
    position = (float(place[0]), float(place[1]), float(place[2]))
    return camera.model_copy(update={"position": position, "rotation": rotation})
