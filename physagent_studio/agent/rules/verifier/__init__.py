"""V: judges the reconstruction and the rollout from measured facts; never proposes.

In: evidence. Out: an `Assessment` with checks and mismatches. `verifier` is the door: `judge_scene`
lets a scene be simulated or not, from the findings of `reconstruction.checks`. `diagnosing` puts
failed checks into mismatches, which `agent.loop` hands to the planner.
"""
