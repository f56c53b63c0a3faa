"""The command line `physagent`.

Exit codes: 0 done, 1 our fault, 2 bad input, 3 ran but not realised (or blown up, or with an
untested clause or word), 4 waiting for a decision, 130 cancelled.
"""

from physagent_studio.cli.app import main
