"""Fits the network of `reconstruction.masks.thing_map`; needs torch and onnx.

    python tools/fit_thing_map.py --collect parts 0:210 SAMPLES     a file of samples per picture
    python tools/fit_thing_map.py --fit SAMPLES --minutes 60        writes assets/networks

Pictures whose seed ends in 7 are kept for measuring. Nothing but generated pictures is seen: things
of many parts (seeds 0 to 209), of one colour (0 to 29) and stacks (0 to 14) at first.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from fit_sureness import KINDS, pictured

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.box_drafts import box_drafts
from physagent_studio.reconstruction.masks.click_drafts import begun, click_drafts
from physagent_studio.reconstruction.masks.closeup import piece_around
from physagent_studio.reconstruction.masks.draft_score import Scorer
from physagent_studio.reconstruction.masks.ranking import ranked
from physagent_studio.reconstruction.masks.segmenter import SIDE, apart
from physagent_studio.reconstruction.masks.task import part_around, task_of, view_of
from physagent_studio.reconstruction.masks.thing_map import CANVAS, shown
from physagent_studio.records.case import Image

LAYERS = 10
VOTE = 3
"""The layer of the drafts' votes, which the network corrects."""
WIDTHS = (16, 16, 32, 48, 48)
"""Channels at each halving of the canvas."""
BATCH = 16
OUT = Path(__file__).resolve().parents[1] / "assets" / "networks" / "thing_map.onnx"


