"""MuJoCo, whose bindings carry no types: `mj` is the module, the names below are for readers."""

import logging
from typing import Any, TypeAlias

import mujoco

mj: Any = mujoco


def _note(text: str) -> None:
    logging.getLogger(__name__).debug("MuJoCo: %s", text)


# Without a handler MuJoCo prints its warnings and writes MUJOCO_LOG.TXT where the user stands.
# The engine counts them too, and the run reads the counts.
mj.set_mju_user_warning(_note)
Model: TypeAlias = Any
"""`mujoco.MjModel`."""
Data: TypeAlias = Any
"""`mujoco.MjData`."""
Spec: TypeAlias = Any
"""`mujoco.MjSpec`."""
SpecBody: TypeAlias = Any
"""`mujoco.MjsBody`."""
SpecGeom: TypeAlias = Any
"""`mujoco.MjsGeom`."""
