"""Objects from mesh files: read beside the worker, shown to the person, then set down."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.studio.intents import mesh as intents_mesh
from physagent_studio.studio.panels.spots import spot_of
from physagent_studio.studio.view import Selection
from physagent_studio.workbench import commands
from physagent_studio.workbench.mesh_edits import Form, name_for, read_form

if TYPE_CHECKING:
    from physagent_studio.studio.commands.actions import Studio

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


def read_mesh(intent: intents_mesh.ReadMesh, studio: Studio, browser: int) -> None:
    """Reads a mesh file; the page hears of it on `mesh`."""
    desk, usual = studio.mesh_desk, spot_of(studio.snapshot.program, studio.view.selection).size

    def find() -> dict[str, Any]:
        try:
            data = base64.b64decode(intent.data, validate=True)
        except binascii.Error as error:
            raise InputError("the file did not arrive whole; try again") from error
        if len(data) > FILE_BYTES:
            size = len(data) / 2**20
            raise InputError(f"{intent.file} has {size:.1f} MB; at most 16 are allowed")
        return desk.read(browser, data, intent.file, usual)

    studio.finder.ask(browser, "mesh", intent.ticket, find)


def add_mesh(intent: intents_mesh.AddMesh, studio: Studio, browser: int) -> None:
    """Sets down what was read, and selects it."""
    snapshot = studio.snapshot
    if snapshot.read_only:
        raise InputError("an earlier round is open read-only; go on from here to edit it")
    form = studio.mesh_desk.form(browser)
    name = name_for(snapshot.program, intent.name)
    spot = spot_of(snapshot.program, studio.view.selection)
    body = form.body(name, intent.longest, intent.up)
    studio.workbench.post(commands.AddMesh(name, body, spot.foot, spot.on))
    studio.mesh_desk.forget(browser)
    studio.set_view(replace(studio.view, selection=Selection("object", name)))


ACTIONS: dict[type, Callable[..., None]] = {
    intents_mesh.ReadMesh: read_mesh,
    intents_mesh.AddMesh: add_mesh,
}
"""What each intent does."""
