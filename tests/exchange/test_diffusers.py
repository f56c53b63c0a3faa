"""Wan VACE through diffusers: a tiny pipeline of random weights, made here, on the CPU."""

from __future__ import annotations

import importlib
import json
import shutil
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from physagent_studio.cli.app import app
from physagent_studio.errors import BackendMissing, Cancelled, InputError
from physagent_studio.exchange import Prior, export_motion_prior
from physagent_studio.exchange.generators import Diffusers, VideoGenerator
from physagent_studio.exchange.prior import generators as bundles
from tests.exchange.prior.conftest import Parts, parts

__all__ = ["parts"]

SIZE, COUNT = (64, 48), 5
"""Of the bundle in tests that do not need its own 81 frames of 832×480."""
NEEDED = ("torch", "transformers", "accelerate", "ftfy", "tokenizers", "diffusers")


@pytest.fixture
def prior(parts: Parts, tmp_path: Path) -> Prior:
    return Prior.open(export_motion_prior(tmp_path / "prior", *parts, 16))


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bundles, "WAN", SIZE)
    monkeypatch.setattr(bundles, "LONG", COUNT)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a whole Wan VACE pipeline: 8×8×4 pixels a cell of the latents, as its own."""
    for name in NEEDED:
        pytest.importorskip(name, reason=f"the package {name} of extra generators is not installed")
    torch, transformers, tokenizers, diffusers = (
        importlib.import_module(name)
        for name in ("torch", "transformers", "tokenizers", "diffusers")
    )
    torch.manual_seed(0)
    words = tokenizers.Tokenizer(
        tokenizers.models.WordLevel({"<pad>": 0, "</s>": 1, "<unk>": 2, "ball": 3}, "<unk>")
    )
    words.pre_tokenizer = tokenizers.pre_tokenizers.Whitespace()
    small = {"d_model": 16, "d_kv": 8, "d_ff": 16, "num_layers": 1, "num_heads": 2}
    pipeline = diffusers.WanVACEPipeline(
        tokenizer=transformers.PreTrainedTokenizerFast(
            tokenizer_object=words, pad_token="<pad>", eos_token="</s>", unk_token="<unk>"
        ),
        text_encoder=transformers.UMT5EncoderModel(transformers.UMT5Config(vocab_size=8, **small)),
        vae=diffusers.AutoencoderKLWan(base_dim=3, dim_mult=[1, 1, 1, 1], num_res_blocks=1),
        scheduler=diffusers.UniPCMultistepScheduler(
            prediction_type="flow_prediction", use_flow_sigmas=True, flow_shift=3.0
        ),
        transformer=diffusers.WanVACETransformer3DModel(
            num_attention_heads=1,
            attention_head_dim=12,
            text_dim=16,
            freq_dim=16,
            ffn_dim=16,
            num_layers=1,
            rope_max_seq_len=64,
            vace_layers=[0],
        ),
    )
    folder = tmp_path_factory.mktemp("wan")
    pipeline.save_pretrained(folder)
    return folder


class Stopped(Exception):
    """The call has been seen; at its own size the rest would take minutes."""


@pytest.fixture
def asked(model: Path, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What the real pipeline is called with; the call goes no further."""
    found: list[dict[str, Any]] = []

    def call(self: Any, **values: Any) -> Any:
        found.append(values)
        raise Stopped

    monkeypatch.setattr(importlib.import_module("diffusers").WanVACEPipeline, "__call__", call)
    return found


def decoded(path: Path) -> tuple[list[np.ndarray], float, dict[str, float]]:
    """Frames, rate and timing of a video."""
    with av.open(str(path)) as container:
        rate = container.streams.video[0].average_rate
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        assert rate is not None
        return frames, float(rate), json.loads(container.metadata["comment"])


