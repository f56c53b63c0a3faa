"""Many runs of programs: sweeps over numbers, robustness, and what an edit is to thank for.

In: `Target`s (a complete program with its scene), numbers to move, an `Executor` of `jobs`. Out:
one `Ran` for each different program. `plan` makes the programs, `run` is the task, `carry_out` sees
to it that each is carried out once, `store` keeps them in a folder, `table` and `page` show them.
"""

from physagent_studio.sweep.carry_out import carry_out
from physagent_studio.sweep.plan import Plan, Point, Target, planned
from physagent_studio.sweep.run import Ran, Store, ran
