"""How far an accepted program holds where its numbers are a little other than it says.

Every uncertain number is moved at once, by a normal deviate of its own spread, cut off at
`FARTHEST`. What nobody knows better has a stated default below; of things that a photograph shows
the camera says how uncertain their places are.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.planner.parameters import Knob, action_knobs, material_knobs
from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.jobs import Executor
from physagent_studio.jobs.executor import never, quiet
from physagent_studio.program import PhysicalProgram, SceneObject, Support
from physagent_studio.program.edits import Edit
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.materials import touch_of
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.records import Check
from physagent_studio.sweep.carry_out import results
from physagent_studio.sweep.plan import Plan, Target, planned
from physagent_studio.sweep.run import Ran

FARTHEST = 2.0
"""Standard deviations beyond which nothing is moved: nineteen in twenty are within, and what lies
beyond is rather another thing than an uncertain one."""
RELATIVE = {"magnitude": 0.05, "density": 0.15, "friction": 0.15, "restitution": 0.1}
RELATIVE |= {"rolling": 0.3}
"""Relative standard deviations. A push is as strong as a hand repeats it; densities of one material
and its coefficients differ by this much between samples in the tables that `materials.yaml` names,
and its rolling resistances, by its own words, by up to a factor of two."""
STATED = 0.02
"""Relative standard deviation of a density or coefficient that the program itself states of a thing
whose numbers a person or the case gave: a scale's and a slope's."""
TURNED = 1.0
"""Standard deviation of a direction, degrees: what is aimed by eye."""
STRENGTH = ("magnitude", "direction")
"""Factors of an action that a hand does not do twice alike; when it acts, the program says."""
PIXELS = 1.5
"""Standard deviation of where a thing's foot is seen, pixels: about that of a mask's rim."""
PLACED = 0.01
"""Standard deviation of a place that no photograph shows, over the largest side of the thing."""
CROWDING = 0.1
"""Most standard deviation of a place over the largest side: more would put things into others."""


@dataclass(frozen=True, slots=True)
class Uncertain:
    """A number and its standard deviation: of its logarithm where the knob goes by ratio."""

    knob: Knob
    spread: float

    @property
    def label(self) -> str:
        """What it is called: `density of ball`."""
        return f"{self.knob.factor} of {self.knob.target}".replace("magnitude", "strength")

    def moved(self, deviate: float) -> float:
        """The value so many standard deviations away, within the knob's bounds."""
        knob, by = self.knob, deviate * self.spread
        value = knob.value * math.exp(by) if knob.by_ratio else knob.value + by
        return min(max(value, knob.low), knob.high)


@dataclass(frozen=True, eq=False, slots=True)
class Robustness:
    """What came of the runs. draws: (N, numbers) standard deviations by which each was moved."""

    runs: tuple[Ran, ...]
    numbers: tuple[Uncertain, ...]
    draws: FloatArray

    @property
    def holds(self) -> int:
        """In how many of the runs all holds that is demanded."""
        return sum(ran.holds for ran in self.runs)

    @property
    def paths(self) -> tuple[FloatArray, BoolArray]:
        """The ribbon: (N, frames, objects, 3) world, m, of each run that did not end early, and
        (N,) whether it holds."""
        whole = [ran for ran in self.runs if ran.path is not None and not ran.problem]
        return np.array([ran.path for ran in whole]), np.array([ran.holds for ran in whole], bool)

    @property
    def first(self) -> Check | None:
        """What the failing draw that moves the numbers least breaks worst; None where all hold, or
        where the run itself breaks off."""
        far = np.linalg.norm(self.draws, axis=1).tolist()
        failing = [(by, ran) for by, ran in zip(far, self.runs, strict=True) if not ran.holds]
        nearest = min(failing, key=lambda row: row[0])[1].failing if failing else ()
        return nearest[0] if nearest else None

    @property
    def why(self) -> tuple[Uncertain, float] | None:
        """The number in which failing draws differ most, and by how many standard deviations."""
        held = np.array([ran.holds for ran in self.runs], bool)
        if held.all() or not self.numbers:
            return None
        apart = self.draws[~held].mean(0) - (self.draws[held].mean(0) if held.any() else 0.0)
        most = int(np.argmax(np.abs(apart)))
        return self.numbers[most], float(apart[most])

    @property
    def sentence(self) -> str:
        """`holds in 46 of 50; first to break: hit, where the friction of ball is lower`."""
        said = f"holds in {self.holds} of {len(self.runs)}"
        if (why := self.why) is None:
            return said
        way = "higher" if why[1] > 0 else "lower"
        breaks = self.first.id if self.first else "the run itself"
        return f"{said}; first to break: {breaks}, where the {why[0].label} is {way}"


