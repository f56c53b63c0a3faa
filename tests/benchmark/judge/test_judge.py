import base64
import json
import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.agent.vlm import Endpoint, Ledger, Limits
from physagent_studio.agent.vlm.line import Line
from physagent_studio.benchmark.judge.agreement import agreement, scores, summary
from physagent_studio.benchmark.judge.judging import FILE, Judgement, judge
from physagent_studio.benchmark.judge.vbench import read_output, vbench_scores, write_input
from physagent_studio.benchmark.study.trials import Study, read_rows, study_of
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange import write_video
from tests.agent.vlm.server import Asked, Model, ModelServer, Reply, says

BRIGHT, DARK = 220, 40


@pytest.fixture
def study(tmp_path: Path) -> Study:
    for method, level in (("good", BRIGHT), ("poor", DARK)):
        (tmp_path / method).mkdir()
        for k in range(3):
            frames = [np.full((48, 64, 3), level, np.uint8)] * 10
            write_video(tmp_path / method / f"clip_{k}.mp4", frames, 10)
            (tmp_path / method / f"clip_{k}.txt").write_text(f"The ball rolls. {k}")
    return study_of(tmp_path)


@pytest.fixture
def connect() -> Iterator[Callable[[Model], tuple[Line, ModelServer]]]:
    with ExitStack() as stack:

        def make(model: Model) -> tuple[Line, ModelServer]:
            server = stack.enter_context(ModelServer(model))
            endpoint = Endpoint.model_validate({"base_url": server.url, "model": "scripted"})
            return Line("verifier", endpoint, Ledger(Limits())), server

        yield make


def brightness(url: str) -> float:
    data = np.frombuffer(base64.b64decode(url.split(",")[1]), np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    return float(np.median(picture))


def grades(grade: int) -> dict[str, int]:
    return {"trajectory": grade, "contact": grade, "force": grade, "material": grade}


def fair(asked: Asked) -> Reply:
    """Grades what it sees: bright clips 3, dark ones 1."""
    first, second = (3 if brightness(url) > 128 else 1 for url in asked.pictures)
    better = "first" if first > second else "second"
    verdict = {"first": grades(first), "second": grades(second), "more_real": better}
    return says(verdict | {"reason": "it is brighter"})


def hasty(asked: Asked) -> Reply:
    """Likes what comes first."""
    verdict = {"first": grades(4), "second": grades(2), "more_real": "first", "reason": "first"}
    return says(verdict)


def test_a_fair_judge_is_blind_and_agrees_with_itself(study: Study, connect: Callable) -> None:
    line, server = connect(fair)
    found = list(judge(study, line))
    assert len(found) == len(server.asked) == 6
    for asked in server.asked:
        assert len(asked.pictures) == 2
        assert "good" not in json.dumps(asked.body["messages"])
        assert "The ball rolls" in asked.text("user")
    assert scores(found) == {"good": (0.75, 0, 3), "poor": (0.25, 0, 3)}
    itself = agreement(found)
    assert itself is not None
    assert (itself.pairs, itself.same, itself.difference, itself.first) == (3, 1, 0, 0.5)
    assert list(judge(study, line)) == found
    assert len(server.asked) == 6


def test_a_judge_who_likes_what_comes_first_is_found_out(study: Study, connect: Callable) -> None:
    line, _ = connect(hasty)
    itself = agreement(list(judge(study, line)))
    assert itself is not None
    assert (itself.same, itself.first, itself.difference) == (0, 1, 0.5)
    assert itself.kappa <= 0
    assert "preferred in 100%" in "\n".join(summary(read_rows(study.folder / FILE, Judgement)))


def test_a_grade_off_the_scale_is_asked_again(study: Study, connect: Callable) -> None:
    def at_first_wrong(asked: Asked) -> Reply:
        if asked.again:
            return hasty(asked)
        wrong = {"first": grades(9), "second": grades(2), "more_real": "first", "reason": "x"}
        return says(wrong)

    line, server = connect(at_first_wrong)
    assert next(judge(study, line)).first_score == 1
    assert len(server.asked) == 2


def test_kappa_is_that_of_the_book() -> None:
    # Cohen 1960: observed (2 + 1) / 4, by chance (3 · 2 + 1 · 2) / 16.
    rows = [("a", "a"), ("a", "a"), ("b", "b"), ("a", "b")]
    both = []
    for k, (one, other) in enumerate(rows):
        both.append(Judgement(str(k), "a", "b", 0, 0, one, ""))
        both.append(Judgement(str(k), "b", "a", 0, 0, other, ""))
    itself = agreement(both)
    assert itself is not None
    assert itself.kappa == pytest.approx((0.75 - 0.5) / 0.5)


# --- VBench --------------------------------------------------------------------------------------

STAND_IN = """\
import json, os
class VBench:
    def __init__(self, device, info, out): self.out = out
    def evaluate(self, videos_path, name, prompt_list, dimension_list, local, mode):
        assert mode == "custom_input" and set(prompt_list) == set(
            n for n in os.listdir(videos_path) if n.endswith(".mp4"))
        rows = [{"video_path": n, "video_results": .5} for n in prompt_list]
        with open(os.path.join(self.out, name + "_eval_results.json"), "w") as file:
            json.dump({d: [0.5, rows] for d in dimension_list}, file)
"""


def test_vbench_reads_what_is_written_and_is_read(study: Study, tmp_path: Path) -> None:
    """A stand-in with the package's own interface, in a Python of its own."""
    there = tmp_path / "site"
    (there / "vbench").mkdir(parents=True)
    (there / "vbench" / "__init__.py").write_text(STAND_IN)
    (there / "torch.py").write_text(
        "class cuda:\n    is_available = staticmethod(lambda: False)\ndevice = str\n"
    )
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nPYTHONPATH={there} exec {sys.executable} "$@"\n')
    python.chmod(python.stat().st_mode | stat.S_IXUSR)
    found = vbench_scores(study, str(python), ("motion_smoothness", "imaging_quality"))
    assert found == {
        method: {"motion_smoothness": 0.5, "imaging_quality": 0.5} for method in ("good", "poor")
    }
    told = json.loads((study.folder / "vbench" / "good_input.json").read_text())
    assert told["prompts"]["clip_0.mp4"] == "The ball rolls. 0"
    assert os.path.isdir(told["videos"])


def test_without_vbench_one_sentence_says_so(study: Study) -> None:
    with pytest.raises(BackendMissing, match="VBench is not installed"):
        vbench_scores(study, sys.executable)


def test_other_files_and_dimensions_are_refused(study: Study, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="motion_smoothness"):
        write_input(study, "good", ("colour",))
    (tmp_path / "x.json").write_text("[1]")
    with pytest.raises(InputError, match="no results"):
        read_output(tmp_path / "x.json")
