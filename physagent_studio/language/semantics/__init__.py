"""Clauses → event frames: who does what to whom, how, where to, and how much.

In: clauses and the inventory of things. Out: `EventFrame`s of a `Reading`.
"""
