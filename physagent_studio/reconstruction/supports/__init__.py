"""Floors, tables, ramps, blocks and stairs by their edges, and what stands on which.

In: masks, clicks, line segments, the camera. Out: stances of things, profiles of ramps, slabs,
blocks and flights of steps. `stances` and `standing` say what stands on what.
"""
