"""Judges of finished clips: a model with the paper's criteria, blind, and VBench's own package.

In: a folder as of a study, one folder for each method. Out: grades from 0 to 1 for each method, and
how far a judge agrees with itself when the order is swapped.
"""
