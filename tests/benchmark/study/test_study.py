import json
import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.study.server import StudyServer
from physagent_studio.benchmark.study.trials import (
    PER_CATCH,
    Answer,
    Study,
    counted,
    keep,
    pairs,
    read_answers,
    study_of,
    summary,
)
from physagent_studio.errors import InputError


def clips(folder: Path, methods: tuple[str, ...], count: int) -> Path:
    """Plain pictures, one colour for each method."""
    for level, method in enumerate(methods):
        (folder / method).mkdir(parents=True)
        for k in range(count):
            picture = np.full((12, 16, 3), 255 * level // (len(methods) - 1), np.uint8)
            cv2.imwrite(str(folder / method / f"clip_{k}.png"), picture)
            (folder / method / f"clip_{k}.txt").write_text("The ball rolls.\n")
    return folder


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return study_of(clips(tmp_path, ("ours", "theirs"), 24), seed=5)


def test_each_pair_is_asked_once_in_another_order_for_each_rater(study: Study) -> None:
    one, other = study.trials("ann"), study.trials("bob")
    assert one == study.trials("ann") != other
    asked = Counter(trial.clip for trial in one if not trial.catch)
    assert asked == {f"clip_{k}": 1 for k in range(24)}
    assert sum(trial.catch for trial in one) == 24 // PER_CATCH
    left = sum(trial.left == "ours" for rater in "abcdefgh" for trial in study.trials(rater))
    assert 70 <= left <= 140


def test_a_folder_without_pairs_is_refused(tmp_path: Path) -> None:
    clips(tmp_path, ("ours", "theirs"), 1)
    (tmp_path / "theirs" / "clip_0.png").rename(tmp_path / "theirs" / "other.png")
    with pytest.raises(InputError, match="at least two methods"):
        study_of(tmp_path)


# --- figures -----------------------------------------------------------------------------------


def answers_of(study: Study, rater: str, liking: float, seed: int, sees: bool = True) -> None:
    """All answers of a rater who likes `ours` with that chance."""
    rng = np.random.default_rng(seed)
    for number, trial in enumerate(study.trials(rater)):
        wanted = "ours" if rng.random() < liking else "theirs"
        if trial.catch:
            wanted = trial.left or trial.right if sees else ""
        side = "left" if trial.left == wanted else "right"
        keep(
            study.folder / "answers.csv",
            Answer(rater, number, trial.clip, trial.left, trial.right, side, 1.0),
        )


def test_a_known_bias_lies_in_its_interval(study: Study) -> None:
    for k in range(8):
        answers_of(study, f"r{k}", 0.7, k)
    answers_of(study, "asleep", 0.0, 99, sees=False)
    good, left_out = counted(read_answers(study.folder))
    assert left_out == ["asleep"]
    (pair,) = pairs(good)
    assert pair.count == 8 * 24
    assert pair.low < 0.7 < pair.high
    assert pair.p < 0.001
    assert "Left out" in "\n".join(summary(read_answers(study.folder)))


def test_each_pair_of_three_methods_has_its_share() -> None:
    rng = np.random.default_rng(1)
    methods, answers = ("a", "b", "c"), []
    for k in range(900):
        one, other = sorted(rng.choice(3, 2, replace=False))
        wins = rng.random() < 0.5 + 0.2 * (other - one)
        pair = (methods[one], methods[other])
        answers.append(Answer("r", k, "x", *pair, "left" if wins else "right", 1.0))
    for pair in pairs(answers):
        true = 0.5 + 0.2 * (ord(pair.other) - ord(pair.one))
        assert pair.low < true < pair.high
        assert pair.high - pair.low < 0.15


def test_another_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "answers.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="another file"):
        read_answers(tmp_path)


# --- the server --------------------------------------------------------------------------------


@pytest.fixture
def server(study: Study) -> Iterator[StudyServer]:
    with StudyServer(study) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def got(server: StudyServer, path: str, **headers: str) -> bytes:
    with urlopen(Request(server.address + path, headers=headers), timeout=20) as reply:
        return reply.read()


def sent(server: StudyServer, answer: dict[str, object], **headers: str) -> dict[str, object]:
    told = {"Content-Type": "application/json", **headers}
    request = Request(server.address + "answer", json.dumps(answer).encode(), told)
    with urlopen(request, timeout=20) as reply:
        return json.loads(reply.read())


def test_an_answer_is_kept_once_and_the_next_trial_comes(server: StudyServer) -> None:
    asked = json.loads(got(server, "next?rater=ann"))
    assert (asked["trial"], asked["done"]) == (0, 0)
    assert "ours" not in json.dumps(asked)
    answer = {"rater": "ann", "trial": 0, "choice": "left", "seconds": 1.5}
    assert sent(server, answer)["trial"] == 1
    assert sent(server, {**answer, "choice": "right"})["trial"] == 1
    (kept,) = read_answers(server.study.folder)
    assert kept.choice == "left"
    again = StudyServer(server.study)
    assert again.asked("ann")["trial"] == 1
    again.server_close()


def test_a_part_of_a_clip_is_given(server: StudyServer) -> None:
    trials = server.study.trials("ann")
    number = next(k for k, trial in enumerate(trials) if not trial.catch)
    whole = got(server, f"clip/{number}/left?rater=ann")
    assert got(server, f"clip/{number}/left?rater=ann", Range="bytes=3-9") == whole[3:10]


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("next?rater=", {}),
        ("next?rater=../x", {}),
        ("clip/999/left?rater=ann", {}),
        ("answers.csv?rater=ann", {}),
        ("next?rater=ann", {"Host": "evil.example"}),
        ("next?rater=ann", {"Origin": "http://evil.example"}),
    ],
)
def test_what_nobody_should_ask_is_refused(
    server: StudyServer, path: str, headers: dict[str, str]
) -> None:
    with pytest.raises(HTTPError) as refused:
        got(server, path, **headers)
    assert refused.value.code in (403, 404)


def test_what_is_no_answer_is_refused(server: StudyServer) -> None:
    answer = {"rater": "ann", "trial": 0, "choice": "both", "seconds": 1}
    for wrong in (answer, {**answer, "choice": "left", "trial": 999}, {}):
        with pytest.raises(HTTPError) as refused:
            sent(server, wrong)
        assert refused.value.code == 400
    assert not read_answers(server.study.folder)
