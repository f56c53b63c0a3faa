"""The materials table: density, friction and restitution by name, with their sources."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Material:
    """density: kg/m³. friction: Coulomb coefficient against itself. restitution: 0 … 1.

    Values are for everyday objects of the kind (a hollow plastic toy, not solid polymer).
    """

    density: float
    friction: float
    restitution: float
    source: str


MATERIALS: dict[str, Material] = {
    "wood": Material(650, 0.40, 0.45, "Engineering ToolBox: pine 350–600, oak 600–900"),
    "metal": Material(7800, 0.40, 0.55, "steel; dry steel on steel .4–.7"),
    "rubber": Material(1100, 0.80, 0.70, "natural rubber; friction .6–.9 on dry floors"),
    "ice": Material(917, 0.03, 0.30, "ice on ice .02–.05"),
    "glass": Material(2500, 0.40, 0.50, "soda-lime glass"),
    "plastic": Material(950, 0.35, 0.45, "polyethylene, ABS"),
    "stone": Material(2600, 0.55, 0.35, "granite 2600–2700"),
    "foam": Material(40, 0.60, 0.25, "expanded polystyrene 15–50"),
    "paper": Material(700, 0.40, 0.10, "paper stock, books 600–800"),
    "ceramic": Material(2300, 0.40, 0.45, "stoneware"),
    "clay": Material(1800, 0.60, 0.05, "damp clay"),
    "fruit": Material(950, 0.45, 0.30, "apples 800–900, citrus 950"),
    "snow": Material(300, 0.20, 0.05, "settled snow 200–400"),
    "cardboard": Material(150, 0.45, 0.20, "empty boxes"),
    "water_filled": Material(1000, 0.40, 0.20, "a full bottle or bag"),
    "leather": Material(75, 0.50, 0.70, "an inflated ball: 0.43 kg at 22 cm diameter"),
    "fabric": Material(250, 0.60, 0.05, "cotton cloth, bulk"),
    "grass": Material(1200, 0.60, 0.30, "turf as ground"),
    "carpet": Material(300, 0.65, 0.10, "floor covering"),
    "concrete": Material(2400, 0.65, 0.35, "paving"),
}


def material(name: str) -> Material:
    """The row of that name; the program's validation has made sure that it exists."""
    return MATERIALS[name]
