"""VBench through its own package: writes what it reads, reads what it writes.

Huang et al., "VBench: Comprehensive Benchmark Suite for Video Generative Models", CVPR 2024. The
package pins older versions of what we use ourselves, so it runs in the Python of an environment
of its own; on videos and sentences of one's own it knows the dimensions below.
"""

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from physagent_studio.benchmark.study.trials import Study
from physagent_studio.errors import BackendMissing, InputError, StudioError

DIMENSIONS = (
    "subject_consistency", "background_consistency", "motion_smoothness", "dynamic_degree",
    "aesthetic_quality", "imaging_quality",
)  # fmt: skip
VIDEOS = (".mp4", ".gif")
_THERE = "import importlib.util, sys; sys.exit(importlib.util.find_spec('vbench') is None)"
_RUN = """\
import json, os, sys
import torch, vbench
told = json.load(open(sys.argv[1], encoding="utf-8"))
info = os.path.join(os.path.dirname(vbench.__file__), "VBench_full_info.json")
device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
vbench.VBench(device, info, told["out"]).evaluate(
    videos_path=told["videos"], name=told["name"], prompt_list=told["prompts"],
    dimension_list=told["dimensions"], local=False, mode="custom_input",
)
"""
_RESULTS = TypeAdapter(dict[str, tuple[float, list[object]]])


def vbench_scores(
    study: Study, python: str, dimensions: Sequence[str] = DIMENSIONS
) -> dict[str, dict[str, float]]:
    """Scores of each method by dimension, from VBench in the environment of that `python`.

    Raises BackendMissing where VBench is not there, StudioError where it ends without results.
    """
    try:
        found = subprocess.run([python, "-c", _THERE], capture_output=True, check=False)
    except OSError as error:
        raise InputError(f"{python} cannot be started: {error.strerror}") from None
    if found.returncode:
        raise BackendMissing(
            f"VBench is not installed for {python}; make an environment for it (`pip install "
            "vbench`, it wants older versions than ours) and name its Python with --python"
        )
    scores = {}
    for method in sorted(study.files):
        told = write_input(study, method, dimensions)
        words = [python, "-c", _RUN, str(told)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["no word"])[-1]
            raise StudioError(f"VBench ended with exit code {done.returncode}: {last}")
        scores[method] = read_output(told.with_name(f"{method}_eval_results.json"))
    return scores


def write_input(study: Study, method: str, dimensions: Sequence[str]) -> Path:
    """Says in a file what VBench shall do with a method's clips."""
    clips = {p.name: clip for clip, p in study.files[method].items() if p.suffix.lower() in VIDEOS}
    if not clips or not set(dimensions) <= set(DIMENSIONS):
        raise InputError(
            f"VBench reads {' and '.join(VIDEOS)} in {study.folder / method}, and of clips of "
            f"one's own {', '.join(DIMENSIONS)}"
        )
    out = study.folder / "vbench"
    out.mkdir(exist_ok=True)
    data = {
        "videos": str((study.folder / method).resolve()),
        "name": method,
        "out": str(out.resolve()),
        "prompts": {name: study.sentences.get(clip, "") for name, clip in sorted(clips.items())},
        "dimensions": list(dimensions),
    }
    told = out / f"{method}_input.json"
    told.write_text(json.dumps(data, indent=1), encoding="utf-8")
    return told


def read_output(path: Path) -> dict[str, float]:
    """The score of each dimension in a file that VBench wrote; raises InputError for another."""
    try:
        found = _RESULTS.validate_json(path.read_bytes())
    except (OSError, ValidationError) as error:
        raise InputError(f"{path} holds no results of VBench: {error}") from None
    return {name: score for name, (score, _) in found.items()}
