"""Sentence → event contract: what each clause demands of a rollout.

In: the reading of the prompt and the scene's measures. Out: the contract's statements, in order.
`compile` is the door; `senses` has one small builder per sense of a verb; `untold` says which words
no statement speaks of.
"""
