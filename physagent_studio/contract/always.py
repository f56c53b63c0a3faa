"""What must be true of any rollout, whatever the prompt says."""

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.causes import caused, energy, physics_check
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.words import number
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.boards import Size3, rails_of
from physagent_studio.program.scene.bodies import DEFORMABLE
from physagent_studio.program.scene.shapes import Placed, depth_inside, lowest, place_support
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import Floor, MeshedSupport, Ramp, Slab, SupportShape
from physagent_studio.records.judgement import Check

SUSTAINED, SUSTAINED_SECONDS = 0.05, 0.03
"""Overlap that lasts may be this part of the smaller body's smallest extent."""
YIELDING = 0.15
"""Where a deformable body takes part, whose contacts give, it may be this part."""
PEAK = 0.3
"""Overlap in the moment of a blow may be this part of it."""


def always_on(facts: Facts) -> tuple[Check, ...]:
    """The five checks of the physics, in a fixed order."""
    return (
        _no_blow_up(facts),
        _no_deep_penetration(facts),
        energy(facts),
        caused(facts),
        _no_sinking(facts),
    )


def _no_blow_up(facts: Facts) -> Check:
    alarm = facts.rollout.blown_up
    if alarm is not None:
        text = f"the run stays stable: {{answer}}, step {alarm.step}: {_safe(alarm.text)}"
        return physics_check("blow_up", text, -1.0, step=alarm.step)
    if not facts.complete:
        text = f"the run stays stable: {{answer}}, numbers end at step {facts.last}"
        return physics_check("blow_up", text, -1.0, step=facts.last)
    return physics_check("blow_up", "the run stays stable: {answer}", 1.0)


def _safe(text: str) -> str:
    return text.replace("{", "(").replace("}", ")")


# --- penetration -----------------------------------------------------------------------------


def _no_deep_penetration(facts: Facts) -> Check:
    """The deepest overlap of any pair, less what it had in frame 0, over what it may be."""
    rows = facts.rollout.contacts
    rows = rows[rows["step"] <= facts.last]
    worst, text, step = 0.0, "nothing overlaps deeply: {answer}", None
    measured, threshold, ignored = 0.0, None, 0.0
    for a, b in sorted({(int(a), int(b)) for a, b in zip(rows["a"], rows["b"], strict=True)}):
        mine = rows[(rows["a"] == a) & (rows["b"] == b)]
        depth = np.zeros(facts.last + 1)
        np.maximum.at(depth, mine["step"], mine["depth"])
        start = _at_start(facts, depth)
        ignored = max(ignored, start)
        grown = np.maximum(depth - start, 0.0)
        extent = min(_extent(facts, a), _extent(facts, b))
        lasting = _lasting(grown, max(1, round(SUSTAINED_SECONDS / facts.dt)))
        soft = any(_is_soft(facts, index) for index in (a, b))
        blow = np.maximum(grown - _strides(facts, a, b), 0.0)
        for values, share in ((lasting, YIELDING if soft else SUSTAINED), (blow, PEAK)):
            ratio = float(values.max()) / max(share * extent, 1e-3)
            if ratio > worst:
                worst, measured = ratio, float(values.max())
                threshold, step = max(share * extent, 1e-3), int(values.argmax())
                one, two = facts.rollout.bodies[a], facts.rollout.bodies[b]
                figures = f"{number(measured * 1000)} mm ≤ {number(threshold * 1000)} mm"
                text = f"{one} and {two} overlap by {figures}: {{answer}}"
    if ignored > 1e-3:
        text += f", beside {number(ignored * 1000)} mm from the start"
    return physics_check("penetration", text, 1.0 - worst, measured, threshold, "m", step)


def _strides(facts: Facts, a: int, b: int) -> FloatArray:
    """(S,) m that two bodies come closer within an engine step: so deep a blow starts, however
    thin they are.
    """
    rollout, total = facts.rollout, np.zeros(facts.last + 1)
    for index in (a, b):
        if index < len(rollout.objects):
            speeds = np.linalg.norm(rollout.velocities[: facts.last + 1, index], axis=-1)
            reach = float(facts.outline(rollout.bodies[index]).size.max()) / 2
            turning = np.linalg.norm(rollout.angular[: facts.last + 1, index], axis=-1)
            total += speeds + reach * turning
    # It may have been faster the step before, when it had not met anything yet.
    total[1:] = np.maximum(total[1:], total[:-1])
    return total * facts.dt / facts.program.clip.substeps


