"""What published video generators read: frames, masks and noise in their sizes, counts and rates.

RealWonder and PhysAgent: `final_sim/`, 81 frames of 832×480, noise (81, 60, 104, 32) and masks
(21, 60, 104). Wan VACE (diffusers): 81 frames and masks, white where it paints, 16 a second.
Wan-Fun (ComfyUI): a control video and the first picture. Go-with-the-Flow: 49 frames of 720×480 and
noise (49, 60, 90, 16).
"""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from physagent_studio.exchange.prior.export import nearest_shown, nearness
from physagent_studio.exchange.prior.folder import Prior
from physagent_studio.exchange.prior.framing import Framing
from physagent_studio.exchange.prior.noise import warped
from physagent_studio.exchange.prior.stretches import Sink
from physagent_studio.exchange.video import write_video
from physagent_studio.rendering import Flow

WAN, GWTF = (832, 480), (720, 480)
"""Sizes of pictures, pixels."""
LATENT = 8
"""Pixels across a latent cell."""
LONG, SHORT = 81, 49
"""Frames of a clip for Wan and for CogVideoX."""
MOVED = 1e-3
"""Metres that a thing moves at least to count as moving."""
SPREAD = 9
"""Pixels around what moves that a generator may paint too: soft outlines and shadows."""
SDEDIT = {"denoising_step_list": [800, 600, 400, 200], "mask_dropin_step": -1}
"""As most of PhysAgent's published configurations have it: noise is added to our frames up to the
first step, so that from 1000 nothing of them would be left."""


