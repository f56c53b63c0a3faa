"""What a browser may ask about mesh files: to read one, and to set down what was read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program import Frozen
from physagent_studio.program.base import Length

Ticket = Annotated[int, Field(ge=0, le=2**53)]
FileName = Annotated[str, Field(min_length=1, max_length=200)]


class ReadMesh(Frozen):
    """What is in a mesh file (base64 of its bytes); nothing is changed yet."""

    do: Literal["read_mesh"] = "read_mesh"
    file: FileName
    data: Annotated[str, Field(max_length=23_000_000)]
    ticket: Ticket


class AddMesh(Frozen):
    """Sets down what was read last, `longest` metres long, on the chosen support or the ground."""

    do: Literal["add_mesh"] = "add_mesh"
    name: Annotated[str, Field(min_length=1, max_length=200)]
    longest: Annotated[Length, Field(ge=0.001, le=1000)]
    up: Literal["y", "z"]


MeshIntent = ReadMesh | AddMesh
