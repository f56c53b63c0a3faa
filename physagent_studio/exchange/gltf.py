"""Binary glTF 2.0, written part by part.

Source: Khronos glTF 2.0 specification, sections 3.6 (accessors) and 4.4 (GLB).
"""

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

UNLIT = "KHR_materials_unlit"
"""The extension of materials that carry their own light, as photographs do."""
_COMPONENTS = {"float32": 5126, "uint32": 5125, "uint16": 5123, "uint8": 5121}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_JSON, _BIN = 0x4E4F534A, 0x004E4942
VERTICES, INDICES = 34962, 34963
"""Targets of buffer views that hold vertex attributes and indices."""


@dataclass(slots=True)
class GltfWriter:
    """Collects one glTF document; `glb()` gives its bytes.

    Every `add_*` returns the index by which other parts refer to what was added.
    """

    document: dict[str, Any] = field(
        default_factory=lambda: {"asset": {"version": "2.0", "generator": "physagent-studio"}}
    )
    binary: bytearray = field(default_factory=bytearray)

    def add(self, room: str, item: dict[str, Any]) -> int:
        """Append to one of the document's arrays (`nodes`, `meshes`, …)."""
        items = self.document.setdefault(room, [])
        items.append(item)
        return len(items) - 1

    def add_bytes(self, data: bytes, target: int | None = None) -> int:
        """A buffer view over these bytes, aligned to four."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.binary += data
        return self.add("bufferViews", view)

    def add_array(self, values: NDArray[Any], target: int | None = None) -> int:
        """An accessor over (N,) or (N, k) float32 or unsigned values, with its bounds."""
        values = np.ascontiguousarray(values)
        columns = 1 if values.ndim == 1 else values.shape[1]
        flat = values.reshape(len(values), columns)
        accessor: dict[str, Any] = {
            "bufferView": self.add_bytes(values.tobytes(), target),
            "componentType": _COMPONENTS[values.dtype.name],
            "count": len(values),
            "type": _SHAPES[columns],
        }
        if len(values):
            accessor["min"] = flat.min(0).tolist()
            accessor["max"] = flat.max(0).tolist()
        return self.add("accessors", accessor)

    def extension(self, name: str) -> None:
        """Note that the document uses an extension."""
        used = self.document.setdefault("extensionsUsed", [])
        if name not in used:
            used.append(name)

    def glb(self) -> bytes:
        """The whole file."""
        self.document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.binary) + b"\0" * (-len(self.binary) % 4)
        total = 12 + 8 + len(text) + 8 + len(binary)
        parts = [struct.pack("<4sII", b"glTF", 2, total)]
        for kind, chunk in ((_JSON, text), (_BIN, binary)):
            parts += [struct.pack("<II", len(chunk), kind), chunk]
        return b"".join(parts)