def robustness(
    target: Target,
    executor: Executor,
    runs: int,
    *,
    cancelled: Callable[[], bool] = never,
    tell: Callable[[float], None] = quiet,
) -> Robustness:
    """Runs a program that many times with its uncertain numbers moved; `tell` hears the share."""
    points = list(planned(Plan(seeds=runs, draw=draw), (target,)))
    found = results(points, executor, cancelled, lambda done: tell(done / runs))
    return judged(target, [found[point.key] for point in points])


def judged(target: Target, runs: Sequence[Ran]) -> Robustness:
    """What the runs of the draws 0, 1, … come to."""
    numbers = uncertain(target.program)
    draws = np.array([deviates(len(numbers), index) for index in range(len(runs))])
    return Robustness(tuple(runs), numbers, draws)


def draw(program: PhysicalProgram, index: int) -> tuple[tuple[Edit, ...], Mapping[str, float]]:
    """What moves the uncertain numbers of a program, by the number of the draw; see `Plan`."""
    numbers = uncertain(program)
    moved = zip(numbers, deviates(len(numbers), index).tolist(), strict=True)
    values = {number.knob: number.moved(by) for number, by in moved}
    edits = tuple(edit for knob, value in values.items() for edit in knob.edits(value))
    return edits, {knob.path: value for knob, value in values.items()}


def deviates(count: int, index: int) -> FloatArray:
    """(count,) standard deviations of one draw; the same for the same number."""
    drawn = np.random.default_rng(index).standard_normal(count)
    return np.clip(drawn, -FARTHEST, FARTHEST)


# --- what is uncertain ---------------------------------------------------------------------------


def uncertain(program: PhysicalProgram) -> tuple[Uncertain, ...]:
    """Every number of a program that is known to so much only, in the program's order."""
    acts = [knob for knob in action_knobs(program) if knob.factor in STRENGTH]
    # Strength and aim of a plain vector are one field; the strength, which comes first, is moved.
    acts = list({knob.path: knob for knob in reversed(acts)}.values())[::-1]
    found = [Uncertain(knob, RELATIVE["magnitude"] if knob.by_ratio else TURNED) for knob in acts]
    for knob in (*material_knobs(program), *map(_friction, program.scene.supports)):
        # What is exactly nothing was meant so.
        if knob.factor in RELATIVE and knob.value > 0:
            spread = STATED if _stated(program, knob) else RELATIVE[knob.factor]
            found.append(Uncertain(knob, spread if knob.by_ratio else spread * knob.value))
    for item in program.scene.objects:
        found += _places(item, program.scene.camera)
    return tuple(found)


def _stated(program: PhysicalProgram, knob: Knob) -> bool:
    """Whether a person or the case gave the number."""
    item = program.scene.object(knob.target) or program.scene.support(knob.target)
    told = item is not None and item.source in ("given", "person")
    return told and getattr(item, knob.path.rpartition(".")[2], None) is not None


def _friction(one: Support) -> Knob:
    now = touch_of(one).friction
    return Knob(f"scene.supports.{one.name}.friction", "friction", one.name, now, 0.0, 5.0, 0.3)


def _places(item: SceneObject, camera: Camera | None) -> list[Uncertain]:
    """Where a thing stands, to the side and in depth; how high, what carries it says."""
    if item.position is None or item.shape is None or item.source in ("given", "person"):
        return []
    largest = float(np.max(outline_of(item.shape).size))
    spreads = (PLACED * largest, PLACED * largest)
    if camera is not None and item.grounding.shows_something:
        spreads = _seen(item.position, camera)
    found = []
    for axis, spread in enumerate(spreads):
        path, at = f"scene.objects.{item.name}.position.{axis}", item.position[axis]
        knob = Knob(path, "place", item.name, at, -1e4, 1e4, 1.0, by_ratio=False)
        found.append(Uncertain(knob, min(spread, CROWDING * largest)))
    return found


def _seen(position: tuple[float, float, float], camera: Camera) -> tuple[float, float]:
    """How far a pixel or two are where a thing stands, across and along the line of sight, m."""
    x, y, z = np.subtract(position, camera.position)
    level = math.hypot(x, y)
    across = PIXELS * math.sqrt(level**2 + z**2) / camera.focal
    # Seen under the angle whose tangent is height over distance, the ground runs away from a row.
    along = across * math.sqrt(level**2 + z**2) / max(abs(z), 1e-3)
    return across, along
