"""Pictures that bite: each is read or refused in a sentence, in little memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.benchmark.bad_pictures import KINDS, LARGEST, cost_of

MOST_MB, MOST_LARGEST_MB = 300, 450
"""Of the whole process; the second for 49 million pixels, the largest that are read."""
REFUSED = {
    "30000 x 30000 PNG": "at most 50 million",
    "65500 x 65500 JPEG": "at most 50 million",
    "16 bits, 7000 x 7000": "save it at 8 bits",
    "animated": "animation",
    "archive": "zip archive",
}


@pytest.mark.parametrize("name", KINDS)
def test_little_memory_and_one_sentence(name: str, tmp_path: Path) -> None:
    path = tmp_path / "picture.png"
    KINDS[name](path)
    cost = cost_of(path)
    assert cost.peak < (MOST_LARGEST_MB if name == LARGEST else MOST_MB), cost
    assert REFUSED.get(name, "") in cost.said
    assert cost.said.startswith("refused" if name in REFUSED else "read 64x64x3") or (
        name == LARGEST and cost.said == "read 7000x7000x3"
    )
