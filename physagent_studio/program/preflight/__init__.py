"""What will probably go wrong, told before anything runs.

In: a program. Out: findings, each with a reason and a suggested edit. `preflight` is the door.
"""
