"""Event programs from mechanics: one small script per way of setting a thing going.

Each script gets a `Task` (the object, what is said of it, the scene) and returns actions. The
numbers come from the reconstructed geometry; what the engine does beyond the formulas is left
to the rounds that follow.
"""

from physagent_studio.agent.rules.schedule.scripts.carrying import carry, turned_in_hand
from physagent_studio.agent.rules.schedule.scripts.driven import (
    drive,
    room_ahead,
    turns_off,
    way_before_turn,
)
from physagent_studio.agent.rules.schedule.scripts.edges import off_edge, way_off
from physagent_studio.agent.rules.schedule.scripts.flight import (
    bounced_steps,
    float_down,
    hop_onto,
    in_wind,
    leap,
    lift,
    through_air,
)
from physagent_studio.agent.rules.schedule.scripts.ground import along_ground, way_ahead, way_to_go
from physagent_studio.agent.rules.schedule.scripts.hopping import hop_aim, hop_along, hops_told
from physagent_studio.agent.rules.schedule.scripts.landing import (
    landed_on,
    let_go,
    off_what_it_fell_on,
    past_what_is_below,
    rock,
    rock_first,
    rock_over,
    swing,
    up_ramp,
    waft,
)
from physagent_studio.agent.rules.schedule.scripts.leaping_onto import leap_onto, top_aim
from physagent_studio.agent.rules.schedule.scripts.squeezing import is_squeezed, squeeze
from physagent_studio.agent.rules.schedule.scripts.task import Task
from physagent_studio.agent.rules.schedule.scripts.turns import (
    go_over,
    over_and_off,
    over_and_on,
    spin_about,
    spin_along,
    spin_over,
    tip,
    turn_back,
)
