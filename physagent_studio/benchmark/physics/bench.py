"""`physagent bench physics`: the engine against closed forms, with the bounds we hold it to."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from physagent_studio.benchmark.physics import bodies as physics_bodies
from physagent_studio.benchmark.physics import speed as physics_speed
from physagent_studio.benchmark.physics.scenes import EARTH, STILL, ground, program, thing
from physagent_studio.benchmark.rows import Row, at_least, at_most
from physagent_studio.program.actions import (
    ApplyAngledForce,
    FixObject,
    SetAngularVelocity,
    SetVelocity,
)
from physagent_studio.program.rotations import about_axis, angle_between
from physagent_studio.program.scene.state import Box, Cylinder, Ramp, Slab, Sphere
from physagent_studio.program.text.fuzz import fuzz_programs
from physagent_studio.simulation import simulate

G = 9.81
COUNT, DOSE, SEED = 100_000, 3_000, 1
"""Malformed programs of all of it and of a dose, and the seed that makes them."""


def projectile() -> list[Row]:
    """A ball thrown at step 20, against x₀ + v t + ½ g t², over 3.4 s of flight."""
    start, velocity = np.array([0.0, 0.0, 50.0]), (3.0, 1.0, 8.0)
    throw = SetVelocity(id="throw", name="ball", velocity=velocity, start_step=20)
    hold = FixObject(id="hold", name="ball", duration=20)
    ball = thing("ball", Sphere(radius=0.1), (0, 0, 50))
    rollout = simulate(program([ball], actions=[hold, throw], seconds=3.6))
    time = np.arange(rollout.steps - 20 + 1)[:, None] * rollout.step_seconds
    exact = start + time * velocity + 0.5 * time**2 * EARTH
    error = np.abs(rollout.positions[20:, 0] - exact).max()
    return [at_most("projectile, 3.4 s", error, 1e-6, "m")]


def sliding_stop() -> list[Row]:
    """A box pushed off at 2 m/s stops after v²/2μg."""
    worst = 0.0
    for friction in (0.02, 0.05, 0.1, 0.3, 0.6, 1.0):
        speed = 0.5 if friction < 0.04 else 1.0 if friction < 0.2 else 2.0
        box = thing("box", Box(size=(0.4, 0.4, 0.1)), (0, 0, 0.05), friction=friction)
        push = SetVelocity(id="push", name="box", velocity=(speed, 0, 0))
        clip = program([box], [ground(friction=friction)], [push], seconds=4.0)
        path = simulate(clip).positions[-1, 0, 0]
        exact = speed**2 / (2 * friction * G)
        worst = max(worst, abs(path / exact - 1))
    return [at_most("sliding stop, friction .02–1", 100 * worst, 0.5, "%")]


def rolling() -> list[Row]:
    """A ball rolls down a ramp with 5/7 g sin α."""
    worst = 0.0
    for degrees in (5, 10, 20, 30, 40):
        angle = math.radians(degrees)
        run = 6.0
        ramp = Ramp(toe=(0, 0, 0), yaw=0.0, run=run, rise=run * math.tan(angle), width=2)
        along = np.array([math.cos(angle), 0, math.sin(angle)])
        normal = np.array([-math.sin(angle), 0, math.cos(angle)])
        x, y, z = along * (run - 0.5) / math.cos(angle) + normal * 0.1
        ball = thing("ball", Sphere(radius=0.1), (x, y, z), friction=1.0)
        support = ground("ramp", ramp, friction=1.0)
        rollout = simulate(program([ball], [support], seconds=1.0))
        path = float((rollout.positions[0, 0] - rollout.positions[-1, 0]) @ along)
        exact = 0.5 * 5 / 7 * G * math.sin(angle) * 1.0**2
        worst = max(worst, abs(path / exact - 1))
    return [at_most("rolling without slip, 5–40°", 100 * worst, 0.1, "%")]


def rolling_resistance() -> list[Row]:
    """A ball and a cylinder let roll stop after v² (1 + k) / 2 c g, k = I / m r²."""
    worst = 0.0
    upright = about_axis((1, 0, 0), math.pi / 2)
    shapes = (
        (Sphere(radius=0.1), 0.4, (1.0, 0.0, 0.0, 0.0)),
        (Cylinder(radius=0.1, height=0.3), 0.5, upright),
    )
    for shape, inertia, turn in shapes:
        for resistance, speed in ((0.01, 0.4), (0.03, 0.8), (0.1, 1.0)):
            roller = thing(
                "roller", shape, (0, 0, 0.1), rotation=turn, friction=0.8, rolling=resistance / 2
            )
            actions = [
                SetVelocity(id="go", name="roller", velocity=(speed, 0, 0)),
                SetAngularVelocity(id="spin", name="roller", angular_velocity=(0, speed / 0.1, 0)),
            ]
            floor = ground(friction=0.8, rolling=resistance / 2)
            path = simulate(program([roller], [floor], actions, seconds=6.5)).positions[-1, 0, 0]
            exact = speed**2 * (1 + inertia) / (2 * resistance * G)
            worst = max(worst, abs(path / exact - 1))
    return [at_most("rolling resistance .01–.1, stopping distance", 100 * worst, 2.0, "%")]


def restitution() -> list[Row]:
    """Rebound speed over impact speed of a ball and of a box that lands flat."""
    rows = []
    shapes = {"sphere": Sphere(radius=0.1), "flat box": Box(size=(0.2, 0.2, 0.2))}
    for label, shape in shapes.items():
        worst = 0.0
        for wanted in (0.0, 0.1, 0.3, 0.5, 0.7, 0.9):
            for drop in (0.31, 0.5, 0.77):
                worst = max(worst, abs(_rebound(shape, wanted, drop) - wanted))
        rows.append(at_most(f"restitution 0–.9, {label}", worst, 0.03))
    return rows


def _rebound(shape: Sphere | Box, wanted: float, drop: float) -> float:
    """Speed with which it leaves the floor over the speed with which it met it."""
    item = thing("it", shape, (0, 0, 0.1 + drop), restitution=wanted)
    rollout = simulate(program([item], [ground(restitution=wanted)], seconds=1.0))
    landed = int(rollout.contacts["step"][0]) + 1
    height = rollout.positions[landed:, 0, 2] - 0.1
    speed = rollout.velocities[landed:, 0, 2]
    # The first free row after the impact, traced back to the floor by its energy.
    free = np.flatnonzero((speed > 0) & (height > 1e-3))
    if len(free) == 0:
        return 0.0
    left = math.sqrt(speed[free[0]] ** 2 + 2 * G * height[free[0]])
    return left / math.sqrt(2 * G * drop)


def topple() -> list[Row]:
    """A box on its edge falls over beyond atan(width / height)."""
    width, height = 0.1, 0.4
    exact = math.degrees(math.atan(width / height))
    low, high = exact - 2.0, exact + 2.0
    while high - low > 0.01:
        middle = (low + high) / 2
        if _falls_over(width, height, math.radians(middle)):
            high = middle
        else:
            low = middle
    return [at_most("topple threshold", 100 * abs(high / exact - 1), 2.0, "%")]


def _falls_over(width: float, height: float, tilt: float) -> bool:
    """Whether a box let go at rest, tilted about its lower edge, comes down on its side."""
    corner = np.array([width / 2, 0, -height / 2])
    turn = np.array(
        [[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]]
    )
    x, y, z = -(turn @ corner)
    box = thing(
        "box",
        Box(size=(width, width, height)),
        (x, y, z),
        rotation=about_axis((0, 1, 0), tilt),
        friction=1.0,
    )
    rollout = simulate(program([box], [ground(friction=1.0)], seconds=3.0))
    return bool(angle_between(rollout.rotations[-1, 0], (1, 0, 0, 0)) > 1.0)


def stack() -> list[Row]:
    """Ten boxes stand on one another for 3 s."""
    edge = 0.1
    boxes = [
        thing(f"box{n}", Box(size=(edge, edge, edge)), (0, 0, edge * (n + 0.5))) for n in range(10)
    ]
    rollout = simulate(program(boxes, [ground()], seconds=3.0))
    shift = rollout.positions - rollout.positions[0]
    drift = float(np.linalg.norm(shift[..., :2], axis=-1).max())
    sink = float(-shift[..., 2].min())
    return [
        at_most("ten-box stack, 3 s, drift", 1000 * drift, 0.5, "mm"),
        at_most("ten-box stack, 3 s, sink", 1000 * sink, 0.5, "mm"),
    ]


def mass_ratio() -> list[Row]:
    """A heavy box on a light one, 1000 : 1."""
    light = thing("light", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.1), density=10)
    heavy = thing("heavy", Box(size=(0.2, 0.2, 0.2)), (0, 0, 0.3), density=10_000)
    rollout = simulate(program([light, heavy], [ground()], seconds=3.0))
    sink = float(-(rollout.positions - rollout.positions[0])[..., 2].min())
    chatter = float(np.linalg.norm(rollout.velocities[100:], axis=-1).max())
    return [
        at_most("1000:1 mass ratio, sink", 1000 * sink, 3.0, "mm"),
        at_most("1000:1 mass ratio, chatter", 1000 * chatter, 5.0, "mm/s"),
    ]


def fixing() -> list[Row]:
    """A fixed 1 kg box in the air carries 100 kg, and is hit by 10 kg at 5 m/s."""
    box = thing("box", Box(size=(0.2, 0.2, 0.2)), (0, 0, 1.0), density=125)
    hold = FixObject(id="hold", name="box", duration=300)
    load = thing("load", Box(size=(0.2, 0.2, 0.2)), (0, 0, 1.2), density=12_500)
    carried = simulate(program([box, load], actions=[hold], seconds=3.0))
    ball = thing(
        "ball", Sphere(radius=0.08), (-1, 0, 1.0), density=10 / (4 / 3 * math.pi * 0.08**3)
    )
    throw = SetVelocity(id="throw", name="ball", velocity=(5, 0, 0))
    hit = simulate(program([box, ball], actions=[hold, throw], gravity=STILL, seconds=3.0))
    rows = []
    for label, rollout in (("under 100 kg", carried), ("hit by 10 kg at 5 m/s", hit)):
        moved = np.linalg.norm(rollout.positions[:, 0] - rollout.positions[0, 0], axis=1).max()
        rows.append(at_most(f"FixObject {label}", 1000 * float(moved), 0.01, "mm"))
    return rows


def angled_force() -> list[Row]:
    """A force across the path bends it and keeps the speed."""
    ball = thing("ball", Sphere(radius=0.05), (0, 0, 1), density=1 / (4 / 3 * math.pi * 0.05**3))
    actions = [
        SetVelocity(id="go", name="ball", velocity=(2, 0, 0)),
        ApplyAngledForce(id="bend", name="ball", magnitude=4, angle=90, duration=340),
    ]
    rollout = simulate(program([ball], actions=actions, gravity=STILL, seconds=3.4))
    error = np.abs(np.linalg.norm(rollout.velocities[1:, 0], axis=1) / 2 - 1).max()
    return [at_most("angled force, speed kept over 3.4 s", float(error), 1e-5)]


def tunnelling() -> list[Row]:
    """A 4 cm ball shot at a 2 mm wall, three speeds, twelve phases each."""
    through = 0
    for speed in (10.0, 30.0, 80.0):
        for phase in range(12):
            ball = thing(
                "ball", Sphere(radius=0.02), (-0.5 - phase * 0.0025, 0, 1), restitution=0.5
            )
            wall = ground("wall", Slab(position=(0, 0, 1), size=(0.002, 2, 2)), restitution=0.5)
            shot = SetVelocity(id="shot", name="ball", velocity=(speed, 0, 0))
            rollout = simulate(program([ball], [wall], [shot], gravity=STILL, seconds=0.2))
            through += bool(rollout.positions[:, 0, 0].max() > 0)
    return [at_most("ball through a 2 mm wall, 36 shots", through, 0, "shots")]


def malformed(count: int = DOSE) -> list[Row]:
    """Mutated programs: each is read or refused with path and line, none slowly."""
    report = fuzz_programs(count, SEED)
    return [
        at_least("malformed programs read", report.count, count, "programs"),
        at_most("uncaught errors and errors without a line", len(report.failures), 0, "programs"),
        at_most("slowest malformed program", report.seconds, 1.0, "s"),
    ]


FIGURES: dict[str, Callable[[], list[Row]]] = {
    "projectile": projectile,
    "sliding": sliding_stop,
    "rolling": rolling,
    "rolling_resistance": rolling_resistance,
    "restitution": restitution,
    "bounces": physics_bodies.bounces,
    "topple": topple,
    "stack": stack,
    "mass_ratio": mass_ratio,
    "fixing": fixing,
    "angled_force": angled_force,
    "tunnelling": tunnelling,
    "bowl": physics_bodies.bowl,
    "ring": physics_bodies.ring,
    "soft_squash": physics_bodies.soft_squash,
    "cloth_area": physics_bodies.cloth_area,
    "rope_length": physics_bodies.rope_length,
    "grains": physics_bodies.grains,
    "stool": physics_bodies.stool,
    "overhead": physics_speed.overhead,
    "rerun": physics_speed.rerun,
    "cold": physics_speed.cold,
}
"""Every figure by name; each function measures it afresh."""


def bench(*, cases: Path | None = None, out: Path | None = None, full: bool = False) -> list[Row]:
    """Runs all figures. full: all malformed programs.

    out: a Markdown file for them; the sections that it has below the table are kept.
    """
    rows = [row for figure in FIGURES.values() for row in figure()]
    rows += malformed(COUNT if full else DOSE)
    if out is not None:
        _, mark, notes = out.read_text().partition("\n## ") if out.is_file() else ("", "", "")
        out.write_text(_page(rows) + mark + notes)
    return rows


def _page(rows: list[Row]) -> str:
    lines = [
        "# Physics in figures",
        "",
        "Made by `physagent bench physics --full --out docs/physics.md`: the engine against closed",
        "forms, the bounds it is held to, and what it costs. Ratios of time are of CPU time,",
        "interleaved; on a machine that is busy with other work they come out higher.",
        "",
        "| | figure | measured | bound |",
        "|---|---|---|---|",
    ]
    for row in rows:
        value = str(row.value)
        if isinstance(row.value, float):
            value = f"{row.value:,.0f}" if abs(row.value) >= 1000 else f"{row.value:.3g}"
        unit = f" {row.unit}" if row.unit else ""
        limit = f"{row.bound}{unit}" if row.bound else "–"
        lines.append(f"| {'✓' if row.ok else '✗'} | {row.name} | {value}{unit} | {limit} |")
    return "\n".join(lines) + "\n"
