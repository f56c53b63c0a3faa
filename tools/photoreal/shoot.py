"""From a scene to its files: picture, numbers of what is seen where, truth and case."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import mitsuba as mi
import numpy as np

from photoreal.develop import develop
from photoreal.stage import Item, Lens, Room, identities, radiance
from photoreal.truth import planes, truth_of, write_case


@dataclass(frozen=True)
class Film:
    """How light becomes a picture. exposure: the brightness that the 60th percentile gets."""

    balance: tuple[float, float, float]
    exposure: float = 0.34
    quality: int = 93


def shoot(
    out: Path,
    items: Sequence[Item],
    lens: Lens,
    room: Room,
    film: Film,
    events: dict[str, str],
    *,
    wall: float,
    samples: int,
    seed: int,
) -> dict[str, Any]:
    """Writes input.jpg, ids.png, truth.json and case.yaml into `out`; returns the truth.

    wall: y of the wall behind, metres. samples: paths per pixel.
    """
    light = radiance(items, room, lens, samples=samples, seed=seed)
    exposure = film.exposure / float(np.percentile(light.mean(-1), 60))
    picture = develop(light, exposure=exposure, balance=film.balance, seed=seed)
    ids = identities(items, lens)
    truth = truth_of(items, lens, ids, planes(wall), seed=seed)
    out.mkdir(parents=True, exist_ok=True)
    quality = [cv2.IMWRITE_JPEG_QUALITY, film.quality]
    cv2.imwrite(str(out / "input.jpg"), picture[..., ::-1], quality)
    write_case(out, "input.jpg", truth, ids, events)
    return truth


def command(
    description: str,
    known: Iterable[str],
    out: Path,
    samples: int,
    write: Callable[[str, Path, int], None],
) -> None:
    """Reads the command line and writes the scenes that are asked for, all by default.

    write: called with a name, the folder and the paths per pixel.
    """
    known = list(known)
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("names", nargs="*", default=known, help=", ".join(known))
    parser.add_argument("--out", type=Path, default=out)
    parser.add_argument("--samples", type=int, default=samples, help="paths per pixel")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="or scalar_rgb, slower")
    args = parser.parse_args()
    mi.set_variant(args.variant)
    for name in args.names:
        start = time.monotonic()
        write(name, args.out, args.samples)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
