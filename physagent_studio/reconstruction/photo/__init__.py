"""The picture itself: read safely, and measured without knowing what it shows.

In: a file's bytes or an image (H, W, 3). Out: the image within bounds, its stated focal length,
masks as boolean arrays and what is done with them, straight edges, ellipses, closed contours, and
how well pixels fit a colour word.
"""
