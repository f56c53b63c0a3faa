"""Sentence and scene → event program: which action acts when, and how hard.

In: intents, measures, mechanics. Out: actions with closed-form numbers. `choosing` picks a script
for each thing that is set going; `scripts` hold one way of setting a thing going each.
"""
