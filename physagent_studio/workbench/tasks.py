"""The heavy steps as pure tasks: values in, values out, carried out by an `Executor` of `jobs`.

Each hears of cancellation and tells of its progress by `jobs.hearing`. What a process keeps
between two tasks (compiled models, a compositor's tables) never changes a result. Rooms are
imported where they are needed: the process that asks need not have them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from physagent_studio.jobs import Limits, hearing
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.timing import timing_of
from physagent_studio.records import Case, Check, Image, Mesh, Rollout, Scene
from physagent_studio.records.clip_look import ClipLook

if TYPE_CHECKING:
    from physagent_studio.contract.view import Drawn
    from physagent_studio.language.sought import Sought
    from physagent_studio.reconstruction.grounding.proposals import Proposed
    from physagent_studio.reconstruction.learned.at_hand import Learned
    from physagent_studio.rendering import Compositor
    from physagent_studio.simulation import Simulator

MODULES = (
    "physagent_studio.reconstruction",
    "physagent_studio.simulation",
    "physagent_studio.rendering",
    "physagent_studio.contract.view",
)
"""What a process for these tasks imports before the first one comes."""
RECONSTRUCTION = Limits(600.0, 4 * 2**30)
"""The slowest photograph takes 20 s and half a gigabyte; what takes thirty times that hangs."""
SIMULATION = Limits(600.0, 2 * 2**30)
"""Grains are the slowest, at a minute a run."""
RENDERING = Limits(3600.0, 2 * 2**30)
"""A clip of a thousand frames takes some ten minutes."""
TRACING = Limits(30 * 24 * 3600.0, 4 * 2**30)
"""A path-traced frame takes a minute or, with thousands of samples, hours."""
EVIDENCE_EVERY = 3
"""The paper shows its verifier x1, x4 … x79: every third frame from the first."""

LEAST_PIXELS = 60
"""A mask of fewer pixels tells nothing of a silhouette."""


@lru_cache(maxsize=1)
def _simulator() -> Simulator:
    """The one of this process; what it keeps is known by its content."""
    from physagent_studio.simulation import Simulator

    return Simulator()


def reconstructed(
    case: Case,
    state: SceneState,
    previous: Scene | None,
    assets: Mapping[str, Mesh],
    learned: Learned,
) -> Scene:
    """The scene of a state; see `reconstruction.reconstruct`."""
    from physagent_studio.reconstruction import reconstruct

    cancelled, tell = hearing()
    return reconstruct(
        case,
        state,
        previous=previous,
        assets=assets,
        learned=learned,
        cancelled=cancelled,
        progress=tell,
    )


def proposed(image: Image, wanted: list[Sought]) -> tuple[Proposed, ...]:
    """Where things may be that nobody clicked."""
    from physagent_studio.reconstruction.grounding.proposals import propose

    return tuple(propose(image, wanted))


def simulated(
    program: PhysicalProgram, meshes: Mapping[str, Mesh], before: Rollout | None
) -> Rollout:
    """One run of the physics engine; before: an earlier run, of which is taken over what may be."""
    cancelled, _ = hearing()
    if before is None or before.snapshots is None:
        return _simulator().simulate(program, meshes, cancelled=cancelled)
    steps = program.clip.steps
    return _simulator().resimulate(program, meshes, before, steps, cancelled=cancelled)


def ran(
    program: PhysicalProgram, meshes: Mapping[str, Mesh], drawn: Mapping[str, Drawn]
) -> tuple[Rollout, tuple[Check, ...]]:
    """One run of the physics engine and what is measured of it."""
    from physagent_studio.contract import measure

    rollout = simulated(program, meshes, None)
    return rollout, measure(program, rollout, drawn)


def outlined(program: PhysicalProgram, meshes: Mapping[str, Mesh]) -> dict[str, tuple[Mesh, ...]]:
    """What the physics engine collides, by name."""
    return _simulator().outlines(program, meshes)


def viewed(scene: Scene) -> Image:
    """The scene before anything moves, seen by its own camera."""
    from physagent_studio.rendering import Compositor

    return Compositor(scene).frame(as_built=True).rgb


def framed(scene: Scene, rollout: Rollout, number: int) -> Image:
    """One frame of a rollout."""
    from physagent_studio.rendering import Compositor, frame_of

    if scene.hash not in _COMPOSITOR:
        _COMPOSITOR.clear()
        _COMPOSITOR[scene.hash] = Compositor(scene)
    return frame_of(_COMPOSITOR[scene.hash], rollout, number).rgb


_COMPOSITOR: dict[str, Compositor] = {}
"""Of the scene that was drawn last, by its hash: its frames are asked for one by one."""


def likened(scene: Scene) -> dict[str, Drawn]:
    """How like the photograph each thing is drawn that the photo shows and the scene draws.

    Nothing without a photo, a camera or the looks of everything in it.
    """
    from physagent_studio.contract.view import Drawn
    from physagent_studio.rendering import Compositor

    if scene.photo is None or scene.state.camera is None or not scene.state.objects:
        return {}
    if any(item.name not in scene.meshes or item.position is None for item in scene.state.objects):
        return {}  # Something was added by hand and is not drawn yet.
    ids = Compositor(scene, lit=False).frame(as_built=True, shadows=False).ids
    found: dict[str, Drawn] = {}
    for index, item in enumerate(scene.state.objects):
        mask = scene.masks.get(item.name)
        if mask is None or mask.shape != ids.shape or int(mask.sum()) < LEAST_PIXELS:
            continue
        drawn = ids == index
        both, either = int((mask & drawn).sum()), int((mask | drawn).sum())
        jump = float(np.hypot(*(_middle(drawn) - _middle(mask)))) if drawn.any() else np.inf
        found[item.name] = Drawn(both / max(either, 1), jump)
    return found


def _middle(mask: np.ndarray) -> np.ndarray:
    return np.argwhere(mask).mean(axis=0)


def sampled(scene: Scene, rollout: Rollout) -> tuple[Image, ...]:
    """Every third frame of a rollout."""
    from physagent_studio.rendering import render_clip

    cancelled, tell = hearing()
    clip = render_clip(
        scene,
        rollout,
        range(0, rollout.frames, EVIDENCE_EVERY),
        cancelled=cancelled,
        progress=lambda share: tell("drawing the frames to be judged", share),
    )
    return tuple(frame.rgb for frame in clip)


def filmed(
    path: Path, scene: Scene, rollout: Rollout, program: PhysicalProgram, look: ClipLook
) -> None:
    """Writes a rollout as a video."""
    from physagent_studio.exchange import write_video
    from physagent_studio.exchange.prior.framing import Framing
    from physagent_studio.rendering import Compositor, render_clip
    from physagent_studio.rendering.pbr import PathTracer

    cancelled, tell = hearing()
    camera = scene.state.camera
    framing = look.size and camera and Framing.of(camera.size, look.size, look.way)
    clip = render_clip(
        scene,
        rollout,
        cancelled=cancelled,
        progress=lambda share: tell("rendering", share),
        shutter=look.shutter,
        compositor=Compositor(scene) if look.samples is None else PathTracer(scene, look.samples),
    )
    pictures = (framing.picture(frame.rgb) if framing else frame.rgb for frame in clip)
    write_video(path, pictures, program.clip.playback_fps, timing_of(program.clip))


def exported(folder: Path, scene: Scene, rollout: Rollout, program: PhysicalProgram) -> None:
    """Writes a motion prior; what was written before an end of the process is taken over later."""
    from physagent_studio.exchange import export_motion_prior

    cancelled, tell = hearing()
    export_motion_prior(
        folder,
        scene,
        rollout,
        program,
        program.clip.playback_fps,
        cancelled=cancelled,
        progress=lambda share: tell("exporting", share),
    )
