"""Reads a `config.yaml` of the PhysAgent and RealWonder releases: clicks, materials, gravity, time.

Their world is x right, y forward, z up like ours, and they count steps of `dt` too, so that
`dt`, `frame_steps`, `substeps` and `simulated_frames_num` carry over as they are. What decides
the motion there and has no place here is listed in `PeerSetup.left_out`.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import JsonValue

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_reader import MAX_PROMPT, check_inside, slug
from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.peers.handler import read_handler
from physagent_studio.exchange.peers.schedule import NO_MOTION, Motion, beyond, motion_edits
from physagent_studio.exchange.plain_yaml import MAX_BYTES, PlainYaml, read_yaml
from physagent_studio.program.edits import Edit, SetField
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.state import Click, Grounding, Support
from physagent_studio.program.timing import FASTEST, SLOWEST, retimed
from physagent_studio.reconstruction import read_photo
from physagent_studio.records.case import Case

_PHOTOS = ("input.png", "resized_input_image.png", "input.jpg")
_BODIES: dict[str, str] = {
    "rigid": "rigid",
    "pbd_cloth": "cloth",
    "pbd_liquid": "liquid",
    "mpm_liquid": "liquid",
    "pbd_elastic": "soft",
    "mpm_elastic": "soft",
    "mpm_elastic2plastic": "plastic",
    "mpm_sand": "granular",
    "pbd_particle": "granular",
    "mpm_snow": "granular",
}
_COHESION = {"mpm_snow": 0.6}
_PREFIX = {"rigid": "rigid", "pbd": "pbd", "mpm": "MPM"}
_LOOKS_ONLY = """
    device seed example_name output_folder data_path segmenter all_object_masks_idx object_id
    support_object_masks_idx obj_kp obj_kp_matching stitched_inpainting debug logging_level
    sequential_object_inpainting object_occlusion_aware_inpainting inpainting_prompt
    inpainting_negative_prompt remove_support_from_background_inpainting alpha_threshold
    force_regenerate_inpainted_with_support crop_start fg_points_render_radius target_faces
    original_geometry_downsample use_rgb_frontside num_output_frames denoising_step_list
    mask_dropin_step particle_size MPM_grid_density closest_points_num remap_depth
    object_names all_object_names dynamic_object_names
"""
_READ = """
    all_object_points support_object_points support_object_names material_type gravity
    gravity_direction dt substeps simulated_frames_num frame_steps rigid_rho MPM_rho pbd_rho
    pbd_elastic_rho rigid_friction plane_friction MPM_E MPM_nu fixed_area vgen_prompt
