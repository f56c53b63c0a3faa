"""What the sentence asks of the scene: materials, bodies, what hangs, tables that only words name.

In: the case, its reading, a reconstructed scene. Out: fields of the scene state, and `measures`:
distances, sizes and masses that contract and schedule work with.
"""
