"""Believable photographs with exact truth: procedural textures, a path tracer, a sensor model.

Needs Mitsuba 3 (`pip install -r tools/requirements.txt`). Nothing here is imported by the
product or by its tests; only the pictures and truth files it writes are.
"""
