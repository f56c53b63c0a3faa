"""Which thing a phrase speaks of: names, descriptions, pronouns, groups.

In: noun phrases and the inventory. Out: names of things.
"""
