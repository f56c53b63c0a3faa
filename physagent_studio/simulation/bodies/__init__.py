"""What a shape weighs and how it collides; soft and loose things as many small bodies.

In: shapes and materials of the program. Out: convex pieces, exact masses, flexes, grains, geoms.
"""
