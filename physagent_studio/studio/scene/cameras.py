"""Each browser's own camera: the photo's view with the photo behind, and other fixed views."""

import math
import time
from dataclasses import dataclass, field, replace
from operator import is_

import numpy as np
import viser

from physagent_studio.arrays import FloatArray
from physagent_studio.program import Camera, PhysicalProgram
from physagent_studio.program.scene.forms import Floor
from physagent_studio.program.scene.state import Support
from physagent_studio.records import Image, Mesh, Scene
from physagent_studio.studio.scene.glb import glb_of
from physagent_studio.studio.scene.places import centre_and_size
from physagent_studio.studio.scene.surround import beyond_of, seen_of

Files = tuple[bytes, ...]
"""Binary glTF."""
ON_ITS_WAY = 10.0
"""Seconds for which a browser's camera may still be where it was before it was moved."""

FRAME = (("dark", (40, 40, 40), 3.5), ("light", (255, 255, 255), 1.5))
"""Lines around the photo: name, colour, pixels."""


@dataclass(frozen=True, eq=False, slots=True)
class Pose:
    """Where a camera is: eye and target, world, m; up; vertical field of view, radians."""

    eye: FloatArray
    target: FloatArray
    up: FloatArray
    fov: float


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """The photo all around one browser's camera, made once and then only shown or hidden.

    of: the picture that it was made from. photo: that itself, for its own view. beyond: what lies
    around it, for every view. seen: what the photo shows laid on the scene `on`, for all others;
    made when the photo's own view is first left.
    """

    of: object
    photo: viser.SceneNodeHandle
    beyond: tuple[viser.SceneNodeHandle, ...]
    on: object = None
    seen: tuple[viser.SceneNodeHandle, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class _Eye:
    """What is known of one browser's camera. size: of its canvas when the pose was set.

    put_at: when the pose was sent, s. arrived: whether the browser has said that it is there;
    until then it still tells where it was before.
    """

    client: viser.ClientHandle
    view: str = "photo"
    set_to: Pose | None = None
    size: tuple[int, int] = (0, 0)
    put_at: float = 0.0
    arrived: bool = False
    around: Around | None = None
    marks: dict[int, Pose] = field(default_factory=dict)


class Cameras:
    """All browsers' cameras; called by the studio's one thread."""

    def __init__(self) -> None:
        self._eyes: dict[int, _Eye] = {}
        self._program = PhysicalProgram()
        self._picture: tuple[Camera, Image] | None = None
        self._under: tuple[tuple[Mesh, ...], tuple[Support, ...]] = ((), ())
        self._made: dict[str, Files] = {}

    def add(self, client: viser.ClientHandle) -> None:
        """A browser came; it opens in the photo's own camera."""
        self._eyes[client.client_id] = _Eye(client)
        self.look(client.client_id, "photo")

    def remove(self, number: int) -> None:
        """A browser went."""
        self._eyes.pop(number, None)

    def set_scene(self, program: PhysicalProgram, scene: Scene | None, with_photo: bool) -> None:
        """Brings backdrops, and cameras that still look where they were put, up to date."""
        image = None if scene is None else (scene.plate if scene.plate is not None else scene.photo)
        meshes = () if scene is None else tuple(scene.support_meshes.values())
        old, self._program = self._program.scene.camera, program
        camera, before = program.scene.camera, self._picture
        if not with_photo or image is None or camera is None:
            self._picture = None
        elif before is None or before[1] is not image or before[0] != camera:
            self._picture = (camera, image)
        changed = before is not self._picture
        kept = len(meshes) == len(self._under[0]) and all(map(is_, meshes, self._under[0]))
        moved = not kept or self._under[1] != program.scene.supports
        if changed or moved:
            self._under = (meshes, program.scene.supports)
            self._made = {} if changed else {k: v for k, v in self._made.items() if k != "seen"}
        for number, eye in tuple(self._eyes.items()):
            if old != program.scene.camera and eye.view == "photo":
                self.look(number, "photo")
            elif changed:
                self._backdrop(number)

    def reset(self) -> None:
        """Another session: everybody begins in the photo's own view again."""
        for number in tuple(self._eyes):
            self.look(number, "photo")

    def look(self, number: int, view: str, target: FloatArray | None = None) -> None:
        """Moves one browser's camera to a view; `target` is what "selection" looks at."""
        eye = self._eyes.get(number)
        if eye is None:
            return
        size = (eye.client.camera.image_width, eye.client.camera.image_height)
        pose = pose_of(self._program, view, size[0] / max(size[1], 1), target)
        self._eyes[number] = replace(
            eye, view=view, set_to=pose, size=size, put_at=time.monotonic(), arrived=False
        )
        _put(eye.client, pose)
        self._backdrop(number)

    def follow(self, target: FloatArray) -> None:
        """Keeps the cameras that follow on the target."""
        for eye in self._eyes.values():
            if eye.view == "follow":
                camera = eye.client.camera
                shift = target - camera.look_at
                if np.linalg.norm(shift) > 1e-4:
                    camera.position = camera.position + shift

    def moved(self, number: int) -> None:
        """A browser's camera moved: by the person, or because its canvas has another size."""
        eye = self._eyes.get(number)
        if eye is None or eye.set_to is None:
            return
        camera = eye.client.camera
        size = (camera.image_width, camera.image_height)
        away = _left(camera, eye.set_to)
        if eye.view == "photo" and _reshaped(size, eye.size):
            self.look(number, "photo")
        elif not away and not eye.arrived:
            # What is exactly what was sent has not been to the browser and back.
            echo = np.array_equal(camera.position, eye.set_to.eye)
            self._eyes[number] = replace(eye, arrived=not echo)
        elif not eye.arrived and time.monotonic() - eye.put_at < ON_ITS_WAY:
            return
        elif eye.view not in ("free", "follow") and away:
            self._eyes[number] = replace(eye, view="free", size=size)
            self._backdrop(number)

    def keep(self, number: int, slot: int) -> bool:
        """Remembers the camera under a number."""
        if (eye := self._eyes.get(number)) is None:
            return False
        camera = eye.client.camera
        eye.marks[slot] = Pose(camera.position, camera.look_at, camera.up_direction, camera.fov)
        return True

    def recall(self, number: int, slot: int) -> bool:
        """Goes back to a remembered camera; whether there was one."""
        eye = self._eyes.get(number)
        if eye is None or slot not in eye.marks:
            return False
        self._eyes[number] = replace(eye, view="free", set_to=eye.marks[slot], arrived=False)
        _put(eye.client, eye.marks[slot])
        self._backdrop(number)
        return True

    def _backdrop(self, number: int) -> None:
        """The photo: far behind everything in its own view, else on ground, supports and sky.

        What lies beyond the photo goes first, so that no bare border is ever seen.
        """
        eye, scene = self._eyes[number], self._eyes[number].client.scene
        around, own = eye.around, eye.view == "photo"
        if around is not None and around.of is not self._picture:
            for handle in (*around.beyond, *around.seen, around.photo):
                handle.remove()
            around = None
        if self._picture is not None:
            camera, image = self._picture
            if around is None:
                beyond = _added(scene, "beyond", self._files("beyond"))
                around = Around(
                    self._picture, add_backdrop(scene, self._program, camera, image), beyond
                )
            if not own and around.on is not self._under:
                for handle in around.seen:
                    handle.remove()
                seen = _added(scene, "seen", self._files("seen"))
                around = replace(around, on=self._under, seen=seen)
            around.photo.visible = own
            for handle in around.seen:
                handle.visible = not own
        self._eyes[number] = replace(eye, around=around)

    def _files(self, part: str) -> Files:
        """A part of the picture around as files for the browser, made once for all of them."""
        if part in self._made:
            return self._made[part]
        assert self._picture is not None
        camera, image = self._picture
        floors = [one.shape for one in self._program.scene.supports]
        level = next((one.height for one in floors if isinstance(one, Floor)), None)
        _, size = centre_and_size(self._program)
        far = 1.3 * far_of(self._program, camera)
        if part == "beyond":
            meshes = beyond_of(camera, image, far)
        else:
            meshes = seen_of(camera, image, level, self._under[0], far, size)
        self._made[part] = tuple(glb_of(one, quality=85) for one in meshes)
        return self._made[part]


def _added(scene: viser.SceneApi, part: str, files: Files) -> tuple[viser.SceneNodeHandle, ...]:
    return tuple(
        scene.add_glb(f"/around/{part}/{at}", file, cast_shadow=False)
        for at, file in enumerate(files)
    )


def add_backdrop(
    scene: viser.SceneApi, program: PhysicalProgram, camera: Camera, image: Image
) -> viser.ImageHandle:
    """The picture far behind everything, exactly where its camera saw it, with its border drawn."""
    distance = far_of(program, camera)
    width, rows = camera.size
    shift = (np.array([width, rows]) / 2 - camera.principal) / camera.focal
    centre = camera.matrix @ np.array([shift[0], shift[1], 1.0]) * distance + camera.position
    across, down = width / camera.focal * distance, rows / camera.focal * distance
    photo = scene.add_image(
        "/backdrop", image, across, down, jpeg_quality=92, cast_shadow=False,
        receive_shadow=False, wxyz=camera.rotation, position=centre,
    )  # fmt: skip
    _add_frame(scene, across, down, distance)
    return photo


def _add_frame(scene: viser.SceneApi, across: float, down: float, distance: float) -> None:
    """The border of the backdrop, light on dark: the clip shows what is inside, nothing else."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [across / 2, down / 2]
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    for at, (name, color, pixels) in enumerate(FRAME, 1):
        # A little nearer than the picture, and smaller by as much, so that it is drawn over it.
        near = 1e-3 * at
        depth = np.full((4, 2, 1), -near * distance)
        scene.add_line_segments(
            f"/backdrop/{name}", np.concatenate([sides * (1 - near), depth], axis=-1),
            colors=color, thickness=pixels, thickness_units="screen",
        )  # fmt: skip


def far_of(program: PhysicalProgram, camera: Camera) -> float:
    """A distance, m, behind everything that the scene holds."""
    centre, size = centre_and_size(program)
    away = float(np.linalg.norm(centre - np.array(camera.position)))
    return max(40.0, 30 * size, 6 * away)


def pose_of(
    program: PhysicalProgram, view: str, aspect: float, target: FloatArray | None = None
) -> Pose:
    """The pose of a named view for a canvas of that width over height."""
    centre, size = centre_and_size(program)
    camera = program.scene.camera
    if view == "photo" and camera is not None:
        return _photo_pose(camera, centre, aspect)
    fov = math.radians(45)
    middle = centre if target is None else target
    away = size * 2.2 if target is None else max(size * 0.9, 0.25)
    up = np.array([0.0, 1.0, 0.0] if view == "top" else [0.0, 0.0, 1.0])
    ways = {"top": (0, -1e-3, 1.2), "side": (1, 0, 0.15), "front": (0.12, -1, 0.3)}
    return Pose(middle + np.array(ways.get(view, (0.45, -0.8, 0.4))) * away, middle, up, fov)


def _photo_pose(camera: Camera, centre: FloatArray, aspect: float) -> Pose:
    """The camera of the photo, opened so far that the whole photo fits into the canvas."""
    width, rows = camera.size
    tall = max(rows / 2, width / 2 / max(aspect, 1e-3)) / camera.focal
    matrix, eye = camera.matrix, np.array(camera.position)
    depth = max(float((centre - eye) @ matrix[:, 2]), 0.1)
    return Pose(eye, eye + matrix[:, 2] * depth, -matrix[:, 1], 2 * math.atan(tall))


def _put(client: viser.ClientHandle, pose: Pose) -> None:
    with client.atomic():
        client.camera.up_direction = pose.up
        client.camera.position = pose.eye
        client.camera.look_at = pose.target
        client.camera.fov = pose.fov
    client.flush()


def _reshaped(size: tuple[int, int], old: tuple[int, int]) -> bool:
    """Whether a canvas has another form; a viewer that is slow only changes its resolution."""
    return abs(size[0] * old[1] - size[1] * old[0]) > 0.01 * max(old[0] * old[1], 1)


def _left(camera: viser.CameraHandle, pose: Pose) -> bool:
    away = max(float(np.linalg.norm(pose.target - pose.eye)), 1e-6)
    shifted = np.linalg.norm(camera.position - pose.eye)
    turned = np.linalg.norm(camera.look_at - pose.target)
    return bool(max(shifted, turned) > 0.01 * away)
