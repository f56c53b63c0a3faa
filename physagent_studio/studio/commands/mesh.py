"""Objects from mesh files: read beside the worker, shown to the person, then set down."""

from __future__ import annotations

import base64
import binascii
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from physagent_studio.errors import InputError
from physagent_studio.studio.commands.asking import FileText, Id, Ticket, asked
from physagent_studio.studio.commands.program import open_program
from physagent_studio.studio.panels.scene import spot_of
from physagent_studio.studio.view import Selection
from physagent_studio.workbench import commands
from physagent_studio.workbench.mesh_edits import Form, name_for, read_form

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

FILE_BYTES = 16 * 2**20
"""Largest file that fits into a message of the browser's, bytes."""

KEPT = 4
"""Browsers whose form is kept, the last ones."""


class MeshDesk:
    """The form that each browser has read last; written by the finder's thread."""

    def __init__(self) -> None:
        self._forms: dict[int, Form] = {}

    def read(self, browser: int, data: bytes, file: str, usual: float) -> dict[str, Any]:
        """Reads a file for a browser. usual: size of the things in the scene, m."""
        self._forms.pop(browser, None)
        form = read_form(data, file)
        while len(self._forms) >= KEPT:
            self._forms.pop(next(iter(self._forms)), None)
        self._forms[browser] = form
        return {
            "faces": len(form.mesh.faces),
            "size": [float(f"{part:.3g}") for part in np.ptp(form.mesh.vertices, axis=0)],
            "longest": form.believed(usual),
            "up": form.up,
        }

    def form(self, browser: int) -> Form:
        """What a browser has read."""
        if browser not in self._forms:
            raise InputError("choose a mesh file first")
        return self._forms[browser]

    def forget(self, browser: int) -> None:
        """Lets go of what a browser has read."""
        self._forms.pop(browser, None)


@asked("read_mesh")
def read_mesh(studio: Studio, browser: int, file: Id, data: FileText, ticket: Ticket) -> None:
    """What is in a mesh file (base64 of its bytes); the page hears of it on `mesh`."""
    desk, usual = studio.mesh_desk, spot_of(studio.snapshot.program, studio.view.selection).size

    def find() -> dict[str, Any]:
        try:
            raw = base64.b64decode(data, validate=True)
        except binascii.Error as error:
            raise InputError("the file did not arrive whole; try again") from error
        if len(raw) > FILE_BYTES:
            raise InputError(f"{file} has {len(raw) / 2**20:.1f} MB; at most 16 are allowed")
        return desk.read(browser, raw, file, usual)

    studio.finder.ask(browser, "mesh", ticket, find)


@asked("add_mesh")
def add_mesh(
    studio: Studio,
    browser: int,
    name: Id,
    longest: Annotated[float, Field(ge=0.001, le=1000)],
    up: Literal["y", "z"],
) -> None:
    """Sets down what was read last, `longest` m long, on the chosen support or the ground."""
    program = open_program(studio)
    form = studio.mesh_desk.form(browser)
    name = name_for(program, name)
    spot = spot_of(program, studio.view.selection)
    studio.workbench.post(commands.AddMesh(name, form.body(name, longest, up), spot.foot, spot.on))
    studio.mesh_desk.forget(browser)
    studio.set_view(replace(studio.view, selection=Selection("object", name)))
