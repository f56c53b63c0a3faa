"""The stepping loop and what a run writes down.

In: a compiled model and scheduled effects. Out: raw states, from which `measure` makes a rollout.
`engine` is the door; `free_flight` finds the steps that can be run at a stretch; `resume` runs
again from a snapshot.
"""
