"""What a module that is run as a program does comes after all that it defines."""

from __future__ import annotations

import ast
from pathlib import Path

import physagent_studio


def test_the_main_block_is_last() -> None:
    found = 0
    for path in Path(physagent_studio.__file__).parent.rglob("*.py"):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        for place, node in enumerate(body):
            if isinstance(node, ast.If) and "__main__" in ast.unparse(node.test):
                found += 1
                assert place == len(body) - 1, f"{path.name} goes on after its main block"
    assert found > 3