@pytest.mark.generators
def test_the_whole_bundle_reaches_the_pipeline(
    prior: Prior, asked: list[dict[str, Any]], model: Path, tmp_path: Path
):
    with pytest.raises(Stopped):
        Diffusers(str(model), steps=2, guidance=3.0).generate(prior, tmp_path / "a.mp4")
    (values,) = asked
    assert values["prompt"] == prior.meta["prompt"]
    assert (values["num_inference_steps"], values["guidance_scale"]) == (2, 3.0)
    assert len(values["video"]) == len(values["mask"]) == values["num_frames"] == 81
    assert {one.size for one in values["video"] + values["mask"]} == {(832, 480)}
    assert (values["width"], values["height"]) == (832, 480)
    video, mask = (np.stack([np.asarray(one) for one in values[key]]) for key in ("video", "mask"))
    # In their order, and RGB: the first frame is the prior's first, the last its last.
    for number, frame in ((0, 0), (80, prior.frames - 1)):
        own = bundles.Framing.of(prior.size, (832, 480)).picture(prior.picture(frame))
        assert np.array_equal(video[number], own)
    # The first picture is kept; then white is where the ball has been drawn, the crate is kept.
    assert not mask[0].any()
    assert set(np.unique(mask)) == {0, 255}
    ids = bundles.Framing.of(prior.size, (832, 480)).labels(prior.ids(prior.frames - 1), -1)
    ball, crate = (prior.meta["objects"].index(name) for name in ("ball", "crate"))
    assert (mask[80][ids == ball] == 255).all()
    assert (mask[80][ids == crate] == 0).mean() > 0.5
    assert (mask[80] == 0).mean() > 0.5


@pytest.mark.generators
def test_a_video_is_made_and_its_seed_decides_it(
    small: None, prior: Prior, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    kind = importlib.import_module("diffusers").WanVACEPipeline
    real, seen = kind.prepare_video_latents, []

    def prepared(self: Any, video: Any, mask: Any, *others: Any) -> Any:
        seen.append((mask.numpy(), self))
        return real(self, video, mask, *others)

    monkeypatch.setattr(kind, "prepare_video_latents", prepared)
    told: list[tuple[str, float]] = []
    paths = [tmp_path / f"{name}.mp4" for name in "abc"]
    for path, seed in zip(paths, (7, 7, 8), strict=True):
        made: VideoGenerator = Diffusers(str(model), steps=2, seed=seed)
        assert made.generate(prior, path, progress=lambda *words: told.append(words)) == path
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert not np.array_equal(decoded(paths[0])[0], decoded(paths[2])[0])
    frames, rate, timing = decoded(paths[0])
    assert (len(frames), frames[0].shape, rate) == (COUNT, (SIZE[1], SIZE[0], 3), 16)
    seconds = prior.meta["simulated_seconds"]
    factor = pytest.approx(seconds / ((COUNT - 1) / 16), abs=1e-6)
    assert timing == {"time_factor": factor, "simulated_seconds": seconds, "playback_fps": 16}
    shares = [share for step, share in told if step == "denoising"]
    assert shares == [0, 0.5, 1] * 3
    # As the pipeline understands it: 1 is painted.
    mask, pipeline = seen[0]
    assert pipeline.transformer.dtype == pipeline.vae.dtype
    files = sorted((prior.folder / "wan-vace/mask").iterdir())
    white = (
        np.stack([np.asarray(cv2.imread(str(one), cv2.IMREAD_GRAYSCALE)) for one in files]) == 255
    )
    assert white[1:].any()
    assert np.array_equal(mask[0, 0], white)


@pytest.mark.generators
@pytest.mark.parametrize("before", [0, 3, 7])
def test_cancelling_leaves_nothing(
    small: None, prior: Prior, model: Path, tmp_path: Path, before: int
):
    told: list[str] = []
    out = tmp_path / "out" / "a.mp4"
    out.parent.mkdir()
    with pytest.raises(Cancelled):
        Diffusers(str(model), steps=2).generate(
            prior,
            out,
            cancelled=lambda: len(told) >= before,
            progress=lambda step, share: told.append(step),
        )
    # It ended where it was told to: no step more was done.
    steps = ["loading the model", "preparing", *["denoising"] * 3, *["writing"] * COUNT]
    assert told == steps[:before]
    assert list(out.parent.iterdir()) == []


@pytest.mark.generators
def test_a_model_that_is_none_is_refused(small: None, prior: Prior, model: Path, tmp_path: Path):
    def refused(name: str, told: str) -> None:
        with pytest.raises(InputError, match=told) as caught:
            Diffusers(name, steps=1).generate(prior, tmp_path / "a.mp4")
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) < 600
        assert not (tmp_path / "a.mp4").exists()

    refused(str(tmp_path / "nowhere"), "nowhere.*only --fetch")
    refused("nobody/no-such-model", "no-such-model.*only --fetch")
    (tmp_path / "empty").mkdir()
    refused(
        str(tmp_path / "empty"), "no WanVACEPipeline can be loaded from .*empty': .*model_index"
    )
    index = json.loads((model / "model_index.json").read_text())
    for number, (part, change) in enumerate(
        (
            ("model_index.json", json.dumps(index | {"_class_name": "WanPipeline"})),
            ("model_index.json", "{"),
            ("model_index.json", "[]"),
            ("vae/diffusion_pytorch_model.safetensors", "no weights"),
            ("text_encoder/model.safetensors", "no weights"),
            ("transformer/diffusion_pytorch_model.safetensors", None),
            ("transformer/config.json", None),
            ("text_encoder/model.safetensors", None),
            ("tokenizer/tokenizer.json", None),
            ("tokenizer/tokenizer.json", "{"),
        )
    ):
        folder = tmp_path / f"bad{number}"
        shutil.copytree(model, folder)
        if change is None:
            (folder / part).unlink()
        else:
            (folder / part).write_text(change)
        refused(str(folder), f"bad{number}")


