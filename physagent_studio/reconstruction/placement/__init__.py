"""Things and supports put in their places: at rest, out of one another, carried.

In: the survey, masks and shapes. Out: supports with numbers, and objects with poses (m, world
frame) whose first frame covers their masks. `place` is the door; `depenetration` keeps bodies
out of one another, `static_stability` lets them stand.
"""
