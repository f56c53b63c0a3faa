"""V: judges the reconstruction and the rollout from measured facts; never proposes.

In: evidence. Out: an `Assessment` with checks and mismatches. `verifier` is the door, `diagnosing`
puts failed checks into words.
"""
