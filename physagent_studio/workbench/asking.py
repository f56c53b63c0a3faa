"""What is asked of a person before a run goes on: masks more likely wrong than right."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from physagent_studio.records import Doubt, Image, Scene, doubts_of
from physagent_studio.session.arrays import png
from physagent_studio.workbench.desk import Desk

TILE_WIDTH = 416
"""Pixels of the width in which each candidate is shown."""
DIMMED = 0.35
"""How bright the picture stays outside a candidate."""


def asked_about(desk: Desk) -> tuple[Doubt, ...]:
    """The doubtful masks of what is on view; a doubted camera or word is said, not asked."""
    item = desk.round
    scene = desk.session.scene(item.scene) if item is not None and item.scene else None
    return tuple(doubt for doubt in doubts_of(scene) if doubt.kind == "mask")


def save_candidates(desk: Desk, name: str) -> Path:
    """Writes a picture of the masks on offer for a thing into the session's folder."""
    item = desk.round
    assert item is not None
    assert item.scene
    path = desk.session.folder / f"candidates_{name}.png"
    path.write_bytes(png(candidates_picture(desk.session.scene(item.scene), name)))
    return path


def candidates_picture(scene: Scene, name: str) -> Image:
    """(h, w, 3) uint8 RGB: the photo once for each mask on offer, two in a row, dimmed outside."""
    assert scene.photo is not None
    tiles = [
        _tile(scene.photo, offer.mask, str(number))
        for number, offer in enumerate(scene.candidates[name][:4], 1)
    ]
    if len(tiles) % 2:
        tiles.append(np.full_like(tiles[0], 255))
    rows = [np.hstack(tiles[k : k + 2]) for k in range(0, len(tiles), 2)]
    return np.vstack(rows).astype(np.uint8)


def _tile(photo: Image, mask: np.ndarray, label: str) -> Image:
    shown = np.where(mask[..., None], photo, photo * DIMMED).astype(np.uint8)
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    thick = max(1, round(photo.shape[1] / TILE_WIDTH * 1.5))
    cv2.drawContours(shown, found, -1, (255, 214, 10), thick, cv2.LINE_AA)
    height = round(TILE_WIDTH * photo.shape[0] / photo.shape[1])
    tile = cv2.resize(shown, (TILE_WIDTH, height), interpolation=cv2.INTER_AREA)
    for color, width in (((0, 0, 0), 4), ((255, 255, 255), 1)):
        cv2.putText(tile, label, (8, 26), cv2.FONT_HERSHEY_SIMPLEX, 0.8, color, width, cv2.LINE_AA)
    return tile.astype(np.uint8)
