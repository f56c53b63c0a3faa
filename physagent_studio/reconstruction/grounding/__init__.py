"""Words and things: what a name says of a thing, and where in the picture it may be.

In: names, and what the sentence asks to be found. Out: usual sizes and shapes by name, which things
are of one kind, proposals of spots with their scores.
"""
