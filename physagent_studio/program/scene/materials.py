"""The materials table: density, friction, restitution, rolling; by name, with sources."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Material:
    """density: kg/m³. friction: Coulomb coefficient against itself. restitution: 0 … 1.

    rolling: coefficient of rolling resistance against something hard, force over weight; what two
    surfaces lose adds up. Measured are, for wheels (Engineering ToolBox, rolling resistance): steel
    on rails .001–.002, a bicycle's on wood .001 and on concrete .002, a lorry's on asphalt
    .006–.01, a car's on concrete .01–.015, on firm sand, gravel and soil .04–.08, on loose sand
    .2–.4. For balls on turf they follow from how far one rolls: a golf ball let go at 1.83 m/s, 7
    to 12 ft on a green (stimpmeter), c = 7/10 v²/(g d) = .065–.11; a football down a ramp 1 m high,
    4 to 10 m on a pitch (FIFA, test method 03), c = 1 m / d = .1–.25, or down to two thirds of it
    if the foot of the ramp takes its part; a leather ball on grass here adds up to .1, where the
    two meet. The other rows are set between these by likeness and may
    be off by a factor of two.

    Values are for everyday objects of the kind (a hollow plastic toy, not solid polymer).
    """

    density: float
    friction: float
    restitution: float
    rolling: float
    source: str


MATERIALS: dict[str, Material] = {
    "wood": Material(650, 0.40, 0.45, 0.004, "Engineering ToolBox: pine 350–600, oak 600–900"),
    "metal": Material(7800, 0.40, 0.55, 0.001, "steel; dry steel on steel .4–.7"),
    "rubber": Material(1100, 0.80, 0.70, 0.010, "natural rubber; friction .6–.9 on dry floors"),
    "ice": Material(917, 0.03, 0.30, 0.002, "ice on ice .02–.05"),
    "glass": Material(2500, 0.40, 0.50, 0.001, "soda-lime glass"),
    "plastic": Material(950, 0.35, 0.45, 0.003, "polyethylene, ABS"),
    "stone": Material(2600, 0.55, 0.35, 0.003, "granite 2600–2700"),
    "foam": Material(40, 0.60, 0.25, 0.015, "expanded polystyrene 15–50"),
    "paper": Material(700, 0.40, 0.10, 0.010, "paper stock, books 600–800"),
    "ceramic": Material(2300, 0.40, 0.45, 0.002, "stoneware"),
    "clay": Material(1800, 0.60, 0.05, 0.080, "damp clay"),
    "fruit": Material(950, 0.45, 0.30, 0.015, "apples 800–900, citrus 950"),
    "snow": Material(300, 0.20, 0.05, 0.060, "settled snow 200–400"),
    "cardboard": Material(150, 0.45, 0.20, 0.015, "empty boxes"),
    "water_filled": Material(1000, 0.40, 0.20, 0.020, "a full bottle or bag"),
    "leather": Material(75, 0.50, 0.70, 0.010, "an inflated ball: 0.43 kg at 22 cm diameter"),
    "fabric": Material(250, 0.60, 0.05, 0.030, "cotton cloth, bulk"),
    "grass": Material(1200, 0.60, 0.30, 0.090, "turf as ground, cut short"),
    "carpet": Material(300, 0.65, 0.10, 0.030, "floor covering"),
    "concrete": Material(2400, 0.65, 0.35, 0.006, "paving"),
    "foliage": Material(3, 0.60, 0.10, 0.030, "a plant and the air in its outline, see `plants`"),
}


def material(name: str) -> Material:
    """The row of that name; the program's validation has made sure that it exists."""
    return MATERIALS[name]
