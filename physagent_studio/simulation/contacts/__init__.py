"""Contacts while the engine runs: read, summed up per step, and what follows from them.

In: the engine's contact list. Out: touches per pair; friction that grips, impacts that give no
energy away, joints that break, wheels that roll along their axis.
"""
