"""A scene's structure → a compiled MuJoCo model, and the numbers written into it before a run.

In: the scene and its solids. Out: a `Model` whose bodies lie apart and which steps finely enough.
`build` is the door.
"""
