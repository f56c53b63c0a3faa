"""What the sentence asks of the scene: materials, bodies, what hangs, tables that only words name.

In: the case, its reading, a reconstructed scene. Out: fields of the scene state, and `hanging`
(what hangs in the air by its words; `reconstruction.survey.aloft` adds what the picture says),
`materials`, and `measures`: distances, sizes and masses that contract and schedule work with.
"""
