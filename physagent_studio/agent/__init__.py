"""The reflective agent: roles, loop, evidence, memory, reviewer policies.

`loop.advance` takes a stored state to the next phase: what the verifier of `rules` or `vlm`
finds, the planner of either answers, and a policy or a person decides.
"""