@pytest.mark.generators
def test_what_the_pipeline_refuses_is_said(
    prior: Prior, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(bundles, "WAN", (100, 64))
    monkeypatch.setattr(bundles, "LONG", 5)
    with pytest.raises(InputError, match="divisible by 16"):
        Diffusers(str(model), steps=1).generate(prior, tmp_path / "a.mp4")
    assert not (tmp_path / "a.mp4").exists()


@pytest.mark.generators
def test_the_command_makes_a_video(small: None, prior: Prior, model: Path, tmp_path: Path):
    out = tmp_path / "a.mp4"
    words = ["generate", str(prior.folder), "--out", str(out), "--diffusers", str(model)]
    done = CliRunner().invoke(app, [*words, "--steps", "1", "--guidance", "1", "--seed", "3"])
    assert done.exit_code == 0, done.output
    own = Diffusers(str(model), steps=1, guidance=1, seed=3).generate(prior, tmp_path / "b.mp4")
    assert out.read_bytes() == own.read_bytes()


# --- Without the library -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["torch", "transformers", "ftfy", "diffusers"])
def test_without_the_library_there_is_one_sentence(
    prior: Prior, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
):
    monkeypatch.setitem(__import__("sys").modules, name, None)
    with pytest.raises(BackendMissing, match=r"physagent-studio\[generators\]"):
        Diffusers("a-model").generate(prior, tmp_path / "a.mp4")
    assert not (tmp_path / "a.mp4").exists()
    assert not (prior.folder / "wan-vace").exists()


def test_settings_that_cannot_be_are_refused(prior: Prior, tmp_path: Path):
    with pytest.raises(InputError, match="0 steps"):
        Diffusers("a-model", steps=0).generate(prior, tmp_path / "a.mp4")
    words = ["generate", str(prior.folder), "--out", str(tmp_path / "a.mp4")]
    both = ["--diffusers", "a-model", "--endpoint", "http://127.0.0.1:1"]
    done = CliRunner().invoke(app, [*words, *both])
    assert done.exit_code != 0
    assert "two generators" in done.output
