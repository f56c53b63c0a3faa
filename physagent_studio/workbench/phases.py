"""What is going on in each phase, in words."""

RUNNING = {
    "generate": "reading the photo and the sentence",
    "reconstruct": "reconstructing the scene",
    "simulate": "simulating",
    "judge": "judging",
    "propose": "searching for a repair",
    "ease": "looking for a gentler way",
    "decide": "deciding",
}
"""Phase → what is being done in it."""

INTERRUPTED = (
    "What was going on when this was closed ({what}: {phase}) was cut short. Everything before it"
    " is kept; Step does it again."
)
