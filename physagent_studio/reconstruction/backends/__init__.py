"""Files from outside: meshes that a person brings, and learned models fetched on request.

In: bytes or an address. Out: bounded, checked meshes (`mesh_files`), models on disk (`zoo_files`).
"""