"""
_OF_MATERIALS = (
    *("rigid_rho", "MPM_rho", "pbd_rho", "pbd_elastic_rho", "rigid_friction"),
    *("MPM_E", "MPM_nu", "fixed_area"),
)
"""Keys that only some materials ask for."""
_KNOWN = frozenset(f"{_LOOKS_ONLY} {_READ}".split())
"""Keys that are taken over, and those that only concern how pictures are made."""


_NAMES = ("object_names", "all_object_names", "dynamic_object_names")
"""Keys under which a configuration may call its objects for its handler."""
_ITS_OWN = ("all_object_points", "material_type")
"""Keys that every one of them has, and no case or program of ours."""


@dataclass(frozen=True, slots=True)
class PeerObject:
    """What the configuration says of one object; None where it is silent."""

    name: str
    density: float | None = None
    friction: float | None = None
    body: dict[str, JsonValue] = field(default_factory=lambda: {"kind": "rigid"})
    restitution: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class PeerSetup:
    """A peer's case and what it decides about the program.

    clip: fields of `program.clip`. gravity: m/s². floor_friction: of the ground. left_out: what
    decides the motion there and is not taken over. motion: the schedule, where the file has one.
    """

    case: Case
    objects: tuple[PeerObject, ...]
    left_out: tuple[str, ...]
    clip: dict[str, float] = field(default_factory=dict)
    gravity: tuple[float, float, float] | None = None
    floor_friction: float | None = None
    motion: Motion = NO_MOTION

    def edits_of_scheduled(self, program: PhysicalProgram) -> tuple[Edit, ...]:
        """The same for a program that has a schedule: its actions keep their seconds, and the clip
        takes the peer's pace rather than its steps. Where the peer has a schedule of its own, that
        and its clip take their place."""
        if self.motion != NO_MOTION:
            names = [item.name for item in self.objects]
            moved = motion_edits(program, self.motion, names, self.clip)
            return (*self._scene_edits(program), *moved)
        scene = self._scene_edits(program)
        step, count = self.clip.get("step_seconds"), self.clip.get("steps_per_frame")
        if step is None or count is None:
            return scene
        factor = step * count * program.clip.playback_fps
        return (*scene, *retimed(program, min(max(factor, SLOWEST), FASTEST)))

    def _scene_edits(self, program: PhysicalProgram) -> tuple[Edit, ...]:
        return tuple(edit for edit in self.edits(program) if not edit.path.startswith("clip."))

    def edits(self, program: PhysicalProgram) -> tuple[Edit, ...]:
        """Edits that give a program of this case the peer's numbers."""
        wanted: list[tuple[str, JsonValue]] = [(f"clip.{f}", own) for f, own in self.clip.items()]
        if self.gravity is not None:
            wanted.append(("scene.gravity", list(self.gravity)))
        for item in self.objects:
            if program.scene.object(item.name) is None:
                continue
            base = f"scene.objects.{item.name}"
            wanted.append((f"{base}.body", item.body))
            wanted += [
                (f"{base}.{one}", value)
                for one in ("density", "friction", "restitution")
                if (value := getattr(item, one)) is not None
            ]
        if self.floor_friction is not None and program.scene.support("floor") is not None:
            wanted.append(("scene.supports.floor.friction", self.floor_friction))
        return tuple(SetField(path=path, value=value) for path, value in wanted)


