"""A study with people: which of two clips is better, two alternatives and no third.

In: a folder with one folder for each method, clips of the same names in them. Out: a page on
loopback that asks, `answers.csv`, and figures. `trials` says what is asked of whom,
keeps the answers and counts them; `server` serves the page.
"""
