"""Sentence and scene → event program: which action acts when, and how hard.

In: intents, measures, mechanics. Out: actions with closed-form numbers. `choosing` picks a script
for each thing that is set going; `scripts` hold one way of setting a thing going each: "to the
left", read by `language.semantics.prepositions`, becomes a direction in `scripts.task`, and a
force by `simulation.actions.vectors` while it runs. `pacing` takes the verbs' speeds into the
contract, `heading` says which way wheels face.
"""
