"""P: from a mismatch to the smallest change that repairs it.

In: a `Situation` (program, rollout, assessment, memory, and a way to try programs). Out: a
`Proposal`. `planner` is the door; `factors` maps mismatches to factors, `parameters` lists the
numbers that can be turned, `parameter_search` and `goal_search` find them by runs, `directing` sets
time and way in the picture, `easing` lowers efforts after a pass.
"""
