"""A pair's restitution in MuJoCo's terms; how two materials meet is `materials.combine`."""

IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Nearly hard contact (`solimp`): 99 % of the demanded deceleration at any depth."""

STIFFNESS = 0.15
"""√k · dt of the contact spring: larger lifts rebounds at random, smaller sinks under load."""

EXCESS = 0.021
"""What the spring adds to the restitution of a lively contact on average; it is taken off."""

LIVELIEST = 0.97
"""Restitution above this could gain energy by the spring's scatter."""


def reference(restitution: float, dt: float, slow_depth: float = 0.0) -> tuple[float, float]:
    """MuJoCo's direct `solref` (−stiffness, −damping) that bounces with `restitution`.

    The damper alone reverses the approach speed within one engine step: a = −(1 + e) v / dt.
    slow_depth: an overlap in m that must come apart slowly (0.1 m/s), not be shot out.
    """
    lively = min(restitution, LIVELIEST)
    # A dead contact loses the excess while it comes apart, a lively one keeps it.
    damping = (1 + lively - EXCESS * lively / (lively + 0.3)) / dt
    stiffness = (STIFFNESS / dt) ** 2
    if slow_depth > 0:
        stiffness = min(stiffness, 0.1 * damping / slow_depth)
    return -stiffness, -damping
