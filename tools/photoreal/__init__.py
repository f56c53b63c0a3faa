"""Believable photographs with exact truth: procedural textures, a path tracer, a sensor model.

Two tracers: `stage` and `shoot` need Mitsuba 3 (`pip install -r tools/requirements.txt`); `fields`,
with `props` and `toys`, needs NumPy and OpenCV alone. Nothing here is imported by the product or by
its tests; only the pictures and truth files it writes are.
"""
