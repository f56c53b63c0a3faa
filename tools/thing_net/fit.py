"""Fits the network of `reconstruction.masks.thing_map`; needs torch and onnx.

    python -m tools.thing_net.fit --pictures 20000:22000 FOLDER     fifty pictures to a file
    python -m tools.thing_net.fit --minutes 95 FOLDER               writes assets/networks
    python -m tools.thing_net.fit --minutes 70 --further FOLDER     from the weights that are there

Nothing but generated pictures is seen, of seeds that nothing is measured on. Pictures that are
added to the folder meanwhile are taken in. Where other work shares the cores, OMP_NUM_THREADS=1 and
OPENCV_FOR_THREADS_NUM=1 save nine tenths of the processor time: threads that wait would spin.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import math
import queue
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from physagent_studio.reconstruction.masks.thing_map import MAP
from tools.thing_net.pictures import FIRST_SEED, picture
from tools.thing_net.samples import Pictures, sample

WIDTHS = (24, 40, 64, 96, 128)
"""Channels at each halving of the canvas."""
BATCH, RATE, WARM = 16, 3e-3, 200
"""Samples a step, the highest rate of learning, and steps until it is reached."""
FURTHER = 0.1
"""Part of that rate with which weights that are there are fitted further."""
BETWEEN = 900.0
"""Seconds between two states of the network that are written beside the pictures."""
KEPT = 0.998
"""Share of the running mean of the weights that stays at a step; that mean is the result."""
SHARD, RESCAN = 50, 240.0
"""Pictures to a file, and seconds between two looks for new ones."""
OUT = Path(__file__).resolve().parents[2] / "assets" / "networks" / "thing_map.onnx"


def network() -> Any:
    """A U-Net of residual blocks with one logit for each pixel."""
    import torch
    from torch import nn
    from torch.nn.functional import interpolate, relu

    def joined(before: int, after: int, stride: int = 1) -> Any:
        conv = nn.Conv2d(before, after, 3, padding=1, stride=stride, bias=False)
        return nn.Sequential(conv, nn.BatchNorm2d(after), nn.ReLU(inplace=True))

    class Residual(nn.Module):
        def __init__(self, width: int) -> None:
            super().__init__()
            conv = nn.Conv2d(width, width, 3, padding=1, bias=False)
            self.first = joined(width, width)
            self.second = nn.Sequential(conv, nn.BatchNorm2d(width))

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            return relu(x + self.second(self.first(x)))

    class ThingMap(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            first, last = WIDTHS[0], WIDTHS[-1]
            pairs = list(itertools.pairwise(WIDTHS))
            stem = nn.Conv2d(MAP.canvas_layers, first, 4, 2, 1, bias=False)
            self.fine = joined(MAP.canvas_layers, 8)
            self.stem = nn.Sequential(stem, nn.BatchNorm2d(first), nn.ReLU(inplace=True))
            self.down = nn.ModuleList([Residual(first)])
            for level, (a, b) in enumerate(pairs):
                more = [Residual(b) for _ in range(2 if level else 1)]
                self.down.append(nn.Sequential(joined(a, b, 2), *more))
            self.all = nn.Conv2d(last, last, 1)
            self.narrow = nn.ModuleList(nn.Conv2d(b, a, 1) for a, b in pairs)
            self.up = nn.ModuleList(Residual(a) for a in WIDTHS[:-1])
            self.last = joined(first + 8, 16)
            self.out = nn.Conv2d(16, 1, 3, padding=1)

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            fine, y, kept = self.fine(x), self.stem(x), []
            for block in self.down:
                y = block(y)
                kept.append(y)
            # Spread out by hand: OpenCV would add a single pixel as if it were all of them.
            whole = self.all(y.mean((2, 3), keepdim=True))
            y = y + interpolate(whole, size=y.shape[2:], mode="nearest")
            for level in reversed(range(len(self.up))):
                wider = interpolate(self.narrow[level](y), scale_factor=2.0, mode="nearest")
                y = self.up[level](wider + kept[level])
            y = interpolate(y, scale_factor=2.0, mode="nearest")
            return self.out(self.last(torch.cat([y, fine], 1)))

    return ThingMap()


def written() -> Any:
    """The network with the weights of `OUT`, in which every norm is part of its convolution."""
    import onnx
    import torch
    from torch import nn

    net, order = network(), list[Any]()
    for block in [one for one in net.modules() if isinstance(one, nn.Sequential)]:
        for at, norm in enumerate(block):
            if isinstance(norm, nn.BatchNorm2d):
                block[at - 1].bias = nn.Parameter(torch.zeros(norm.num_features))
                block[at] = nn.Identity()
    convolutions = [one for one in net.modules() if isinstance(one, nn.Conv2d)]
    hooks = [one.register_forward_hook(lambda own, *_: order.append(own)) for one in convolutions]
    net.eval()(_nothing())
    for hook in hooks:
        hook.remove()
    model = onnx.load(str(OUT))
    held = {one.name: onnx.numpy_helper.to_array(one) for one in model.graph.initializer}
    done = [node.input[1:3] for node in model.graph.node if node.op_type == "Conv"]
    for own, (weight, bias) in zip(order, done, strict=True):
        own.weight.data = torch.from_numpy(held[weight].copy())
        own.bias.data = torch.from_numpy(held[bias].copy())
    return net


def write(net: Any, out: Path) -> None:
    """The network as OpenCV reads it."""
    import torch

    torch.onnx.export(net.eval(), (_nothing(),), str(out), opset_version=13, dynamo=False)


def _nothing() -> Any:
    import torch

    return torch.zeros(1, MAP.canvas_layers, MAP.canvas_px, MAP.canvas_px)


def fitted(folder: Path, minutes: float, further: bool = False) -> Any:
    """The running mean of the network's weights after so many minutes."""
    import torch

    torch.manual_seed(0)
    net = (written() if further else network()).to(memory_format=torch.channels_last).train()
    highest, mean = RATE * (FURTHER if further else 1.0), copy.deepcopy(net)
    steps = torch.optim.AdamW(net.parameters(), lr=highest, weight_decay=1e-4)
    batches = _batches(folder)
    start, number, saved = time.monotonic(), 0, 1
    while (share := (time.monotonic() - start) / (60 * minutes)) < 1:
        falling = 0.5 * (1 + math.cos(math.pi * share)) + 0.01
        for group in steps.param_groups:
            group["lr"] = highest * min(1.0, (number + 1) / WARM) * falling
        loss = _loss(net, *(torch.from_numpy(one) for one in batches.get()))
        steps.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 2.0)
        steps.step()
        number += 1
        _follow(mean, net, min(KEPT, (1 + number) / (10 + number)))
        if number % 100 == 0:
            print(number, f"{float(loss.detach()):.3f}", flush=True)
        if time.monotonic() - start > saved * BETWEEN:
            write(mean, folder / f"after_{round(saved * BETWEEN / 60)}.onnx")
            saved += 1
    return mean.eval()


