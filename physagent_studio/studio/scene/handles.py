"""The selected thing in the scene: a frame around it, and handles to move, turn and scale it.

At the beginning of the clip the handles say how it starts. Later, physics says where it is, and
the handle says where it should be: that is a wish, which the agent answers with a proposal.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.program import Edit, SceneObject, SetField
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene import state as shapes
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.records import Mesh

LEAST, MOST = 0.1, 10.0
"""What one pull may make of a length."""


def pulled(start: FloatArray, centre: FloatArray, eye: FloatArray, pointer: FloatArray) -> float:
    """By how much the line from `centre` to `start` grows when its end follows a pointer.

    All world, m. The pointer is a ray from `eye` through `pointer`; the new end is the point of
    the line that comes closest to it.
    """
    line, ray = start - centre, pointer - eye
    if not np.isfinite(ray).all() or np.linalg.norm(line) < 1e-9 or np.linalg.norm(ray) < 1e-9:
        return 1.0
    ray = ray / np.linalg.norm(ray)
    # Closest points of two lines: centre + s·line and eye + t·ray.
    across = line - (line @ ray) * ray
    if across @ across < 1e-6 * (line @ line):
        return 1.0
    grown = float(((eye - centre) @ across) / (across @ across))
    return min(max(grown, LEAST), MOST)


def factors_of(shape: shapes.Shape, axis: int | None, grown: float) -> FloatArray:
    """(3,) how a shape grows along its axes when it is pulled along one; None pulls at all."""
    factors = np.ones(3)
    if axis is None or isinstance(shape, shapes.Sphere):
        return factors * grown
    factors[axis] = grown
    round_ = shapes.Cylinder | shapes.Capsule | shapes.Frustum | shapes.Revolved | shapes.Torus
    if axis < 2 and isinstance(shape, round_):
        factors[:2] = grown
    return factors


def scaled(shape: shapes.Shape, factors: FloatArray) -> shapes.Shape | None:
    """The shape that is larger by `factors` along its axes; None for one without a size."""
    x, z = float(factors[0]), float(factors[2])
    change: dict[str, object]
    match shape:
        case shapes.Sphere():
            change = {"radius": _neat(shape.radius * x)}
        case shapes.Ellipsoid():
            change = {"radii": _each(shape.radii, factors)}
        case shapes.Box() | shapes.Inflated() | shapes.Meshed():
            change = {"size": _each(shape.size, factors)}
        case shapes.Cylinder() | shapes.Capsule():
            change = {"radius": _neat(shape.radius * x), "height": _neat(shape.height * z)}
        case shapes.Torus():
            change = {"radius": _neat(shape.radius * x), "tube": _neat(shape.tube * z)}
        case shapes.Frustum():
            change = {
                "bottom_radius": _neat(shape.bottom_radius * x),
                "top_radius": _neat(shape.top_radius * x),
                "height": _neat(shape.height * z),
            }
        case shapes.Revolved():
            profile = [[_neat(at * z), _neat(radius * x)] for at, radius in shape.profile]
            change = {"profile": profile}
        case _:
            return None
    return type(shape).model_validate(shape.model_dump() | change)


def _neat(value: float) -> float:
    return float(f"{value:.5g}")


def _each(values: tuple[float, float, float], factors: FloatArray) -> list[float]:
    return [_neat(one * float(factor)) for one, factor in zip(values, factors, strict=True)]


def scaling(item: SceneObject, mesh: Mesh, factors: FloatArray) -> tuple[Edit, ...]:
    """The edits that scale an object; what stands on something keeps standing there."""
    if item.shape is None or item.position is None:
        return ()
    made = scaled(item.shape, factors)
    if made is None or made == item.shape:
        return ()
    path = f"scene.objects.{item.name}"
    edits: list[Edit] = [SetField(path=f"{path}.shape", value=made.model_dump(mode="json"))]
    if not in_air(item):
        up = mesh.vertices @ matrix_of(item.rotation)[2]
        grown = (mesh.vertices * factors) @ matrix_of(item.rotation)[2]
        x, y, z = item.position
        place: list[JsonValue] = [x, y, _neat(z + float(up.min() - grown.min()))]
        edits.append(SetField(path=f"{path}.position", value=place))
    return tuple(edits)


Later = Callable[[Callable[[], None], int | None, bool], None]
"""Has something done by the studio's thread; may be called from any thread. With it the number of
the 3D view whose hand does it, and whether that lets go."""

Edited = Callable[[tuple[Edit, ...], str, bool], None]
"""Called with edits, what they are in words, and whether the hand has let go."""

Wished = Callable[[str, FloatArray, bool], None]
"""Called with an object's name, where it should be now, m, and whether the hand has let go."""