def _is_soft(facts: Facts, index: int) -> bool:
    item = facts.program.scene.object(facts.rollout.bodies[index])
    return item is not None and item.body.kind in DEFORMABLE


def _at_start(facts: Facts, depth: FloatArray) -> float:
    """Overlap of a pair in frame 0, m, which a reconstruction cannot avoid."""
    return float(depth[: facts.rollout.steps_per_frame].max()) if depth[0] > 0 else 0.0


def _lasting(values: FloatArray, count: int) -> FloatArray:
    """(S,) the least value of the `count` rows up to each row."""
    if len(values) < count:
        return np.zeros_like(values)
    windows = np.lib.stride_tricks.sliding_window_view(values, count).min(axis=1)
    return np.concatenate([np.zeros(count - 1), windows])


def _extent(facts: Facts, index: int) -> float:
    """Smallest extent of a body, m; supports count as large."""
    if index >= len(facts.rollout.objects):
        return np.inf
    return float(facts.outline(facts.rollout.bodies[index]).size.min())


# --- sinking ---------------------------------------------------------------------------------


def _no_sinking(facts: Facts) -> Check:
    """No object gets below the ground or into a solid support, beyond where it began."""
    worst, step = 0.0, None
    measured, threshold = 0.0, None
    text = "every support carries what is on it: {answer}"
    for name in facts.rollout.objects:
        item = facts.program.scene.object(name)
        if item is None or item.shape is None or item.body.kind != "rigid":
            continue
        track = facts.track(name, facts.whole())
        allowed = max(0.1 * float(track.outline.size.min()), 2e-3)
        for support in facts.program.scene.supports:
            if support.shape is None:
                continue
            depth = _depth(track.placed, support.shape)
            grown = depth - max(float(depth[0]), 0.0)
            ratio = float(grown.max()) / allowed
            if ratio > max(worst, 0.1):
                worst, step = ratio, int(grown.argmax())
                measured, threshold = float(grown.max()), allowed
                figures = f"{number(measured * 1000)} mm ≤ {number(allowed * 1000)} mm"
                text = f"{name} sinks into {support.name} by {figures}: {{answer}}"
    return physics_check("sink", text, 1.0 - worst, measured, threshold, "m", step)


def _depth(body: Placed, shape: SupportShape) -> FloatArray:
    """(T,) depth of the lowest point below a floor; in other supports, of the centre, m."""
    assert body.outline is not None
    if isinstance(shape, Floor) and body.outline.exact:
        return shape.height - lowest(body)
    depths = [depth_inside(body.positions, place_support(solid)) for solid in _solids(shape)]
    return np.max(depths, axis=0) if depths else np.full(len(body.positions), -np.inf)


def _solids(shape: SupportShape) -> tuple[SupportShape, ...]:
    """What of a support is solid; nothing of a mesh, of which only contacts tell."""
    match shape:
        case MeshedSupport():
            return ()
        case Slab(rail=rail) if rail is not None:
            blocks = rails_of(shape)
            return tuple(_block(shape.position, shape.yaw, *block) for block in blocks)
        case Ramp(steps=steps) if steps > 0:
            treads = treads_of(shape)
            back = treads[-1].end
            return tuple(
                _block(
                    shape.toe,
                    shape.yaw,
                    ((tread.start + back) / 2, 0.0, tread.top / 2),
                    (back - tread.start, shape.width, tread.top),
                )
                for tread in treads
            )
    return (shape,)


def _block(origin: Size3, yaw: float, place: Size3, size: Size3) -> Slab:
    """A box in the frame of a support that stands at `origin` and is turned by `yaw`."""
    middle = matrix_of(about_up(yaw)) @ np.array(place) + origin
    return Slab(position=(float(middle[0]), float(middle[1]), float(middle[2])), size=size, yaw=yaw)
