"""How fast the studio is: what `physagent bench studio` prints, one row for every promise."""

from physagent_studio.studio.figures.masks import examples
from physagent_studio.studio.figures.measure import measure_studio
from physagent_studio.studio.figures.safety import measure_safety
from physagent_studio.studio.figures.wire import Figure
