"""The paper's benchmark with pictures of our own: 27 scenes, 80 events, five families.

In: a seed. Out: case folders with a picture, clicks and sentences, a reference contract for each
event, and the tables of what became of them. `scenes.yaml` and `events.yaml` say what there is,
`pictures` draws it, `listing` reads and writes it as cases, `bench` runs it and writes the page.
"""
