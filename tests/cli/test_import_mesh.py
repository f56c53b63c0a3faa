"""Meshes with textures become programs, run, and are drawn with what they brought."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import SimpleMaterial
from typer.testing import CliRunner

from physagent_studio.cli.app import app
from physagent_studio.cli.files import read_program
from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import Meshed
from physagent_studio.reconstruction.backends.mesh_files import textured_from
from physagent_studio.records import Scene
from physagent_studio.records.rollout_io import rollout_from_bytes
from physagent_studio.rendering import Compositor
from physagent_studio.session import Store
from physagent_studio.session.arrays import unpack_mesh
from physagent_studio.workbench import Workbench, commands
from physagent_studio.workbench.mesh_edits import forms_beside

RED, BLUE = (230, 20, 30), (20, 40, 220)


def textured() -> trimesh.Trimesh:
    """A box of .2 × .3 × .25 m whose picture is red to the left and blue to the right."""
    box = trimesh.creation.box((0.2, 0.3, 0.25))
    picture = np.zeros((32, 64, 3), np.uint8)
    picture[:, :32], picture[:, 32:] = RED, BLUE
    # x decides; shifted by a repetition, which is the same place of the picture.
    uv = np.stack([box.vertices[:, 0] / 0.2 + 0.5, np.full(8, 0.5)], 1) * (0.8, 1) + (1.1, 0)
    return trimesh.Trimesh(
        box.vertices,
        box.faces,
        process=False,
        visual=TextureVisuals(uv=uv, image=Image.fromarray(picture)),
    )


def written(folder: Path, kind: str) -> Path:
    path = folder / f"toy.{kind}"
    textured().export(str(path))
    return path


def run(*words: object) -> tuple[int, str]:
    found = CliRunner().invoke(app, [str(word) for word in words])
    return found.exit_code, " ".join(found.output.split())


@pytest.mark.parametrize("kind", ["glb", "obj"])
def test_a_textured_mesh_becomes_a_program_that_runs_and_is_drawn(
    kind: str, tmp_path: Path
) -> None:
    out = tmp_path / "into" / "program.yaml"
    code, said = run("import", written(tmp_path, kind), "--out", out)
    assert (code, "0.3 m long, y up, with its colours" in said) == (0, True), said
    program = read_program(out)
    item = program.scene.object("toy")
    assert item is not None
    assert isinstance(item.shape, Meshed)
    # glTF's y is up: what was 0.3 along y stands now, on the floor.
    assert item.shape.size == pytest.approx((0.2, 0.25, 0.3))
    assert item.position == pytest.approx((0, 0, 0.15))
    code, said = run("simulate", out, "--out", tmp_path / "rollout.npz")
    assert code == 0, said
    assert (
        np.ptp(
            rollout_from_bytes((tmp_path / "rollout.npz").read_bytes()).positions[:, 0], axis=0
        ).max()
        < 1e-3
    )
    workbench = Workbench(Store(tmp_path / "home"), evidence=False)
    workbench.post(commands.OpenProgram(program, "toy", forms_beside(out, program)))
    workbench.post(commands.Step())
    assert workbench.wait(60)
    scene = workbench.snapshot().scene
    workbench.close()
    assert isinstance(scene, Scene)
    frame = Compositor(scene).frame(shadows=False)
    rows, columns = np.nonzero(frame.ids == 0)
    middle = columns.mean()
    for colour, side in ((RED, columns < middle - 5), (BLUE, columns > middle + 5)):
        seen = frame.rgb[rows[side], columns[side]]
        assert np.abs(np.median(seen, axis=0) - colour).max() < 4


def test_several_pictures_and_colours_become_one_texture() -> None:
    first, second, third = textured(), textured(), trimesh.creation.icosphere(2, 0.1)
    for place, part in enumerate((first, second, third)):
        part.apply_translation((0.5 * place, 0, 0))
    assert isinstance(second.visual, TextureVisuals)
    green = Image.fromarray(np.full((16, 16, 3), (10, 200, 10), np.uint8))
    second.visual.material = SimpleMaterial(image=green)
    third.visual = ColorVisuals(third, face_colors=(250, 240, 10, 255))
    data = trimesh.Scene([first, second, third]).export(file_type="glb")
    assert isinstance(data, bytes)
    mesh = textured_from(data, "a.glb")
    assert mesh.texture is not None
    assert mesh.uv is not None
    middles = mesh.uv[mesh.faces].mean(1).astype(int)
    seen = mesh.texture[middles[:, 1], middles[:, 0]].astype(int)
    x = mesh.vertices[mesh.faces].mean(1)[:, 0]
    for colour, there in (
        (RED, x < -0.09),
        ((10, 200, 10), (x > 0.4) & (x < 0.6)),
        ((250, 240, 10), x > 0.9),
    ):
        assert np.abs(seen[there] - colour).max() < 3


def test_what_lies_beside_a_program_is_checked(tmp_path: Path) -> None:
    out = tmp_path / "program.yaml"
    run("import", written(tmp_path, "glb"), "--out", out)
    program = read_program(out)
    (stored,) = forms_beside(out, program)
    file = tmp_path / f"{stored}.mesh.npz"
    whole = file.read_bytes()
    file.write_bytes(whole + b"x")
    with pytest.raises(InputError, match="was changed"):
        forms_beside(out, program)
    file.unlink()
    code, said = run("simulate", out, "--out", tmp_path / "rollout.npz")
    assert (code, "is not kept here" in said) == (2, True)


def test_files_elsewhere_and_large_pictures_are_not_read(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    path = written(tmp_path / "in", "obj")
    (material,) = path.parent.glob("*.mtl")
    (picture,) = path.parent.glob("*.png")
    material.write_text(material.read_text().replace(picture.name, f"../{picture.name}"))
    picture.rename(tmp_path / picture.name)
    out = tmp_path / "program.yaml"
    code, said = run("import", path, "--out", out)
    assert code == 0, said
    (stored,) = forms_beside(out, read_program(out)).values()
    texture = unpack_mesh(stored).texture
    assert texture is not None
    # The material has a colour, and its picture is out of reach.
    assert len(np.unique(texture.reshape(-1, 3), axis=0)) == 1
    glb = written(tmp_path, "glb")
    data = glb.read_bytes()
    at = data.index(b"IHDR") + 4
    glb.write_bytes(data[:at] + (30_000).to_bytes(4, "big") * 2 + data[at + 8 :])
    code, said = run("import", glb, "--out", tmp_path / "program.yaml")
    assert (code, "pixels of textures" in said) == (2, True), said
