"""A server ends when it is told to, also by two who tell it at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

SERVES = """
from physagent_studio.cli import serving
print("serving", flush=True)
serving._until_interrupted()
"""


def test_it_ends_however_often_it_is_interrupted():
    told = subprocess.Popen([sys.executable, "-c", SERVES], stdout=subprocess.PIPE)
    assert told.stdout is not None
    assert told.stdout.readline() == b"serving\n"
    time.sleep(0.3)
    try:
        for _ in range(200):
            for number in (signal.SIGINT, signal.SIGTERM):
                if told.poll() is None:
                    os.kill(told.pid, number)
        # Told while it ends, it may end by that.
        assert told.wait(timeout=60) in (0, -signal.SIGTERM, -signal.SIGINT, 1)
    finally:
        told.kill()
        told.stdout.close()
