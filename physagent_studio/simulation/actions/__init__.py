"""The nine operators at run time: windows, vectors by meaning, forces on bodies.

In: the event program and the running `World`. Out: impulses, forces and poses applied per step.
`effects` is the door.
"""