def is_peer_config(path: Path | str) -> bool:
    """Whether a file looks like a peer's configuration."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read(MAX_BYTES)
    except (OSError, UnicodeDecodeError):
        return False
    return all(re.search(rf"^{key}\s*:", text, re.M) for key in _ITS_OWN)


def load_peer_config(
    path: Path | str,
    photo: Path | str | None = None,
    names: Sequence[str] = (),
) -> PeerSetup:
    """Read a peer's configuration.

    photo: None for the picture beside it. names: of the objects, in its order; the format has
    none, so the default is object_1, object_2, … A schedule is read from the handler beside it,
    which is called `handler.py` or like the example.

    Raises:
        InputError: in one sentence, with file and line: what is wrong and what is allowed.
    """
    path = Path(path)
    reader = _PeerReader(path)
    pixels, image_hash = read_photo(Path(photo) if photo else photo_beside(path, _PHOTOS))
    size = (pixels.shape[1], pixels.shape[0])
    groundings = reader.groundings("all_object_points", size)
    if not groundings:
        raise reader.fail("all_object_points", "all_object_points must click on some object")
    chosen = [slug(name) for name in names] or [f"object_{i + 1}" for i in range(len(groundings))]
    if len(chosen) != len(groundings) or len(set(chosen)) != len(chosen) or "" in chosen:
        raise InputError(f"{path} has {len(groundings)} objects, so as many names are needed")
    prompt = " ".join(str(reader.data.get("vgen_prompt", "")).split())[:MAX_PROMPT]
    case = Case(
        name=slug(str(reader.data.get("example_name") or path.parent.name)) or "case",
        image=pixels,
        image_hash=image_hash,
        objects=tuple(zip(chosen, groundings, strict=True)),
        supports=reader.supports(size),
        prompt=prompt,
        event="generated" if prompt else "",
        events=(("generated", prompt),) if prompt else (),
    )
    objects, clip, gravity = reader.objects(chosen), reader.clip(), reader.gravity()
    floor_friction = reader.number("plane_friction", 0, 5)
    # A number that none of the materials here asks for is left out too.
    left_out = tuple(
        key
        for key in reader.data
        if key not in reader.asked and (key not in _KNOWN or key in _OF_MATERIALS)
    )
    motion, unread = reader.motion(_handler(path, reader.data), len(chosen))
    return PeerSetup(
        case=case,
        objects=objects,
        clip=clip,
        gravity=gravity,
        floor_friction=floor_friction,
        left_out=(*left_out, *unread),
        motion=motion,
    )


def _handler(path: Path, data: dict[str, Any]) -> Path | None:
    """The handler file that goes with a configuration; None where there is none."""
    names = ("handler.py", f"{slug(str(data.get('example_name') or path.parent.name))}.py")
    return next((path.parent / one for one in names if (path.parent / one).is_file()), None)


def photo_beside(path: Path, names: Sequence[str]) -> Path:
    """The first of these pictures that lies beside a file; raises InputError where none does."""
    for name in names:
        if (path.parent / name).is_file():
            return path.parent / name
    raise InputError(f"there is no photo beside {path} ({', '.join(names)}); name it")


class _PeerReader:
    """One configuration being read; every message carries its file and line."""

    def __init__(self, path: Path) -> None:
        self.path, self.asked = path, set[str]()
        text = text_of(path, MAX_BYTES)
        # Some published files say a thing twice; their reader takes the last word.
        self.doc: PlainYaml = read_yaml(text, str(path), last_wins=True)
        if not isinstance(self.doc.data, dict) or "material_type" not in self.doc.data:
            raise InputError(f"{path} is no configuration of these releases (no material_type)")
        self.data: dict[str, Any] = self.doc.data

    def fail(self, key: str, what: str) -> InputError:
        return InputError(f"{self.path}, line {self.doc.line((key,))}: {what}")

    def number(self, key: str, low: float, high: float) -> float | None:
        """A finite number, kept within what a program allows; None where there is none."""
        self.asked.add(key)
        value = self.data.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(key, f"{key} must be a number, not {value!r}")
        if not math.isfinite(value):
            raise self.fail(key, f"{key} must be finite")
        return float(min(max(value, low), high))

    def groundings(self, key: str, size: tuple[int, int]) -> tuple[Grounding, ...]:
        """Clicks of each object: a list of objects of points [x, y, label]."""
        found = []
        things = self.data.get(key) or []
        if not isinstance(things, list) or len(things) > 200:
            raise self.fail(key, f"{key} must be a list of lists of [x, y, label]")
        for thing in things:
            if not isinstance(thing, list) or not thing or len(thing) > 500:
                raise self.fail(key, f"{key} must be a list of lists of [x, y, label]")
            found.append(Grounding(points=tuple(self._click(key, p, size) for p in thing)))
        return tuple(found)

    def _click(self, key: str, point: Any, size: tuple[int, int]) -> Click:
        numbers = isinstance(point, list) and len(point) == 3
        if not numbers or any(type(v) not in (int, float) for v in point):
            raise self.fail(key, f"a point of {key} must be [x, y, label], not {point!r}")
        x, y, label = point
        check_inside(x, y, size, f"{self.path}, line {self.doc.line((key,))}")
        return Click(x=x, y=y, label=1 if label else 0)

    def supports(self, size: tuple[int, int]) -> tuple[Support, ...]:
        groundings = self.groundings("support_object_points", size)
        names = self.data.get("support_object_names") or []
        given = [slug(str(n)) for n in names] if isinstance(names, list) else []
        return tuple(
            Support(name=(given[i : i + 1] or [""])[0] or f"support_{i + 1}", grounding=grounding)
            for i, grounding in enumerate(groundings)
        )

    def objects(self, names: Sequence[str]) -> tuple[PeerObject, ...]:
        materials = self.data["material_type"]
        if not isinstance(materials, list) or len(materials) != len(names):
            raise self.fail("material_type", f"material_type must list {len(names)} materials")
        for material in materials:
            if material not in _BODIES:
                known = ", ".join(_BODIES)
                raise self.fail("material_type", f"there is no material {material!r} ({known})")
        return tuple(self._object(n, m) for n, m in zip(names, materials, strict=True))

    def _object(self, name: str, material: str) -> PeerObject:
        family = _PREFIX[material.split("_")[0]]
        density = None
        for key in (f"{material}_rho", f"{family}_rho"):
            density = self.number(key, 0.1, 30000) if density is None else density
        friction = self.number("rigid_friction", 0, 5) if family == "rigid" else None
        return PeerObject(name, density, friction, self._body(material))

    def _body(self, material: str) -> dict[str, JsonValue]:
        body: dict[str, JsonValue] = {"kind": _BODIES[material]}
        if body["kind"] in ("soft", "plastic") and material.startswith("mpm"):
            young, poisson = self.number("MPM_E", 10, 1e12), self.number("MPM_nu", 0, 0.49)
            body |= {"young": young} if young is not None else {}
            body |= {"poisson": poisson} if poisson is not None else {}
        if material in _COHESION:
            body["cohesion"] = _COHESION[material]
        if body["kind"] in ("soft", "plastic", "cloth"):
            body["pinned"] = self._pinned()
        return body

    def _pinned(self) -> str:
        """Which side is held: their `fixed_area` is [x0, x1, y0, y1] in shares from the top."""
        self.asked.add("fixed_area")
        areas = self.data.get("fixed_area") or []
        for area in areas if isinstance(areas, list) else []:
            if not isinstance(area, list) or len(area) != 4:
                raise self.fail("fixed_area", "fixed_area must be a list of [x0, x1, y0, y1]")
            x0, x1, y0, y1 = (float(v) if isinstance(v, int | float) else 0.5 for v in area)
            sides = {"top": y1, "bottom": 1 - y0, "left": x1, "right": 1 - x0}
            side = min(sides, key=lambda one: sides[one])
            if sides[side] <= 0.5:
                return side
        return "none"

    def clip(self) -> dict[str, float]:
        """Fields of the program's clip."""
        bounds = {
            "frames": ("simulated_frames_num", 2, 2000),
            "step_seconds": ("dt", 1e-4, 0.1),
            "steps_per_frame": ("frame_steps", 1, 100),
            "substeps": ("substeps", 1, 1000),
        }
        found: dict[str, float] = {}
        for name, (key, low, high) in bounds.items():
            value = self.number(key, low, high)
            if value is not None:
                found[name] = value if name == "step_seconds" else int(value)
        return found

    def motion(self, handler: Path | None, count: int) -> tuple[Motion, tuple[str, ...]]:
        """The schedule of a handler, and what of it is not taken over."""
        if handler is None:
            return NO_MOTION, ()
        clip = self.clip()
        steps = int((clip.get("frames", 81) - 1) * clip.get("steps_per_frame", 1))
        names = next((self.data[key] for key in _NAMES if isinstance(self.data.get(key), list)), [])
        found = read_handler(handler, count, steps, self.data, [str(one) for one in names])
        lifts = tuple((index, (x, y, z)) for index, (x, y, z) in sorted(found.lifts.items()))
        motion = Motion(tuple(found.actions), lifts)
        unread = (*found.left_out, *beyond(motion, steps))
        return motion, tuple(f"{handler.name}, {line}" for line in unread)

    def gravity(self) -> tuple[float, float, float] | None:
        """Their scalar acts along z, or along a given direction; it is negative for downwards."""
        strength = self.number("gravity", -100, 100)
        direction = self.data.get("gravity_direction")
        if direction is None:
            return None if strength is None else (0.0, 0.0, strength)
        good = isinstance(direction, list) and len(direction) == 3
        if not good or any(type(v) not in (int, float) for v in direction):
            raise self.fail("gravity_direction", "gravity_direction must be [x, y, z]")
        length = math.sqrt(sum(v * v for v in direction))
        if not 0 < length < math.inf:
            raise self.fail("gravity_direction", "gravity_direction must not be zero")
        pull = (-9.8 if strength is None else strength) / length
        x, y, z = (v * pull for v in direction)
        return (x + 0.0, y + 0.0, z + 0.0)
