"""Networks of a few layers as ONNX files, encoded by hand: protocol buffers without a library.

Field numbers are those of onnx/onnx.proto: https://github.com/onnx/onnx/blob/main/onnx/onnx.proto
"""

import hashlib
from dataclasses import replace

import numpy as np

from physagent_studio.reconstruction.learned import zoo

FLOAT, INT64 = 1, 7
OPSET = 13


def number(value):
    """A base-128 varint."""
    out = bytearray()
    while True:
        low, value = value & 127, value >> 7
        out.append(low | (128 if value else 0))
        if not value:
            return bytes(out)


def field(tag, value):
    """A field with a number (wire type 0), or with text, bytes or a message (wire type 2)."""
    if isinstance(value, int):
        return number(tag << 3) + number(value)
    data = value.encode() if isinstance(value, str) else value
    return number(tag << 3 | 2) + number(len(data)) + data


def tensor(name, values):
    values = np.asarray(values)
    kind = INT64 if values.dtype == np.int64 else FLOAT
    data = values.astype(np.int64 if kind == INT64 else np.float32).tobytes()
    dims = b"".join(field(1, size) for size in values.shape)
    return dims + field(2, kind) + field(8, name) + field(9, data)


def value_info(name, shape):
    dims = b"".join(field(1, field(1, size)) for size in shape)
    return field(1, name) + field(2, field(1, field(1, FLOAT) + field(2, dims)))


def node(kind, inputs, output):
    parts = b"".join(field(1, name) for name in inputs)
    return parts + field(2, output) + field(3, f"make_{output}") + field(4, kind)


def model(nodes, inputs, outputs, constants):
    """nodes: (kind, inputs, output). inputs, outputs: name → shape. constants: name → array."""
    graph = b"".join(field(1, node(*one)) for one in nodes) + field(2, "small")
    graph += b"".join(field(5, tensor(name, value)) for name, value in constants.items())
    graph += b"".join(field(11, value_info(*one)) for one in inputs.items())
    graph += b"".join(field(12, value_info(*one)) for one in outputs.items())
    return field(1, 8) + field(7, graph) + field(8, field(1, "") + field(2, OPSET))


def small_efficientsam(
    *, at=0.5, coords=None, labels=None, base=(0.0, 0.0, 0.0), side=1024, mask_shape=None
):
    """Masks where red, green and blue are above `at`; predicted IoUs linear in what was clicked.

    coords (12, 3), labels (6, 3): what x and y of each point, and its label, count for each IoU.
    """
    shape = np.array(mask_shape or (1, 1, 3, side, side), np.int64)
    return model(
        [
            ("Sub", ["batched_images", "threshold"], "above"),
            ("Reshape", ["above", "mask_shape"], "output_masks"),
            ("Reshape", ["batched_point_coords", "row"], "flat_coords"),
            ("Reshape", ["batched_point_labels", "row"], "flat_labels"),
            ("MatMul", ["flat_coords", "of_coords"], "by_coords"),
            ("MatMul", ["flat_labels", "of_labels"], "by_labels"),
            ("Add", ["by_coords", "by_labels"], "by_points"),
            ("Add", ["by_points", "base"], "iou_row"),
            ("Reshape", ["iou_row", "iou_shape"], "iou_predictions"),
        ],
        {
            "batched_images": (1, 3, side, side),
            "batched_point_coords": (1, 1, 6, 2),
            "batched_point_labels": (1, 1, 6),
        },
        {"output_masks": tuple(int(n) for n in shape), "iou_predictions": (1, 1, 3)},
        {
            "threshold": np.full((1, 1, 1, 1), at, np.float32),
            "mask_shape": shape,
            "row": np.array([1, -1], np.int64),
            "of_coords": np.zeros((12, 3)) if coords is None else coords,
            "of_labels": np.zeros((6, 3)) if labels is None else labels,
            "base": np.array([base], np.float32),
            "iou_shape": np.array([1, 1, 3], np.int64),
        },
    )


def small_lama(colour=(0.1, 0.5, 0.9), side=512):
    """The picture with one colour, in the network's own channel order, where the mask is 1."""
    return model(
        [
            ("Sub", ["one", "mask"], "kept"),
            ("Mul", ["image", "kept"], "outside"),
            ("Mul", ["colour", "mask"], "inside"),
            ("Add", ["outside", "inside"], "filled"),
            ("Mul", ["filled", "white"], "output"),
        ],
        {"image": (1, 3, side, side), "mask": (1, 1, side, side)},
        {"output": (1, 3, side, side)},
        {
            "one": np.ones((1, 1, 1, 1), np.float32),
            "white": np.full((1, 1, 1, 1), 255, np.float32),
            "colour": np.array(colour, np.float32).reshape(1, 3, 1, 1),
        },
    )


def put(monkeypatch, folder, name, data):
    """Makes a small network the file of a model: in its place, under its own size and SHA-256."""
    known = replace(zoo.ZOO[name], size=len(data), sha256=hashlib.sha256(data).hexdigest())
    monkeypatch.setitem(zoo.ZOO, name, known)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / known.file).write_bytes(data)
    return folder / known.file
