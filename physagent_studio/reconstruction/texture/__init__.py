"""The photo on the solids: what it shows as it shows it, hidden sides made plausible.

In: meshes in their places, the image, masks. Out: textured meshes led to their outlines, their
light taken out where they turn. `skins` is the door.
"""