FRAME, WISH = (255, 190, 30), (245, 158, 11)
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]
GRIPS = {"x": 0, "y": 1, "z": 2, "all": None}
"""Where the scale handles sit on the frame: the middle of a side, or a corner for all three."""


@dataclass(frozen=True, eq=False, slots=True)
class Held:
    """What may be taken hold of: the object, how it looks, and which handles it has."""

    item: SceneObject
    mesh: Mesh
    what: str
    """"" a frame only, "place" at the start, "wish" later."""


@dataclass(eq=False, slots=True)
class _Gizmo:
    """A transform control, and for a wish the shade that goes with it."""

    what: str
    control: viser.TransformControlsHandle
    shade: viser.MeshHandle | None = None


class Handles:
    """Owned by the stage; called by the studio's one thread."""

    def __init__(
        self, server: viser.ViserServer, edited: Edited, wished: Wished, later: Later
    ) -> None:
        self._server = server
        self._edited = edited
        self._wished = wished
        self._later = later
        self._thing: Held | None = None
        self._frame: viser.LineSegmentsHandle | None = None
        self._gizmo: _Gizmo | None = None
        self._busy = False

    def clear(self) -> None:
        """Removes all of them."""
        self._server.scene.remove_by_name("/selection")
        self._thing, self._frame, self._gizmo, self._busy = None, None, None, False

    def select(self, thing: Held | None) -> None:
        """Frames an object, with handles where it may be changed; None takes all away."""
        old, self._thing = self._thing, thing
        if thing is None:
            if old is not None:
                self.clear()
            return
        if old is not None and old.mesh is thing.mesh and old.what == thing.what:
            return
        self.clear()
        self._thing = thing
        self._frame = self._server.scene.add_line_segments(
            "/selection/frame", frame_of(thing.mesh), colors=FRAME, thickness=2,
            thickness_units="screen",
        )  # fmt: skip
        if thing.what:
            self._gizmo = self._make_gizmo(thing)
        if thing.what == "place":
            self._make_grips(thing)

    def pose(self, position: FloatArray, rotation: FloatArray) -> None:
        """Brings them to where the object is, unless a hand is on them."""
        if self._busy or self._frame is None:
            return
        self._frame.position, self._frame.wxyz = position, rotation
        if self._gizmo is not None:
            self._gizmo.control.position = position
            self._gizmo.control.wxyz = rotation if self._gizmo.what == "place" else (1, 0, 0, 0)
            if self._gizmo.shade is not None:
                self._gizmo.shade.position, self._gizmo.shade.wxyz = position, rotation
                self._gizmo.shade.visible = False

    # --- moving and turning ------------------------------------------------------------------

    def _make_gizmo(self, thing: Held) -> _Gizmo:
        reach = float(np.linalg.norm(thing.mesh.vertices, axis=1).max())
        wish = thing.what == "wish"
        control = self._server.scene.add_transform_controls(
            "/selection/gizmo", scale=reach * 2.2, line_width=2.0, depth_test=False,
            opacity=0.85, disable_rotations=wish,
        )  # fmt: skip
        shade = None
        if wish:
            shade = self._server.scene.add_mesh_simple(
                "/selection/wish", thing.mesh.vertices, thing.mesh.faces, color=WISH,
                opacity=0.5, cast_shadow=False, receive_shadow=False, visible=False,
            )  # fmt: skip

        async def moved(event: viser.TransformControlsEvent) -> None:
            position = np.asarray(event.target.position, float).copy()
            rotation = np.asarray(event.target.wxyz, float).copy()
            ends = event.phase == "end"
            self._later(lambda: self._move(thing, position, rotation, ends), event.client_id, ends)

        control.on_update(moved)
        return _Gizmo(thing.what, control, shade)

    def _move(self, thing: Held, position: FloatArray, rotation: FloatArray, ends: bool) -> None:
        if self._gizmo is None or self._thing is None or self._thing.mesh is not thing.mesh:
            return  # It belongs to something that is no longer selected.
        self._busy = not ends
        finite = np.isfinite(position).all() and np.isfinite(rotation).all()
        if not finite or np.linalg.norm(rotation) < 1e-6:
            return
        if thing.what == "wish":
            if self._gizmo.shade is not None:
                self._gizmo.shade.position, self._gizmo.shade.visible = position, True
            self._server.flush()
            self._wished(thing.item.name, position, ends)
            return
        if self._frame is not None:
            self._frame.position, self._frame.wxyz = position, rotation
        self._edited(placing(thing.item, position, rotation), "moved in the scene", ends)

    # --- scaling -----------------------------------------------------------------------------

    def _make_grips(self, thing: Held) -> None:
        low, high = box_of(thing.mesh)
        side = float((high - low).max()) * 0.12
        for key, axis in GRIPS.items():
            place = (low + high) / 2 if axis is not None else high
            if axis is not None:
                place[axis] = high[axis]
            grip = self._server.scene.add_box(
                f"/selection/frame/{key}", color=FRAME, dimensions=(side, side, side),
                position=place, cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
            self._bind(grip, thing, axis, place)

    def _bind(
        self, grip: viser.BoxHandle, thing: Held, axis: int | None, place: FloatArray
    ) -> None:
        async def drag(event: viser.SceneNodeDragEvent[viser.BoxHandle]) -> None:
            eye = np.asarray(event.client.camera.position, float)
            pointer = np.asarray(event.end_position, float)
            ends = event.phase == "end"
            self._later(
                lambda: self._scale(thing, axis, place, eye, pointer, ends),
                event.client.client_id,
                ends,
            )

        grip.on_drag("left")(drag)

    def _scale(
        self,
        thing: Held,
        axis: int | None,
        place: FloatArray,
        eye: FloatArray,
        pointer: FloatArray,
        ends: bool,
    ) -> None:
        if self._frame is None or self._thing is None or self._thing.mesh is not thing.mesh:
            return
        item = thing.item
        if item.position is None or item.shape is None:
            return
        self._busy = not ends
        centre = np.array(item.position)
        start = centre + matrix_of(item.rotation) @ place
        factors = factors_of(item.shape, axis, pulled(start, centre, eye, pointer))
        x, y, z = (1.0, 1.0, 1.0) if ends else (float(part) for part in factors)
        self._frame.scale = (x, y, z)
        self._server.flush()
        edits = scaling(item, thing.mesh, factors)
        if edits:
            self._edited(edits, "scaled in the scene", ends)


def placing(item: SceneObject, position: FloatArray, rotation: FloatArray) -> tuple[Edit, ...]:
    """The edits that put an object somewhere, without those that change nothing."""
    path = f"scene.objects.{item.name}"
    edits: list[Edit] = []
    if item.position is None or np.abs(position - item.position).max() > 1e-6:
        place = [float(f"{part:.5g}") for part in position]
        edits.append(SetField(path=f"{path}.position", value=list(place)))
    if np.abs(rotation - item.rotation).max() > 1e-6:
        turn = [float(f"{part:.6g}") for part in rotation / np.linalg.norm(rotation)]
        edits.append(SetField(path=f"{path}.rotation", value=list(turn)))
    return tuple(edits)


def box_of(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner of the frame around a mesh, body frame, m."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = 0.04 * float((high - low).max())
    return low - margin, high + margin


def frame_of(mesh: Mesh) -> FloatArray:
    """(12, 2, 3) the edges of the mesh's box in the body frame, a little larger, m."""
    low, high = box_of(mesh)
    corners = low + _CORNERS * (high - low)
    return np.array([[corners[a], corners[b]] for a, b in _EDGES])
