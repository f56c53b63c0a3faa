"""From one photograph and one sentence to a physical program that makes the event happen."""

__version__ = "0.1.0"