def final_sim(prior: Prior, out: Path) -> str:
    """The folder `final_sim` as RealWonder's and PhysAgent's generators read it; what to know."""
    sink, clip = Sink(out), _Clip(prior, WAN, LONG)
    for number, picture in enumerate(clip.pictures()):
        if number == 0:
            sink.png("resized_input_image.png", picture)
        sink.png(f"frames/frame_{number:04d}.png", picture)
    write_video(out / "simulation.mp4", clip.pictures(), 10)
    noise = warped(clip.flows(), (WAN[0] // LATENT, WAN[1] // LATENT), 32)
    sink.npy("noises.npy", np.stack([one.astype(np.float16) for one in noise]))
    masks = clip.latent_masks()
    said = _masks(out, "points_masks_downsampled", masks)
    # Theirs of a robot's arm, which no scene of ours has; its generator skips what is empty.
    _masks(out, "mesh_masks_downsampled", np.zeros_like(masks))
    sink.text("prompt.txt", prior.meta["prompt"] + "\n")
    sink.text("config.yaml", yaml.safe_dump(SDEDIT | {"num_output_frames": 21}, sort_keys=False))
    return said


def wan_vace(prior: Prior, out: Path) -> str:
    """Frames and masks for diffusers' Wan VACE: white is painted, black is kept."""
    sink, clip = Sink(out), _Clip(prior, WAN, LONG)
    for number, (picture, mask) in enumerate(zip(clip.pictures(), clip.masks(), strict=True)):
        # The first picture is kept whole: it is the photo.
        painted = mask if number else np.zeros_like(mask)
        sink.png(f"video/frame_{number:04d}.png", picture)
        sink.png(f"mask/mask_{number:04d}.png", painted.astype(np.uint8) * 255)
    _manifest(sink, prior, {"fps": 16, "mask": "255 is painted, 0 is kept", "size": list(WAN)})
    return "frames and masks for Wan VACE, 81 of 832×480 at 16 a second; white is painted"


def wan_fun(prior: Prior, out: Path) -> str:
    """A control video of depth and the first picture for Wan-Fun in ComfyUI."""
    sink, clip = Sink(out), _Clip(prior, WAN, LONG)
    sink.png("start_image.png", next(clip.pictures()))
    write_video(out / "control_depth.mp4", clip.depths(), 16)
    _manifest(sink, prior, {"fps": 16, "length": LONG, "size": list(WAN), "control": "depth"})
    return "a depth control video and the first picture for Wan-Fun, 81 frames of 832×480"


def go_with_the_flow(prior: Prior, out: Path) -> str:
    """Warped noise, the clip and the first picture for Go-with-the-Flow on CogVideoX."""
    sink, clip = Sink(out), _Clip(prior, GWTF, SHORT)
    sink.png("first_frame.png", next(clip.pictures()))
    write_video(out / "input.mp4", clip.pictures(), 12)
    noise = warped(clip.flows(), (GWTF[0] // LATENT, GWTF[1] // LATENT), 16)
    sink.npy("noises.npy", np.stack([one.astype(np.float16) for one in noise]))
    _manifest(sink, prior, {"fps": 12, "size": list(GWTF), "noises": "float16 (49, 60, 90, 16)"})
    return "warped noise (49, 60, 90, 16) and the clip at 720×480 for Go-with-the-Flow"


class _Clip:
    """A prior in another size and with another number of frames, the nearest of its own."""

    def __init__(self, prior: Prior, size: tuple[int, int], count: int) -> None:
        self.prior, self.framing = prior, Framing.of(prior.size, size)
        self.numbers = np.linspace(0, prior.frames - 1, count).round().astype(int)
        rollout = prior.rollout()
        way = np.ptp(rollout.positions, axis=0).max(-1) > MOVED
        turn = np.ptp(rollout.rotations, axis=0).max(-1) > MOVED
        soft = {name for name, _ in rollout.vertices}
        self.moving = {
            name
            for name, moves in zip(rollout.objects, way | turn, strict=True)
            if moves or name in soft
        }

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """(H, W, 3) RGB each."""
        return (self.framing.picture(self.prior.picture(int(n))) for n in self.numbers)

    def masks(self, spread: int = SPREAD) -> Iterator[NDArray]:
        """(H, W) where what moves is, and close around it."""
        objects = self.prior.meta["objects"]
        wanted = [objects.index(name) for name in sorted(self.moving)]
        kernel = np.ones((2 * spread + 1, 2 * spread + 1), np.uint8)
        for number in self.numbers:
            own = np.isin(self.prior.ids(int(number)), wanted).astype(np.uint8)
            own = self.framing.labels(own)
            yield cv2.dilate(own, kernel) > 0 if spread else own > 0

    def latent_masks(self) -> NDArray[np.bool_]:
        """(21, h, w) of what moves, four frames each and the last: what fills half of a cell."""
        width, height = (side // LATENT for side in self.framing.after)
        cells = [mask.reshape(height, LATENT, width, LATENT).mean((1, 3)) for mask in self.masks(0)]
        groups = (np.mean(cells[at : at + 4], 0) for at in range(0, len(cells), 4))
        return np.stack([group > 0.5 for group in groups])

    def depths(self) -> Iterator[NDArray[np.uint8]]:
        """(H, W, 3) grey, near is white."""
        ground = np.load(self.prior.folder / "depth/background.npz")["depth"]
        nearest = nearest_shown(self.prior.depth(0), ground)
        for number in self.numbers:
            grey = nearness(nearest, np.minimum(self.prior.depth(int(number)), ground))
            yield self.framing.picture(np.repeat(grey[..., None], 3, axis=2))

    def flows(self) -> Iterator[tuple[Flow, Flow]]:
        """Forward and backward between the frames that are used, in pixels of the new size."""
        for one, other in zip(self.numbers, self.numbers[1:], strict=False):
            ahead = _chained([self.prior.flow(n) for n in range(one, other)], self.prior.size)
            back = [self.prior.backward(n) for n in range(other - 1, one - 1, -1)]
            yield self.framing.flow(ahead), self.framing.flow(_chained(back, self.prior.size))


def _chained(flows: list[Flow], size: tuple[int, int]) -> Flow:
    """One flow after the other; that of a still picture for none."""
    width, height = size
    if not flows:
        still = np.zeros((height, width, 2), np.float32)
        return Flow(still, np.ones((height, width), bool))
    vectors, visible = flows[0].vectors.copy(), flows[0].visible.copy()
    y, x = np.indices((height, width))
    for flow in flows[1:]:
        to_x = np.floor(x + 0.5 + vectors[..., 0]).astype(int)
        to_y = np.floor(y + 0.5 + vectors[..., 1]).astype(int)
        inside = (to_x >= 0) & (to_x < width) & (to_y >= 0) & (to_y < height)
        to_x, to_y = np.where(inside, to_x, 0), np.where(inside, to_y, 0)
        vectors += np.where(inside[..., None], flow.vectors[to_y, to_x], 0)
        visible &= inside & flow.visible[to_y, to_x]
    return Flow(vectors, visible)


def _masks(out: Path, name: str, masks: NDArray[np.bool_]) -> str:
    """Writes masks as torch reads them where it is there, else as npz; says which."""
    try:
        import torch  # pyright: ignore[reportMissingImports]
    except ImportError:
        Sink(out).npz(f"{name}.npz", masks=masks)
        return (
            "torch is not installed, so the masks are .npz; "
            f"`torch.save(torch.from_numpy(numpy.load('{name}.npz')['masks']), '{name}.pt')` "
            "makes each a .pt"
        )
    torch.save(torch.from_numpy(masks), out / f"{name}.pt")
    return "frames, warped noise and masks as RealWonder's and PhysAgent's generators read them"


def _manifest(sink: Sink, prior: Prior, said: dict[str, object]) -> None:
    sink.text("prompt.txt", prior.meta["prompt"] + "\n")
    sink.json("manifest.json", said | {"files": dict(sorted(sink.hashes.items()))})
