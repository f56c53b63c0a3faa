"""How far an accepted program holds where its numbers are a little other than it says.

Every uncertain number is moved at once, by a normal deviate of its own spread, cut off at
`FARTHEST`. What nobody knows better has a stated default below; of things that a photograph shows
the camera says how uncertain their places are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.planner.parameters import Knob, action_knobs, material_knobs
from physagent_studio.arrays import FloatArray
from physagent_studio.jobs import Executor
from physagent_studio.program import PhysicalProgram, SceneObject, SetField
from physagent_studio.program.edits import Edit
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.materials import touch_of
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.sweep.carry_out import carry_out
from physagent_studio.sweep.plan import Draw, Plan, Point, Target, planned
from physagent_studio.sweep.run import Ran

FARTHEST = 2.0
"""Standard deviations beyond which nothing is moved: nineteen in twenty are within, and what lies
beyond is rather another thing than an uncertain one."""
RELATIVE = {
    "magnitude": 0.05,
    "density": 0.15,
    "friction": 0.15,
    "restitution": 0.1,
    "rolling": 0.3,
}
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
        return f"{self.knob.factor} of {self.knob.target}"

    def moved(self, deviate: float) -> float:
        """The value so many standard deviations away, within the knob's bounds."""
        knob, by = self.knob, deviate * self.spread
        value = knob.value * math.exp(by) if knob.by_ratio else knob.value + by
        return min(max(value, knob.low), knob.high)


@dataclass(frozen=True, eq=False, slots=True)
class Robustness:
    """What came of it. draws: (N, numbers) standard deviations by which each was moved.

    paths: (N, frames, objects, 3) world, m, where things were in each run that did not end early.
    first: the check that the nearest failing draw breaks worst; its number: what sets the failing
    draws apart most, and whether they have it lower or higher.
    """

    runs: tuple[Ran, ...]
    numbers: tuple[Uncertain, ...]
    draws: FloatArray
    objects: tuple[str, ...] = ()

    @property
    def holds(self) -> int:
        """In how many of the runs all holds that is demanded."""
        return sum(ran.holds for ran in self.runs)

    @property
    def paths(self) -> FloatArray:
        """The ribbon."""
        whole = [ran.path for ran in self.runs if ran.path is not None and not ran.problem]
        return np.array(whole)

    @property
    def first(self) -> str:
        """What the failing draw that moves the numbers least breaks worst; "" where all hold."""
        far = np.linalg.norm(self.draws, axis=1)
        failing = [index for index, ran in enumerate(self.runs) if not ran.holds]
        if not failing:
            return ""
        nearest = self.runs[min(failing, key=lambda index: far[index])]
        return nearest.failing[0].id if nearest.failing else "the run itself"

    @property
    def often(self) -> tuple[tuple[str, int], ...]:
        """What fails how often, most often first."""
        count = Counter(check.id for ran in self.runs for check in ran.failing)
        return tuple(sorted(count.items(), key=lambda row: (-row[1], row[0])))

    @property
    def why(self) -> tuple[Uncertain, float] | None:
        """The number in which failing draws differ most, and by how many standard deviations.

        None where all hold: then no number is known to matter.
        """
        held = np.array([ran.holds for ran in self.runs], bool)
        if held.all() or not self.numbers:
            return None
        kept = self.draws[held].mean(0) if held.any() else 0.0
        apart = self.draws[~held].mean(0) - kept
        most = int(np.argmax(np.abs(apart)))
        return self.numbers[most], float(apart[most])

    @property
    def sentence(self) -> str:
        """`holds in 46 of 50; first to break: hits, as the friction of ball is lower`."""
        said = f"holds in {self.holds} of {len(self.runs)}"
        if (why := self.why) is not None:
            way = "higher" if why[1] > 0 else "lower"
            said += f"; first to break: {self.first}, where the {why[0].label} is {way}"
        return said


def robustness(
    target: Target,
    executor: Executor,
    runs: int,
    *,
    seed: int = 0,
    cancelled: Callable[[], bool] = lambda: False,
) -> Robustness:
    """Runs a program that many times with its uncertain numbers moved."""
    plan = Plan(seeds=runs, draw=draw_of(seed))
    points = list(planned(plan, (target,)))
    found: dict[str, Ran] = {}

    def done(point: Point, ran: Ran) -> None:
        found[point.key] = ran

    carry_out(points, executor, done, cancelled=cancelled)
    return judged(target, [found[point.key] for point in points], seed)


