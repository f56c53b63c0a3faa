"""A rollout as one compressed archive: plain arrays and JSON, no pickle, no MuJoCo needed."""

import dataclasses
import hashlib
import io
import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.records.rollout import CONTACT_DTYPE, ActionSpan, Alarm, Release, Rollout

FORMAT = 1
ARRAYS = (
    "positions",
    "rotations",
    "velocities",
    "angular",
    "kinetic",
    "potential",
    "masses",
    "penetration",
)


def rollout_to_bytes(rollout: Rollout) -> bytes:
    """The archive's bytes; the same rollout gives the same bytes."""
    meta = {
        "format": FORMAT,
        "program_hash": rollout.program_hash,
        "objects": rollout.objects,
        "bodies": rollout.bodies,
        "step_seconds": rollout.step_seconds,
        "steps_per_frame": rollout.steps_per_frame,
        "frames": rollout.frames,
        "spans": [dataclasses.asdict(item) for item in rollout.spans],
        "warnings": [dataclasses.asdict(item) for item in rollout.warnings],
        "versions": rollout.versions,
        "soft": [name for name, _ in rollout.vertices],
        "releases": [dataclasses.asdict(item) for item in rollout.releases],
        "memories": rollout.memories,
        "actions": rollout.actions,
        "setting": rollout.setting,
    }
    arrays: dict[str, NDArray[Any]] = {name: getattr(rollout, name) for name in ARRAYS}
    # One plain column per field: structured arrays compress worse and read back less widely.
    for field in CONTACT_DTYPE.names or ():
        arrays[f"contacts.{field}"] = rollout.contacts[field]
    if rollout.snapshots is not None:
        arrays["snapshots"] = rollout.snapshots
    for index, (_, vertices) in enumerate(rollout.vertices):
        arrays[f"vertices.{index}"] = vertices
    meta["sha256"] = _digest(arrays, meta)
    arrays["meta"] = np.frombuffer(json.dumps(meta, sort_keys=True).encode(), np.uint8)
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def rollout_from_bytes(data: bytes) -> Rollout:
    """The rollout in an archive, or an `InputError` where it is not one."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        meta = json.loads(arrays["meta"].tobytes())
    except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"this is not a rollout file: {error}") from error
    if meta.get("format") != FORMAT:
        raise InputError(f"rollout format {meta.get('format')} is not known; this reads {FORMAT}")
    said = meta.pop("sha256", None)
    del arrays["meta"]
    # The first rollouts had no hash.
    if said not in (None, _digest(arrays, meta)):
        raise InputError("this rollout file is damaged: its content does not match its hash")
    try:
        return _rollout(meta, arrays)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"this rollout file lacks something or is of another form: {error}") from (
            error
        )


def _rollout(meta: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Rollout:
    """What was told later than format 1 is optional."""
    return Rollout(
        program_hash=meta["program_hash"],
        objects=tuple(meta["objects"]),
        bodies=tuple(meta["bodies"]),
        step_seconds=meta["step_seconds"],
        steps_per_frame=meta["steps_per_frame"],
        frames=meta["frames"],
        contacts=_contacts(arrays),
        spans=tuple(ActionSpan(**item) for item in meta["spans"]),
        warnings=tuple(Alarm(**item) for item in meta["warnings"]),
        versions=tuple((name, version) for name, version in meta["versions"]),
        vertices=tuple((name, arrays[f"vertices.{i}"]) for i, name in enumerate(meta["soft"])),
        releases=tuple(Release(**item) for item in meta.get("releases", ())),
        snapshots=arrays.get("snapshots"),
        memories=tuple(meta.get("memories", ())),
        actions=tuple((name, text) for name, text in meta.get("actions", ())),
        setting=meta.get("setting", ""),
        **{name: arrays[name] for name in ARRAYS},
    )


def _digest(arrays: dict[str, NDArray[Any]], meta: dict[str, Any]) -> str:
    """SHA-256 of everything in an archive but this hash itself."""
    found = hashlib.sha256(json.dumps(meta, sort_keys=True).encode())
    for name in sorted(arrays):
        found.update(f"{name}{arrays[name].dtype.str}{arrays[name].shape}".encode())
        found.update(np.ascontiguousarray(arrays[name]).tobytes())
    return found.hexdigest()


def _contacts(arrays: dict[str, NDArray[Any]]) -> NDArray[np.void]:
    contacts = np.zeros(len(arrays["contacts.step"]), CONTACT_DTYPE)
    for field in CONTACT_DTYPE.names or ():
        contacts[field] = arrays[f"contacts.{field}"]
    return contacts


def save_rollout(path: Path, rollout: Rollout) -> None:
    """Writes the archive; an interrupted write leaves what was there before."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_bytes(rollout_to_bytes(rollout))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
