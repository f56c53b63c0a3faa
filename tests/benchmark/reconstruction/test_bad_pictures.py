"""Pictures that bite: each is read or refused in a sentence, in little memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.benchmark.reconstruction.bad_pictures import KINDS, cost_of

MOST_MB = 300
"""Of the whole process."""
READ = {
    "largest that is kept": "read 4950x4950x3",
    "JPEG of a telephone, 50 million pixels": "read 2880x4320x3",
}
REFUSED = {
    "30000 x 30000 PNG": "at most 24 million",
    "65500 x 65500 JPEG": "at most 24 million",
    "16 bits, 4950 x 4950": "save it at 8 bits",
    "animated": "animation",
    "archive": "zip archive",
}


@pytest.mark.parametrize("name", KINDS)
def test_little_memory_and_one_sentence(name: str, tmp_path: Path) -> None:
    path = tmp_path / "picture.png"
    KINDS[name](path)
    cost = cost_of(path)
    assert cost.peak < MOST_MB, cost
    assert REFUSED.get(name, "") in cost.said
    assert cost.said.startswith("refused" if name in REFUSED else READ.get(name, "read 64x64x3"))
