"""Record once, replay for ever: no network, no key, no SDK."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.vlm import crew_of, wire
from physagent_studio.agent.vlm.config import Endpoint, Limits, Settings, TapeSettings
from physagent_studio.agent.vlm.messages import Picture, Question, TapeMiss, Turn
from physagent_studio.agent.vlm.spending import CallRecord, Ledger
from physagent_studio.agent.vlm.tape import Tape
from physagent_studio.errors import InputError
from physagent_studio.records import LoopState
from tests.agent.vlm import scripted, world
from tests.agent.vlm.server import Model, ModelServer

Serve = Callable[[Model], ModelServer]
KEY = "sk-test-0123456789abcdef"


def settings(url: str, folder: Path, mode: str) -> Settings:
    endpoint = Endpoint.model_validate({"base_url": url, "model": "scripted", "key": KEY})
    return Settings(
        endpoints={"generator": endpoint, "verifier": endpoint, "planner": endpoint},
        tape=TapeSettings.model_validate({"folder": folder, "mode": mode}),
    )


def run(crew: Crew) -> LoopState:
    bench, state = world.bench(), LoopState(policy="auto")
    while state.phase != "done":
        state = advance(state, crew, bench)
    return state


def programs(state: LoopState) -> list[str]:
    return [item.program.hash for item in state.path()]


def test_a_whole_case_replays_offline(
    serve: Serve, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = serve(scripted.competent)
    recorded = run(crew_of(settings(server.url, tmp_path, "record"), Ledger()))
    sent = len(server.asked)

    def unplugged(*args: object) -> None:
        raise AssertionError("a replay must not reach for the network")

    monkeypatch.setattr(wire, "send", unplugged)
    told: list[CallRecord] = []
    ledger = Ledger(Limits(calls=1))
    replayed = run(
        crew_of(settings("http://127.0.0.1:9/v1", tmp_path, "replay"), ledger, record=told.append)
    )
    assert programs(replayed) == programs(recorded)
    assert [item.proposal for item in replayed.path()] == [
        item.proposal for item in recorded.path()
    ]
    assert replayed.outcome == "realised"
    assert [call.outcome for call in told] == ["replayed"] * sent
    assert (ledger.calls, ledger.money) == (0, 0)
    for path in tmp_path.glob("*.json"):
        assert KEY not in path.read_text()
        assert "base64" not in path.read_text()


def ask(words: str, *pictures: Picture) -> Question:
    return Question("test", (Turn("user", (words, *pictures)),), "Form", {"type": "object"})


def test_the_key_of_a_call_is_what_is_said(tmp_path: Path) -> None:
    photo = world.PHOTO
    darker = (photo - 1).astype(photo.dtype)
    base = ask("Look", Picture(photo, "one"))
    assert base.key("m") == ask("Look", Picture(photo.copy(), "one")).key("m")
    different = [
        ask("look", Picture(photo, "one")),
        ask("Look", Picture(darker, "one")),
        ask("Look", Picture(photo, "two")),
        ask("Look"),
        base.again("{}", "no"),
    ]
    keys = {base.key("m"), base.key("n"), *(one.key("m") for one in different)}
    assert len(keys) == 2 + len(different)


def test_another_machines_pixels_find_the_call_by_its_words(tmp_path: Path) -> None:
    from physagent_studio.agent.vlm.messages import Answer

    Tape(tmp_path, False).keep(
        ask("Look", Picture(world.PHOTO, "one")), "m", Answer("yes"), hide=""
    )
    tape = Tape(tmp_path, True)
    other = (world.PHOTO + 1).astype(world.PHOTO.dtype)
    found = tape.find(ask("Look", Picture(other, "one")), "m")
    assert found is not None
    assert found.text == "yes"
    with pytest.raises(TapeMiss, match="not among the calls recorded"):
        tape.find(ask("Look away", Picture(other, "one")), "m")
    # Two calls with the same words: guessing which would be wrong.
    Tape(tmp_path, False).keep(
        ask("Look", Picture(world.PHOTO[:4], "one")), "m", Answer("no"), hide=""
    )
    with pytest.raises(TapeMiss, match="2 that differ in their pictures"):
        tape.find(ask("Look", Picture(other, "one")), "m")


@pytest.mark.parametrize("damage", ["", "[]", '{"format": 7}', '{"format": 1, "answer": 3}'])
def test_a_damaged_recording_is_said(damage: str, tmp_path: Path) -> None:
    question = ask("Look")
    (tmp_path / f"{question.key('m')}.json").write_text(damage)
    with pytest.raises(InputError, match=str(tmp_path)):
        Tape(tmp_path, True).find(question, "m")


def test_a_recording_reads_as_a_conversation(tmp_path: Path) -> None:
    from physagent_studio.agent.vlm.messages import Answer

    question = ask("Look", Picture(world.PHOTO, "one"))
    Tape(tmp_path, False).keep(question, "m", Answer(f"yes {KEY}"), hide=KEY)
    data = json.loads((tmp_path / f"{question.key('m')}.json").read_text())
    assert data["turns"][0]["parts"][0] == "Look"
    assert data["turns"][0]["parts"][1]["picture"] == Picture(world.PHOTO, "one").digest
    assert data["answer"]["text"] == "yes ***"
