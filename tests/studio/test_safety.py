"""Very small doses of `physagent bench safety`, and the page below a prefix of a proxy."""

from __future__ import annotations

import msgspec
import pytest

from physagent_studio.studio.figures import safety
from physagent_studio.studio.guard import FROM_EDITOR, FROM_VIEWER, is_harmless
from physagent_studio.studio.site import _pages


def _wrong(figures: list[safety.Figure]) -> list[str]:
    return [one.name for one in figures if not one.ok]


def test_who_may_come_in() -> None:
    assert _wrong(safety._logins()) == []


def test_hostile_messages_change_nothing() -> None:
    assert _wrong(safety._messages(150)) == []


MOVE = {
    "type": "TransformControlsUpdateMessage",
    "name": "/x",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 1.0, 2.0],
    "owner": "",
}


def test_the_sieve_of_3d_views() -> None:
    whole = msgspec.msgpack.encode(MOVE)
    assert is_harmless(whole, FROM_EDITOR)
    assert not is_harmless(whole, FROM_VIEWER)


@pytest.mark.parametrize(
    "change",
    [
        {"position": [float("nan"), 0.0, 0.0]},
        {"position": [0.0, 0.0]},
        {"wxyz": "1000"},
        {"name": 7},
        {"type": "ShareUrlRequest"},
        {"type": "SceneNodeUpdateMessage"},
        {"type": ["x"]},
        {"extra": 1},
        {"position": [1e300, 0.0, 0.0]},
    ],
)
def test_what_sets_anything_else_is_not_heard(change: dict[str, object]) -> None:
    assert not is_harmless(msgspec.msgpack.encode(MOVE | change), FROM_EDITOR)


def test_the_page_asks_below_its_own_address() -> None:
    text = _pages()["/index.html"].body.decode()
    assert 'href="/' not in text
    assert 'src="/' not in text
