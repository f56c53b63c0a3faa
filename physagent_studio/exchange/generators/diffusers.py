"""Wan VACE in this process, through the library diffusers, on our frames and masks.

The control inputs are the prior's bundle `wan-vace`: where the mask is white the model paints,
where it is black the picture stays, and the first picture stays whole, which is how Wan VACE takes
a first frame. diffusers, torch and what they need are an extra and imported when a video is made.
"""

import importlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physagent_studio import errors
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange.generators.protocol import Cancelled, Progress
from physagent_studio.exchange.prior import Prior, write_bundles
from physagent_studio.exchange.video import write_video

PIPELINE = "WanVACEPipeline"
_NEEDED = ("torch", "transformers", "accelerate", "ftfy", "PIL.Image", "diffusers")


@dataclass(frozen=True, slots=True)
class Diffusers:
    """model: a folder with a Wan VACE pipeline as diffusers saves it, or a model's id.

    fetch: whether a model that is not on this machine may be fetched. steps: of denoising, 1 or
    more. guidance: how closely the prompt is kept to; up to 1 there is none, and a step takes half
    the time. seed: the same one gives the same video on one machine.
    """

    model: str
    fetch: bool = False
    steps: int = 30
    guidance: float = 5.0
    seed: int = 0
    name: str = "diffusers"

    def generate(
        self, prior: Prior, out: Path, *, cancelled: Cancelled = None, progress: Progress = None
    ) -> Path:
        """See `VideoGenerator`."""
        if self.steps < 1:
            raise InputError(f"{self.steps} steps of denoising are none; 1 or more are allowed")

        def tell(step: str, share: float) -> None:
            if cancelled is not None and cancelled():
                raise errors.Cancelled("generating the video was cancelled")
            if progress is not None:
                progress(step, share)

        torch = _library()
        tell("loading the model", 0.0)
        pipeline = self._loaded(torch)
        tell("preparing", 0.0)
        write_bundles(prior.folder, ["wan-vace"], cancelled=cancelled)
        said, inputs = _inputs(prior)

        def after_step(_: Any, number: int, time: Any, tensors: dict[str, Any]) -> dict[str, Any]:
            tell("denoising", (number + 1) / pipeline.num_timesteps)
            return tensors

        tell("denoising", 0.0)
        try:
            made = pipeline(
                **inputs,
                num_inference_steps=self.steps,
                guidance_scale=self.guidance,
                # Drawn on the processor: a seed is then the same noise whatever the device.
                generator=torch.Generator("cpu").manual_seed(self.seed),
                callback_on_step_end=after_step,
                output_type="pil",
            ).frames[0]
        except (ValueError, RuntimeError) as error:
            raise InputError(f"the pipeline of {self.model} failed: {_short(error)}") from error

        def pictures() -> Iterator[NDArray[np.uint8]]:
            for number, picture in enumerate(made):
                tell("writing", number / len(made))
                yield np.asarray(picture, np.uint8)

        write_video(out, pictures(), said["fps"], _timing(prior, len(made), said["fps"]))
        return out

    def _loaded(self, torch: Any) -> Any:
        """The pipeline on its device. Raises InputError where the model is bad or not here."""
        device, kind = ("cuda", "bfloat16") if torch.cuda.is_available() else ("cpu", "float32")
        # The decoder of pictures is small, and bfloat16 is seen in what it draws.
        kinds = {"default": getattr(torch, kind), "vae": torch.float32}
        where = {"local_files_only": not self.fetch}
        for library in ("diffusers", "transformers"):
            # Their bars would be drawn across ours.
            importlib.import_module(f"{library}.utils.logging").disable_progress_bar()
        broken = importlib.import_module("safetensors").SafetensorError
        told = (OSError, ValueError, TypeError, AttributeError, RuntimeError, ImportError, broken)
        found = None
        try:
            wanted = getattr(importlib.import_module("diffusers"), PIPELINE)
            found = wanted.load_config(self.model, **where).get("_class_name")
            if found != PIPELINE:
                raise InputError(f"{self.model} is a {found}, and a {PIPELINE} is needed")
            # Safetensors alone: other files of weights can carry code.
            pipeline = wanted.from_pretrained(
                self.model, dtype=kinds, use_safetensors=True, **where
            ).to(device)
        except told as error:
            why = _short(error)
            if found is None and not self.fetch and not Path(self.model).is_dir():
                why = "it is no folder, nor was it fetched before, and only --fetch fetches it"
            raise InputError(f"no {PIPELINE} can be loaded from '{self.model}': {why}") from error
        pipeline.set_progress_bar_config(disable=True)
        return pipeline


def _library() -> Any:
    """torch, where all that the pipeline needs is installed, else BackendMissing."""
    try:
        torch, *_ = (importlib.import_module(name) for name in _NEEDED)
    except ImportError as error:
        raise BackendMissing(
            f"Wan VACE needs diffusers and torch ({error}): "
            "pip install 'physagent-studio[generators]'"
        ) from error
    return torch


def _inputs(prior: Prior) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the bundle's manifest says, and the pipeline's arguments that come from the bundle."""
    image: Any = importlib.import_module("PIL.Image")
    folder = prior.folder / "wan-vace"
    said = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    width, height = said["size"]

    def read(part: str, mode: str) -> list[Any]:
        names = (name for name in said["files"] if name.startswith(f"{part}/"))
        return [image.open(folder / name).convert(mode) for name in names]

    video = read("video", "RGB")
    return said, {
        "prompt": prior.meta["prompt"],
        "video": video,
        "mask": read("mask", "L"),
        "width": width,
        "height": height,
        "num_frames": len(video),
    }


def _timing(prior: Prior, count: int, fps: float) -> dict[str, float]:
    """As `program.timing.timing_of`, of so many frames from the prior's first to its last."""
    simulated = float(prior.meta["simulated_seconds"])
    factor = round(simulated * fps / max(count - 1, 1), 6)
    return {"time_factor": factor, "simulated_seconds": simulated, "playback_fps": float(fps)}


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
