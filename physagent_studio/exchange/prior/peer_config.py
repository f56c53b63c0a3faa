"""The scene as a `config.yaml` of PhysAgent and RealWonder, with its picture."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.prior.folder import MAX_PROGRAM, Prior
from physagent_studio.exchange.prior.generators import SDEDIT
from physagent_studio.exchange.prior.stretches import Sink
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.bodies import Body, Granular, Plastic, Soft
from physagent_studio.program.scene.state import Grounding
from physagent_studio.program.text.document import load_program

_MATERIALS = {
    "rigid": "rigid",
    "cloth": "pbd_cloth",
    "liquid": "mpm_liquid",
    "plastic": "mpm_elastic2plastic",
    "granular": "mpm_sand",
}
_DENSITIES = {"rigid": "rigid_rho", "pbd_cloth": "pbd_rho", "pbd_elastic": "pbd_elastic_rho"}
_AREAS = {
    "top": [0, 1, 0, 0.2],
    "bottom": [0, 1, 0.8, 1],
    "left": [0, 0.2, 0, 1],
    "right": [0.8, 1, 0, 1],
}
"""What is held, as [x0, x1, y0, y1] in shares from the top left."""
_THEIRS: dict[str, Any] = {
    "device": "cuda", "seed": 0, "segmenter": "sam2", "obj_kp_matching": True, "debug": False,
    "stitched_inpainting": False, "target_faces": 10000,
    "particle_size": 0.015, "MPM_grid_density": 48, "alpha_threshold": 0.99, "crop_start": 176,
    "fg_points_render_radius": 0.02, "use_rgb_frontside": False, "num_output_frames": 21,
}  # fmt: skip
"""What only concerns how they look at the picture, as most of their published files have it."""


def peer_config(prior: Prior, out: Path) -> str:
    """`config.yaml` and `input.png`; what to know of it.

    Their format has one density and one friction for all things of a material; where ours differ
    the first one's counts, and the others are named.
    """
    program = load_program(text_of(prior.folder / "program.yaml", MAX_PROGRAM))
    data, left_out = config_of(program, prior)
    sink = Sink(out)
    sink.data("input.png", prior.png("frames/frame", 0))
    sink.text("config.yaml", yaml.safe_dump(data, sort_keys=False, allow_unicode=True))
    if program.event.actions:
        left_out.append("the schedule of actions, which there is Python")
    left = f"; left out: {', '.join(left_out)}" if left_out else ""
    return f"the scene as a configuration of PhysAgent and RealWonder{left}"


def config_of(program: PhysicalProgram, prior: Prior | None) -> tuple[dict[str, Any], list[str]]:
    """Their configuration of a program, and what of it has no place there.

    prior: tells where a thing is that nobody has clicked.
    """
    scene, clip = program.scene, program.clip
    left_out: list[str] = []
    materials = [_material(item.body) for item in scene.objects]
    for item, material in zip(scene.objects, materials, strict=True):
        if item.body.kind not in _MATERIALS and not isinstance(item.body, Soft):
            left_out.append(f"{item.name} is of a kind that they have not ({material} instead)")
    supports = [one for one in scene.supports if one.grounding.points]
    name = "_".join(program.event.prompt.split()[:6]) or "scene"
    data: dict[str, Any] = {
        "example_name": name,
        "output_folder": f"result/{name}",
        "data_path": f"cases/{name}/",
        "all_object_points": [_points(item.name, item.grounding, prior) for item in scene.objects],
        "all_object_masks_idx": [0] * len(materials),
        "object_names": [item.name for item in scene.objects],
        "dt": clip.step_seconds,
        "substeps": clip.substeps,
        "simulated_frames_num": clip.frames,
        "frame_steps": clip.steps_per_frame,
        "material_type": materials,
    }
    if supports:
        data["support_object_points"] = [_points(s.name, s.grounding, prior) for s in supports]
        data["support_object_names"] = [one.name for one in supports]
    strength = float(np.linalg.norm(scene.gravity))
    data["gravity"] = -strength
    if scene.gravity[:2] != (0, 0) or scene.gravity[2] > 0:
        data["gravity_direction"] = [-part / strength + 0.0 for part in scene.gravity]
    floor = scene.support("floor")
    if floor is not None and floor.friction is not None:
        data["plane_friction"] = floor.friction
    for item, material in zip(scene.objects, materials, strict=True):
        for key, value in _numbers(material, item.density, item.friction, item.body).items():
            if data.setdefault(key, value) != value:
                left_out.append(f"{key} of {item.name} ({value:g})")
        pinned = getattr(item.body, "pinned", "none")
        if pinned in _AREAS:
            data.setdefault("fixed_area", [_AREAS[pinned]])
        elif pinned != "none":
            left_out.append(f"what holds {item.name} ({pinned})")
    return data | _THEIRS | SDEDIT | {"vgen_prompt": program.event.prompt}, left_out


def _material(body: Body) -> str:
    if isinstance(body, Soft):
        # Theirs by position-based dynamics has no stiffness: what says none is that.
        stated = (body.young, body.poisson) != (Soft().young, Soft().poisson)
        return "mpm_elastic" if stated else "pbd_elastic"
    if isinstance(body, Granular) and body.cohesion > 0:
        return "mpm_snow"
    return _MATERIALS.get(body.kind, "rigid")


def _numbers(
    material: str, density: float | None, friction: float | None, body: Body
) -> dict[str, float]:
    """What a thing adds to the configuration."""
    family = material.split("_")[0]
    found = {
        _DENSITIES.get(material, "MPM_rho"): density,
        "rigid_friction": friction if family == "rigid" else None,
    }
    if isinstance(body, Soft | Plastic) and family == "mpm":
        found |= {"MPM_E": body.young, "MPM_nu": body.poisson}
    return {key: value for key, value in found.items() if value is not None}


def _points(name: str, grounding: Grounding, prior: Prior | None) -> list[list[float]]:
    """[x, y, label] of its clicks, else the middle of its box or of where it is seen."""
    if grounding.points:
        return [[point.x, point.y, point.label] for point in grounding.points]
    if grounding.box is not None:
        left, top, right, bottom = grounding.box
        return [[(left + right) / 2, (top + bottom) / 2, 1]]
    if prior is None or name not in prior.meta["objects"]:
        return []
    rows, columns = np.nonzero(prior.ids(0) == prior.meta["objects"].index(name))
    middle = len(rows) // 2
    return [[int(columns[middle]), int(rows[middle]), 1]] if len(rows) else []