def _batches(folder: Path) -> queue.Queue[tuple[np.ndarray, ...]]:
    """Batches of samples, made by a thread of their own."""
    made: queue.Queue[tuple[np.ndarray, ...]] = queue.Queue(6)
    pictures, rng = Pictures(folder), np.random.default_rng(0)

    def make() -> None:
        looked = time.monotonic()
        while True:
            batch = [sample(pictures, rng) for _ in range(BATCH)]
            made.put(tuple(np.stack([getattr(s, f) for s in batch]) for f in s_fields))
            if time.monotonic() - looked > RESCAN:
                looked = time.monotonic()
                pictures.scan()

    s_fields = ("seen", "truth", "inside")
    threading.Thread(target=make, daemon=True).start()
    return made


def _loss(net: Any, seen: Any, truth: Any, inside: Any) -> Any:
    """Cross-entropy of pixels, and one minus a soft IoU, so that small things count alike."""
    import torch
    from torch.nn.functional import binary_cross_entropy_with_logits as entropy

    with torch.autocast("cpu", dtype=torch.bfloat16):
        found = net(seen.contiguous(memory_format=torch.channels_last))
    logits = found.float()[:, 0]
    chance, area = torch.sigmoid(logits) * inside, inside.sum((1, 2))
    wrong = (entropy(logits, truth, reduction="none") * inside).sum((1, 2)) / area
    shared = (chance * truth).sum((1, 2))
    either = (chance + truth * inside - chance * truth).sum((1, 2))
    return (2 * wrong + 1 - (shared + 1) / (either + 1)).mean()


def _follow(mean: Any, net: Any, kept: float) -> None:
    import torch

    with torch.no_grad():
        for old, new in zip(mean.state_dict().values(), net.state_dict().values(), strict=True):
            if old.dtype.is_floating_point:
                old.mul_(kept).add_(new, alpha=1 - kept)
            else:
                old.copy_(new)


def main() -> None:
    """Makes pictures, or fits the network to those that were made."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("folder", type=Path)
    words.add_argument("--pictures", metavar="FIRST:LAST")
    words.add_argument("--minutes", type=float)
    words.add_argument("--further", action="store_true")
    words.add_argument("--out", type=Path, default=OUT)
    asked = words.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    if asked.pictures:
        first, last = map(int, asked.pictures.split(":"))
        if first < FIRST_SEED:
            raise SystemExit(f"seeds below {FIRST_SEED} are not for learning from")
        for start in range(first, last, SHARD):
            made = [picture(seed) for seed in range(start, min(start + SHARD, last))]
            held = {k: np.stack([getattr(p, k) for p in made]) for k in ("image", "thing", "part")}
            np.savez(asked.folder / str(start), **held, asked=np.array([p.asked for p in made]))
    if asked.minutes:
        write(fitted(asked.folder, asked.minutes, asked.further), asked.out)


if __name__ == "__main__":
    main()
