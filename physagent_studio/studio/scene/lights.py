"""How the scene is lit: cheaply, since many of those who look at it have no graphics card.

Photo textures carry their own light and are drawn unlit. What is left to be lit are things that
have only a colour, arrows and ghosts. viser's own set-up serves glossy renderings: it sorts a
photographed sky into a pyramid of blurred ones, for which a processor that has to do it takes four
seconds at every opening, and draws three maps of shadows before every frame.
"""

from __future__ import annotations

import math

import viser

SKY, GROUND, STRENGTH = (255, 255, 255), (190, 182, 172), 1.55
SIDE, SIDE_STRENGTH = (6.0, -1.5, 3.0), 1.5
"""What stands in for the sky: all of it, and its bright side, a place that shines towards the
origin, world, m. Chosen so that colours look as they did under viser's own."""


def light(scene: viser.SceneApi) -> None:
    """Lights a scene without a photographed sky and without shadows."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(cast_shadow=False)
    # The light's own up is y; the world's is z.
    half = math.sqrt(0.5)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=SKY, ground_color=GROUND, intensity=STRENGTH,
        wxyz=(half, half, 0, 0),
    )  # fmt: skip
    scene.add_light_directional("/light/side", intensity=SIDE_STRENGTH, position=SIDE)
