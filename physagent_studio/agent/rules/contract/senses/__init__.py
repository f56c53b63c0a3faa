"""What each sense of a verb demands: one small builder of statements per sense."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from physagent_studio.agent.rules.contract.senses.acting import crush, hit, kick, knock_over, push
from physagent_studio.agent.rules.contract.senses.arriving import (
    approach,
    cross,
    enter,
    land,
    leave,
    lose_support,
    miss,
    reach,
    strike,
    withdrawn,
)
from physagent_studio.agent.rules.contract.senses.leaping import jump
from physagent_studio.agent.rules.contract.senses.motion import (
    bounce,
    circle,
    curve,
    descend,
    fall,
    float_down,
    fly,
    move,
    rise,
    roll,
    set_down,
    slide,
    slip,
)
from physagent_studio.agent.rules.contract.senses.resting import be, end, slow, stack, stay, stop
from physagent_studio.agent.rules.contract.senses.turning import (
    flip,
    lose_balance,
    reverse,
    spin,
    topple,
    turn,
    turn_around,
)
from physagent_studio.agent.rules.contract.senses.yielding import (
    bend,
    break_apart,
    collapse,
    deform,
    lean,
    recover,
    spread,
    sway,
    wind,
)
from physagent_studio.agent.rules.contract.specs import Context, Spec

Builder = Callable[[Context], Sequence[Spec]]

SENSES: dict[str, Builder] = {
    "move": move, "slide": slide, "drift": move, "accelerate": move, "roll": roll, "fly": fly,
    "curve": curve, "circle": circle, "fall": fall, "descend": descend, "set_down": set_down,
    "float": float_down,
    "rise": rise, "jump": jump, "bounce": bounce, "slip": slip, "hit": hit, "push": push,
    "pull": push, "dislodge": push, "kick": kick, "throw": kick, "knock": hit,
    "knock_over": knock_over, "tip_over": knock_over, "crush": crush, "topple": topple,
    "lose_balance": lose_balance, "flip": flip, "spin": spin, "turn": turn,
    "turn_around": turn_around, "reverse": reverse, "reach": reach, "strike": strike,
    "withdrawn": withdrawn, "cross": cross, "pass": cross, "enter": enter,
    "land": land, "approach": approach, "leave": leave, "miss": miss,
    "lose_support": lose_support, "stop": stop, "slow": slow, "settle": stop, "stay": stay,
    "rest": be,
    "hang": be, "be": be, "end": end, "stack": stack, "wind": wind, "sway": sway, "bend": bend,
    "lean": lean, "collapse": collapse, "break": break_apart, "spread": spread,
    "deform": deform, "recover": recover,
}  # fmt: skip
"""Builders by sense; a sense without one leaves its clause untested, and that is shown."""
