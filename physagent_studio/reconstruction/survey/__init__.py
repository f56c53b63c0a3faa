"""The picture read as a whole, before anything is placed: cues, levels, landmarks.

In: masks and the scene state as far as it is stated. Out: a `Survey`: who stands where, the camera,
metres, the levels of supports. `survey.survey` is the door; `sighting` gathers the camera's cues.
"""