def samples(kind: str, seed: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """What the network is shown of each thing of a picture, and its mask; both as bytes."""
    image, things = pictured(kind, seed)
    for which in (2, 3):
        said = apart([(thing[0], thing[which]) for thing in things])
        for (name, own), (_, mask, *_) in zip(said, things, strict=True):
            for part in _parts(image, own):
                view = view_of(image, part, SIDE)
                task = task_of(name, own, view)
                scorer = Scorer(view.lab, task.inside)
                if task.box is not None:
                    drafts = box_drafts(view.small, view.lab, task, task.box, scorer)
                else:
                    with ThreadPoolExecutor(1) as pool:
                        whole = part == (0, 0, image.shape[1], image.shape[0])
                        cut = begun(pool, view.small, view.lab, task, filling=whole)
                        drafts = click_drafts(view.small, view.lab, task, scorer, cut)
                if drafts:
                    x0, y0, x1, y1 = part
                    seen = shown(view.lab, task, ranked(scorer, drafts, task))
                    truth = mask[y0:y1, x0:x1].astype(np.float32)
                    truth = cv2.resize(truth, seen.shape[:0:-1], interpolation=cv2.INTER_AREA)
                    yield _square(seen), _square(np.asarray(truth)[None])


def _parts(image: Image, own: Grounding) -> list[tuple[int, int, int, int]]:
    """What of the picture is looked at: all of it and a piece, or the box's surroundings."""
    if own.box is not None:
        return [part_around(own.box, image.shape)]
    piece = piece_around(own, image.shape)
    return [(0, 0, image.shape[1], image.shape[0]), *([piece] if piece else [])]


def _square(layers: np.ndarray) -> np.ndarray:
    out = np.zeros((len(layers), CANVAS, CANVAS), np.uint8)
    out[:, : layers.shape[1], : layers.shape[2]] = np.round(layers * 255)
    return out


def network() -> Any:
    """A U-Net whose output, a logit for each pixel, is added to what the drafts vote."""
    import torch
    from torch import nn
    from torch.nn.functional import interpolate, max_pool2d

    def block(before: int, after: int) -> nn.Module:
        first, second = (nn.Conv2d(n, after, 3, padding=1) for n in (before, after))
        return nn.Sequential(first, nn.ReLU(), second, nn.ReLU())

    class ThingMap(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            pairs = list(zip((LAYERS, *WIDTHS[:-1]), WIDTHS, strict=True))
            self.down = nn.ModuleList(block(before, after) for before, after in pairs)
            joined = itertools.pairwise(WIDTHS)
            self.up = nn.ModuleList(block(a + b, a) for a, b in joined)
            self.out = nn.Conv2d(WIDTHS[0], 1, 1)

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            vote, kept = x[:, VOTE : VOTE + 1], []
            for level, down in enumerate(self.down):
                x = down(max_pool2d(x, 2) if level else x)
                kept.append(x)
            for level in reversed(range(len(self.up))):
                x = torch.cat([interpolate(x, scale_factor=2.0, mode="nearest"), kept[level]], 1)
                x = self.up[level](x)
            return self.out(x) + 6 * (vote - 0.5)

    return ThingMap()


def augmented(x: Any, y: Any) -> tuple[Any, Any]:
    """Samples mirrored, turned, scaled and moved, in other colours, with whole layers left out.

    Colours are turned about the grey axis, so that none belongs to a kind of thing.
    """
    import torch
    from torch.nn.functional import affine_grid, grid_sample

    count = len(x)

    def drawn(low: float, high: float) -> Any:
        return torch.empty(count, 1, 1, 1).uniform_(low, high)

    zoom = torch.exp(drawn(-0.35, 0.3)).view(-1)
    mirror = torch.where(torch.rand(count) < 0.5, -1.0, 1.0)
    angle = torch.empty(count).normal_(0, 0.12)
    turn = torch.zeros(count, 2, 3)
    turn[:, 0, 0], turn[:, 0, 1] = zoom * mirror * torch.cos(angle), -zoom * torch.sin(angle)
    turn[:, 1, 0], turn[:, 1, 1] = zoom * mirror * torch.sin(angle), zoom * torch.cos(angle)
    turn[:, :, 2] = torch.empty(count, 2).uniform_(-0.15, 0.15)
    grid = affine_grid(turn, [count, 1, CANVAS, CANVAS], align_corners=False)
    both = torch.cat([x, y], 1)
    both = grid_sample(both, grid, padding_mode="border", align_corners=False)
    x, y = both[:, :LAYERS].clone(), both[:, LAYERS:]
    light = x[:, :1].clamp(1e-3, 1) ** torch.exp(torch.empty(count, 1, 1, 1).normal_(0, 0.25))
    shift = torch.empty(count, 1, 1, 1).normal_(0, 0.06)
    light = (light - 0.5) * drawn(0.7, 1.2) + 0.5 + shift
    hue, chroma = drawn(-np.pi, np.pi), drawn(0.3, 1.6)
    a, b = x[:, 1:2] - 0.5, x[:, 2:3] - 0.5
    turned = [a * torch.cos(hue) - b * torch.sin(hue), a * torch.sin(hue) + b * torch.cos(hue)]
    colours = torch.cat([light, *(chroma * one + 0.5 for one in turned)], 1)
    x[:, :3] = (colours + torch.randn_like(colours) * drawn(0, 0.03)).clamp(0, 1)
    x[:, VOTE : VOTE + 4] *= (torch.rand(count, 4, 1, 1) >= 0.12).float()
    return x, y


def fitted(folder: Path, minutes: float) -> Any:
    """The network after so many minutes on all samples but those that are kept for measuring."""
    import torch
    from torch.nn.functional import binary_cross_entropy_with_logits as entropy

    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    files = [f for f in sorted(folder.glob("*.npz")) if int(f.stem.split("-")[1]) % 10 != 7]
    loaded = [np.load(file) for file in files]
    seen, truth = (np.concatenate([one[key] for one in loaded]) for key in ("seen", "truth"))
    net = network().to(memory_format=torch.channels_last)
    steps = torch.optim.AdamW(net.parameters(), 3e-3, weight_decay=1e-3)
    start, number = time.monotonic(), 0
    while (share := (time.monotonic() - start) / (60 * minutes)) < 1:
        for group in steps.param_groups:
            group["lr"] = 1.5e-3 * (1 + np.cos(np.pi * share)) * min(1.0, number / 100 + 0.05)
        k = rng.choice(len(seen), BATCH, replace=False)
        x, y = augmented(torch.from_numpy(seen[k]) / 255, torch.from_numpy(truth[k]) / 255)
        found = net(x.contiguous(memory_format=torch.channels_last))
        chance = torch.sigmoid(found)
        shared = (chance * y).sum((1, 2, 3))
        missed = 1 - (shared + 1) / ((chance + y - chance * y).sum((1, 2, 3)) + 1)
        # Pixels of small things count for more, so that all things count alike.
        weight = 0.15 / (y.mean((1, 2, 3), keepdim=True) + 0.02)
        loss = (entropy(found, y, reduction="none") * weight).mean() + missed.mean()
        steps.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        steps.step()
        number += 1
    print(f"{number} steps of {BATCH} of {len(seen)} samples")
    return net.eval()


def main() -> None:
    """Collects samples, or fits the network to those that were collected."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("samples", type=Path)
    words.add_argument("--collect", nargs=2, metavar=("KIND", "FIRST:LAST"))
    words.add_argument("--fit", action="store_true")
    words.add_argument("--minutes", type=float, default=60.0)
    asked = words.parse_args()
    asked.samples.mkdir(parents=True, exist_ok=True)
    if asked.collect:
        kind, (first, last) = asked.collect[0], map(int, asked.collect[1].split(":"))
        if kind not in KINDS:
            raise SystemExit(f"pictures are of {', '.join(KINDS)}, not {kind}")
        for seed in range(first, last):
            made = list(samples(kind, seed))
            seen, truth = (np.stack([one[k] for one in made]) for k in (0, 1))
            np.savez_compressed(asked.samples / f"{kind}-{seed}.npz", seen=seen, truth=truth)
    if asked.fit:
        import torch

        net = fitted(asked.samples, asked.minutes)
        blank = torch.zeros(1, LAYERS, CANVAS, CANVAS)
        OUT.parent.mkdir(exist_ok=True)
        torch.onnx.export(net, (blank,), str(OUT), opset_version=13, dynamo=False)


if __name__ == "__main__":
    main()
