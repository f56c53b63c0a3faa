"""Masks → solids: primitives, surfaces of revolution, rings, inflated outlines, and meshes.

In: a mask, the camera and the names' usual shapes. Out: fitted shapes, best first, and a triangle
mesh (m, body frame) of any shape. `forms` is the door.
"""