def judged(target: Target, runs: Sequence[Ran], seed: int = 0) -> Robustness:
    """What the runs of the draws 0, 1, … of a seed come to."""
    numbers = uncertain(target.program)
    draws = np.array([deviates(len(numbers), seed, index) for index in range(len(runs))])
    objects = next((ran.objects for ran in runs if ran.objects), ())
    return Robustness(tuple(runs), numbers, draws, objects)


def draw_of(seed: int) -> Draw:
    """What moves the uncertain numbers of a program, by the number of the draw."""

    def draw(program: PhysicalProgram, index: int) -> tuple[tuple[Edit, ...], Mapping[str, float]]:
        numbers = uncertain(program)
        by = deviates(len(numbers), seed, index)
        values = [number.moved(float(z)) for number, z in zip(numbers, by, strict=True)]
        pairs = list(zip(numbers, values, strict=True))
        edits = tuple(edit for number, value in pairs for edit in number.knob.edits(value))
        return edits, {number.knob.path: value for number, value in pairs}

    return draw


def deviates(count: int, seed: int, index: int) -> FloatArray:
    """(count,) standard deviations of one draw; the same for the same seed and number."""
    drawn = np.random.default_rng((seed, index)).standard_normal(count)
    return np.clip(drawn, -FARTHEST, FARTHEST)


# --- what is uncertain ---------------------------------------------------------------------------


def uncertain(program: PhysicalProgram) -> tuple[Uncertain, ...]:
    """Every number of a program that is known to so much only, in the program's order."""
    found = [
        *(_strength(knob) for knob in action_knobs(program) if knob.factor in STRENGTH),
        *(
            Uncertain(knob, _relative(program, knob))
            for knob in material_knobs(program)
            if knob.factor in RELATIVE and knob.by_ratio
        ),
        *_grounds(program),
    ]
    for item in program.scene.objects:
        found += _places(item, program.scene.camera)
    return tuple(found)


def _strength(knob: Knob) -> Uncertain:
    return Uncertain(knob, RELATIVE["magnitude"] if knob.by_ratio else TURNED)


def _relative(program: PhysicalProgram, knob: Knob) -> float:
    item = program.scene.object(knob.target)
    field = knob.path.rpartition(".")[2]
    told = item is not None and item.source in ("given", "person")
    return STATED if told and getattr(item, field, None) is not None else RELATIVE[knob.factor]


def _grounds(program: PhysicalProgram) -> list[Uncertain]:
    """Friction of what carries others."""
    return [
        Uncertain(
            Knob(f"scene.supports.{one.name}.friction", "friction", one.name,
                 touch_of(one).friction, 0.0, 5.0, 0.3),
            RELATIVE["friction"],
        )
        for one in program.scene.supports
        if touch_of(one).friction > 0
    ]  # fmt: skip


def _places(item: SceneObject, camera: Camera | None) -> list[Uncertain]:
    """Where a thing stands, to the side and in depth; how high, what carries it says."""
    if item.position is None or item.shape is None or item.source in ("given", "person"):
        return []
    largest = float(np.max(outline_of(item.shape).size))
    aside = along = PLACED * largest
    if camera is not None and item.grounding.shows_something:
        aside, along = _seen(item.position, camera)
    found = []
    for axis, spread in ((0, aside), (1, along)):
        at = item.position[axis]
        knob = Knob(
            f"scene.objects.{item.name}.position.{axis}", "place", item.name, at, -1e4, 1e4, 1.0,
            by_ratio=False, write=_written(f"scene.objects.{item.name}.position.{axis}"),
        )  # fmt: skip
        found.append(Uncertain(knob, min(spread, CROWDING * largest)))
    return found


def _written(path: str) -> Callable[[float], tuple[Edit, ...]]:
    # To a tenth of a millimetre: five digits of what is far away would be too few.
    return lambda value: (SetField(path=path, value=round(value, 4)),)


def _seen(position: tuple[float, float, float], camera: Camera) -> tuple[float, float]:
    """How far a pixel or two are where a thing stands, across and along the line of sight, m."""
    x, y, z = np.subtract(position, camera.position)
    level = math.hypot(x, y)
    across = PIXELS * math.sqrt(level**2 + z**2) / camera.focal
    # Seen under the angle whose tangent is height over distance, the ground runs away from a row.
    along = across * math.sqrt(level**2 + z**2) / max(abs(z), 1e-3)
    return across, along
