"""A scene's structure → a compiled MuJoCo model, and the numbers written into it before a run.

In: the scene and its solids. Out: a `Model` which steps finely enough. `build` is the door;
`settle` takes out what overlaps a reconstruction has left (it parts them in `placement`).
"""
