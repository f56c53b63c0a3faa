"""How fast the studio is: what `physagent bench studio` prints, one row for every promise."""

from physagent_studio.studio.figures.figure import Figure
from physagent_studio.studio.figures.masks import examples
from physagent_studio.studio.figures.measure import measure_studio
from physagent_studio.studio.figures.safety import measure_safety

__all__ = ["Figure", "examples", "measure_safety", "measure_studio"]
