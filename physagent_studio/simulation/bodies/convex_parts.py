"""Convex decomposition of concave meshes by CoACD, in a process of its own.

CoACD (Wei et al. 2022) is optional: `pip install 'physagent-studio[convex]'`. It takes seconds
per mesh, which the simulator keeps.
"""

import importlib.util
import io
import os
import subprocess
import sys
import zipfile

import numpy as np

from physagent_studio.simulation.surfaces import Surface

THRESHOLD = 0.05
"""Concavity that a part may keep, CoACD's own measure."""

MAX_PARTS = 32
SECONDS = 120.0
"""A decomposition that takes longer is given up."""


def is_available() -> bool:
    """Whether the extra `convex` is installed."""
    return importlib.util.find_spec("coacd") is not None


def split(surface: Surface) -> tuple[Surface, ...] | None:
    """Convex parts of a surface, or None where CoACD is missing or found none."""
    return (_unpacked(_run(surface)) or None) if is_available() else None


def _run(surface: Surface) -> bytes:
    """The worker's answer; empty where it failed."""
    command = [sys.executable, "-m", "physagent_studio.simulation.bodies.convex_parts"]
    environment = {**os.environ, "OMP_NUM_THREADS": "2"}
    try:
        done = subprocess.run(
            command,
            input=_packed([surface]),
            capture_output=True,
            timeout=SECONDS,
            env=environment,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return b""
    return done.stdout if done.returncode == 0 else b""


def _packed(surfaces: list[Surface]) -> bytes:
    stream = io.BytesIO()
    arrays = {}
    for number, (vertices, faces) in enumerate(surfaces):
        arrays[f"v{number}"], arrays[f"f{number}"] = vertices, faces
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def _unpacked(data: bytes) -> tuple[Surface, ...]:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            count = len(archive.files) // 2
            return tuple((archive[f"v{n}"], archive[f"f{n}"]) for n in range(count))
    except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile):
        return ()


def main() -> None:
    """The worker: one surface on standard input, its convex parts on standard output."""
    import coacd

    surface = _unpacked(sys.stdin.buffer.read())[0]
    # CoACD logs to standard output, which carries the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    coacd.set_log_level("error")
    parts = coacd.run_coacd(
        coacd.Mesh(*surface), threshold=THRESHOLD, max_convex_hull=MAX_PARTS, seed=0
    )
    found = [(np.asarray(v, float), np.asarray(f, np.int32)) for v, f in parts]
    with os.fdopen(answer, "wb") as stream:
        stream.write(_packed(found))


if __name__ == "__main__":
    main()
