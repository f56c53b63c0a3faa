"""The reflective agent: roles, loop, evidence, memory, reviewer policies."""
