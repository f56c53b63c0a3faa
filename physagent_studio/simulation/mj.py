"""MuJoCo, whose bindings carry no types: `mj` is the module, the names below are for readers."""

from __future__ import annotations

from typing import Any, TypeAlias

import mujoco

mj: Any = mujoco
Model: TypeAlias = Any
"""`mujoco.MjModel`."""
Data: TypeAlias = Any
"""`mujoco.MjData`."""
Spec: TypeAlias = Any
"""`mujoco.MjSpec`."""
SpecBody: TypeAlias = Any
"""`mujoco.MjsBody`."""
