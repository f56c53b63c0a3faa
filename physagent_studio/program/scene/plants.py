"""What grows, as a soft body: light, held at its foot, as stiff as it sways in nature.

A tree weighs little for the room it takes. A broadleaf with a crown of 5 m and a stem of 16 cm has
95 kg of dry wood and leaves above the ground (Jenkins et al. 2003, Forest Science 49, 12), twice
that when fresh, in an outline of 75 m³: 2.5 kg/m³; one of 10 m and 35 cm 1.8 kg/m³; slender
crowns, small plants and grass two to five times that. The material `foliage` is 3 kg/m³.

How far it bends follows from the frequency at which it sways. Plants are as thick as they must be
to stand, so that the frequency goes with one over the root of their height (McMahon and Kronauer
1976, J. theor. Biol. 59, 443): about 0.35 Hz for a tree of 15 m (Moore and Maguire 2004, Trees
18, 195), 0.6 Hz at 5 m, some 1.7 Hz for wheat and 2.5 Hz for a flower of 30 cm (de Langre 2008,
Annu. Rev. Fluid Mech. 40, 141). A tenth of the critical damping stops it (James et al. 2006, Am.
J. Bot. 93, 1522: 8 to 20 % for crowns in leaf). Its weight then bends it by a fifth at most more
than wind alone, whatever its height, so that it does not sag.
"""

import math

from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.materials import MATERIALS

FOLIAGE = "foliage"
"""The material of a plant that bends as a whole."""

SWAY = 1.4
"""Hz · √m: the frequency of a plant times the root of its height."""

DAMPING = 0.1
"""Share of the critical damping at that frequency."""

_BEND = {"box": (25.0, 70.0), "cylinder": (33.0, 80.0)}
"""a, b in E = ρ f² h² (a + b r) / r² for a body of height h and width r h, that sways with f.

Measured with the engine's quadratic bodies held at their foot; within 6 % of the frequency for r
of .05 to 1.4. Where r is small it is Euler's beam, and where it is not, shear bends it too.
"""

_ROUND = (40.0, 155.0)
"""The same for ellipsoids, and for the outlines of crowns."""


def sway_frequency(height: float) -> float:
    """Hz at which a plant of a height in m sways to and fro."""
    return SWAY / math.sqrt(height)


def plant_body(kind: str, height: float, width: float) -> Soft:
    """A body of `foliage` that is held at its foot and sways as a plant of its height.

    kind: of the shape. height, width: m, of its outline; of two widths their geometric mean.
    """
    ratio, frequency = width / height, sway_frequency(height)
    a, b = _BEND.get(kind, _ROUND)
    speed = frequency * height / ratio
    young = MATERIALS[FOLIAGE].density * speed * speed * (a + b * ratio)
    damping = 2 * DAMPING / (2 * math.pi * frequency)
    return Soft(pinned="bottom", young=round(max(young, 10.0), 1), damping=round(damping, 4))
