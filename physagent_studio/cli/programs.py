"""Commands on files: programs and cases, without a session."""

import hashlib
from pathlib import Path

import cv2
import typer

from physagent_studio.cli import output
from physagent_studio.cli.guard import NOT_REALISED
from physagent_studio.cli.targets import case_of, with_horizon
from physagent_studio.contract import measure
from physagent_studio.errors import InputError
from physagent_studio.exchange.files import bytes_of, written
from physagent_studio.exchange.peers.mjcf import load_mjcf
from physagent_studio.program import PhysicalProgram, SceneState, Support, apply
from physagent_studio.program.scene.state import Floor
from physagent_studio.program.text.document import dump_program
from physagent_studio.reconstruction.backends.mesh_files import KINDS, MESH
from physagent_studio.records import Case
from physagent_studio.records.rollout_io import save_rollout
from physagent_studio.session.arrays import pack_mesh, unpack_mesh
from physagent_studio.session.session import MESH_SUFFIX
from physagent_studio.workbench.mesh_edits import (
    adding,
    forms_beside,
    materials_beside,
    name_for,
    read_form,
)

USUAL = 0.3
"""Metres across of a thing whose file says nothing that can be meant as metres."""


def import_scene(path: Path, out: Path) -> list[str]:
    """Writes the program of an MJCF, URDF or mesh file; a line on what is left out or guessed."""
    if path.suffix.lower() in KINDS:
        return _import_mesh(path, out)
    program, left_out = load_mjcf(path)
    with written(out) as partial:
        partial.write_text(dump_program(program), encoding="utf-8")
    return [*(f"not taken over: {line}" for line in left_out), f"wrote {out}"]


def _import_mesh(path: Path, out: Path) -> list[str]:
    """Writes a program of the form of a mesh file on the floor, and the form beside it."""
    form = read_form(bytes_of(path, MESH.max_bytes), path.name, materials_beside(path))
    floor = SceneState(supports=(Support(name="floor", shape=Floor()),))
    bare = PhysicalProgram(scene=floor)
    name, longest = name_for(bare, path.stem), form.believed(USUAL)
    body = form.body(name, longest, form.up)
    data = pack_mesh(body)
    asset = hashlib.sha256(data).hexdigest()
    program = apply(bare, adding(name, body, asset, (0.0, 0.0, 0.0), "floor"))
    stored = out.with_name(asset + MESH_SUFFIX)
    for place, content in ((stored, data), (out, dump_program(program).encode())):
        with written(place) as partial:
            partial.write_bytes(content)
    skin = "its colours" if body.texture is not None else "no colours that are read"
    said = f"{name}: {len(body.faces)} triangles, {longest:g} m long, {form.up} up, with {skin}"
    return [said, f"wrote {out} and, for it, {stored.name}"]


def simulate_program(program: PhysicalProgram, path: Path, out: Path, as_json: bool) -> int:
    """Runs the program of a file and saves the rollout; the exit code."""
    from physagent_studio.reconstruction import reconstruct
    from physagent_studio.simulation import simulate

    forms = {name: unpack_mesh(data) for name, data in forms_beside(path, program).items()}
    scene = reconstruct(Case(path.stem, prompt=program.event.prompt), program.scene, assets=forms)
    program = program.model_copy(update={"scene": scene.state})
    rollout = simulate(program, scene.meshes)
    try:
        save_rollout(out, rollout)
    except OSError as error:
        raise InputError(f"{out} cannot be written: {error.strerror}") from error
    checks = measure(program, rollout)
    if as_json:
        rows = [check.model_dump(mode="json") for check in checks]
        blown = rollout.blown_up.text if rollout.blown_up else None
        output.print_json({"out": str(out), "checks": rows, "blown_up": blown})
    else:
        output.print_checks(checks)
        for alarm in rollout.warnings:
            typer.echo(f"  step {alarm.step}: {alarm.text}")
        typer.echo(f"wrote {out}")
    return NOT_REALISED if rollout.blown_up else 0


def reconstruct_case(
    target: str,
    sheet: Path,
    prompt: str = "",
    objects: tuple[str, ...] = (),
    horizon: float | None = None,
) -> Path:
    """Reconstructs a case, or a photo with what it shows, and writes its contact sheet."""
    from physagent_studio.reconstruction.contact_sheet import contact_sheet
    from physagent_studio.reconstruction.learned.at_hand import learned_here
    from physagent_studio.workbench.first import first_program

    # Before the work, not after it.
    if sheet.suffix.lower() != ".png" or not sheet.parent.is_dir():
        raise InputError(f"{sheet} cannot be written; it must be a .png in a folder that exists")
    case = with_horizon(case_of(target, None, prompt, objects), target, horizon)
    picture = contact_sheet(first_program(case, learned_here())[1])
    if not cv2.imwrite(str(sheet), picture[..., ::-1]):
        raise InputError(f"{sheet} cannot be written; its folder must be writable")
    return sheet
