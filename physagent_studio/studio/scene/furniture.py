"""What stands still around the objects: supports, the camera that took the photo, gravity, axes."""

import math
from collections.abc import Callable

import numpy as np
import viser

from physagent_studio.arrays import FloatArray
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Scene
from physagent_studio.studio.scene.marks import VALUE, Labels
from physagent_studio.studio.scene.places import small
from physagent_studio.studio.scene.primitives import edges_of, mesh_of_support

GREY = (120, 130, 145)


class Furniture:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(self, server: viser.ViserServer, picked: Callable[[str, str], None]) -> None:
        self._server = server
        self._picked = picked
        self._handles: dict[str, list[viser.SceneNodeHandle]] = {}
        self._said: tuple[FloatArray, str] | None = None

    def keep_free(self, words: Labels) -> None:
        """Has other words make way for the label of gravity."""
        if self._said is not None:
            words.place(*self._said)

    def clear(self) -> None:
        """Removes all of it."""
        for name in ("/supports", "/camera", "/gravity", "/axes"):
            self._server.scene.remove_by_name(name)
        self._handles = {}

    def make(
        self, program: PhysicalProgram, scene: Scene | None, centre: FloatArray, size: float
    ) -> None:
        """Draws all of it; `centre` (3,) m and `size`, m, are those of the objects."""
        self._handles["supports"] = self._supports(program, scene, centre, size)
        self._handles["frustum"] = self._camera(program, scene, size)
        self._handles["gravity"] = self._gravity(program, size)
        self._handles["axes"] = [
            self._server.scene.add_frame("/axes", axes_length=size * 0.5, axes_radius=size * 0.01)
        ]

    def show(self, shown: frozenset[str]) -> None:
        """Shows the kinds that are named, hides the others."""
        for what, handles in self._handles.items():
            for handle in handles:
                handle.visible = what in shown

    def _supports(
        self, program: PhysicalProgram, scene: Scene | None, centre: FloatArray, size: float
    ) -> list[viser.SceneNodeHandle]:
        handles: list[viser.SceneNodeHandle] = []
        for item in program.scene.supports:
            if item.shape is not None and item.shape.kind == "floor":
                handles.append(self._floor(item.name, item.shape.height, centre, size))
                continue
            mesh = scene.support_meshes.get(item.name) if scene else None
            mesh = mesh if mesh is not None else mesh_of_support(item)
            if mesh is None:
                continue
            name = item.name
            body = self._server.scene.add_mesh_simple(
                f"/supports/{name}", mesh.vertices, mesh.faces, color=GREY,
                opacity=0.14, side="double", flat_shading=True, cast_shadow=False,
            )  # fmt: skip
            body.on_click(lambda _event, name=name: self._picked("support", name))
            lines = self._server.scene.add_line_segments(
                f"/supports/edges {name}", edges_of(mesh), colors=GREY, thickness=1.5,
                thickness_units="screen",
            )  # fmt: skip
            handles += [body, lines]
        return handles

    def _floor(
        self, name: str, height: float, centre: FloatArray, size: float
    ) -> viser.SceneNodeHandle:
        return self._server.scene.add_grid(
            f"/supports/{name}", width=size * 8, height=size * 8, plane="xy",
            cell_size=size / 4, section_size=size, cell_color=(205, 209, 216),
            section_color=(176, 182, 192), cell_thickness=0.4, section_thickness=0.7,
            position=(centre[0], centre[1], height),
        )  # fmt: skip

    def _camera(
        self, program: PhysicalProgram, scene: Scene | None, size: float
    ) -> list[viser.SceneNodeHandle]:
        camera = program.scene.camera
        if camera is None:
            return []
        width, rows = camera.size
        image = scene.photo if scene else None
        handle = self._server.scene.add_camera_frustum(
            "/camera", fov=2 * float(np.arctan2(rows / 2, camera.focal)), aspect=width / rows,
            scale=size * 0.16, thickness=1.5,
            thickness_units="screen", image=None if image is None else small(image),
            wxyz=camera.rotation, position=camera.position, color=(90, 96, 110),
        )  # fmt: skip
        handle.on_click(lambda _event: self._picked("camera", ""))
        return [handle]

    def _gravity(self, program: PhysicalProgram, size: float) -> list[viser.SceneNodeHandle]:
        gravity = np.array(program.scene.gravity)
        strength = float(np.linalg.norm(gravity))
        self._said = None
        if strength < 1e-9:
            return []
        places = [o.position for o in program.scene.objects if o.position is not None]
        corner = np.array(places or [(0.0, 0.0, 0.0)])
        left, top = corner[:, 0].min() - size * 0.3, corner[:, 2].max() + size * 0.25
        start = np.array([left, corner[:, 1].mean(), top])
        tip = start + gravity / strength * size * 0.16
        arrow = self._server.scene.add_arrows(
            "/gravity", np.array([[start, tip]]), colors=(220, 120, 40),
            shaft_radius=size * 0.004, head_radius=size * 0.012, head_length=size * 0.035,
        )  # fmt: skip
        self._said = start, f"gravity {strength:.3g} m/s²"
        label = self._server.scene.add_label(
            "/gravity/label", self._said[1], position=start,
            font_screen_scale=VALUE, anchor="bottom-center",
        )  # fmt: skip
        return [arrow, label]


SKY, GROUND, STRENGTH = (255, 255, 255), (190, 182, 172), 1.55
SIDE, SIDE_STRENGTH = (6.0, -1.5, 3.0), 1.5
"""What stands in for the sky: all of it, and its bright side, a place that shines towards the
origin, world, m. Chosen so that colours look as they did under viser's own."""


def light(scene: viser.SceneApi) -> None:
    """Lights a scene without a photographed sky and without shadows."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(cast_shadow=False)
    # The light's own up is y; the world's is z.
    half = math.sqrt(0.5)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=SKY, ground_color=GROUND, intensity=STRENGTH,
        wxyz=(half, half, 0, 0),
    )  # fmt: skip
    scene.add_light_directional("/light/side", intensity=SIDE_STRENGTH, position=SIDE)
