"""What was behind the things: the photo with them, their shadows and reflections taken out.

In: the image, masks, supports and camera. Out: the background plate (H, W, 3). `plate` is the door.
What belongs to a thing is found by `cast_shadows`, `detached_shadows`, `floor_reflections` and
`leftovers`; what goes on behind it by `lines_behind`, `edges_onward` and `edges_through`; holes are
filled by `mosaic` (shift-map candidates, graph-cut labels, Poisson blend), `smooth_fill` and
`harmonic_fill`.
"""
