"""The camera from the picture: horizon, focal length, roll, height, and how sure each is.

In: line segments, right angles, stated values. Out: a `Camera`, its spread, and rays of pixels.
`estimate` decides the focal length and the horizon, `scale` the metres.
"""
