"""What a finished loop amounts to, as plain data, and what is asked of a person before one goes on:
masks more likely wrong than right."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from physagent_studio.contract import Facts
from physagent_studio.contract.view import pacing_of
from physagent_studio.exchange.files import written
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.records import Check, Doubt, Image, LoopState, Round, Scene, doubts_of
from physagent_studio.rendering.sheets import outlined
from physagent_studio.session import Session
from physagent_studio.session.arrays import png
from physagent_studio.workbench.desk import Desk


def report_of(state: LoopState, session: Session, seconds: float) -> dict[str, Any]:
    """The JSON object of `run --json`."""
    best = state.best or state.current
    assessment = best.assessment if best else None
    checks = assessment.checks if assessment else ()
    return {
        "realised": state.outcome == "realised",
        "outcome": state.outcome,
        "rounds": len(state.path()),
        "session": session.id,
        "seconds": round(seconds, 3),
        "simulations": sum(item.simulations for item in state.path()),
        "contract": [
            _row(check, best) for check in checks if check.demanded and not check.always_on
        ],
        "physics": [
            {"statement": check.text, "ok": check.ok}
            for check in checks
            if check.always_on and check.kind != "view"
        ],
        "view": [_row(check, best) for check in checks if check.kind == "view"],
        "pacing": _pacing(best, session),
        "diagnosis": [item.text for item in assessment.diagnosis] if assessment else [],
        "doubts": [asdict(one) | {"text": one.text} for one in _doubts(best, session)],
        "untested": [item.text for item in best.program.contract.untested] if best else [],
        "not_understood": list(best.program.contract.not_understood) if best else [],
        "learned": [asdict(use) for use in session.scene(best.scene).learned]
        if best and best.scene
        else [],
        "program": best.program.hash if best else None,
    }


def _doubts(item: Round | None, session: Session) -> tuple[Doubt, ...]:
    """What is doubted of a round: its masks, its camera, words that nobody understood."""
    if item is None:
        return ()
    scene = session.scene(item.scene) if item.scene else None
    return doubts_of(scene, item.program.contract.not_understood)


def _row(check: Check, item: Round | None) -> dict[str, Any]:
    told = {"check": check.id, "statement": check.text, "clause": _clause(item, check.clause)}
    return told | figures_of(check)


def figures_of(check: Check) -> dict[str, Any]:
    """What was measured, against what, and how that came out."""
    names = ("measured", "threshold", "unit", "margin", "ok")
    return {name: getattr(check, name) for name in names}


def _pacing(item: Round | None, session: Session) -> dict[str, Any] | None:
    """When the clip shows a motion, how fast, and what leaves the picture; see `Pacing`."""
    if item is None or item.rollout is None:
        return None
    found = pacing_of(Facts.of(item.program, session.rollout(item.rollout)))
    return None if found is None else asdict(found) | {"crossings": dict(found.crossings)}


def _clause(item: Round | None, clause_id: str | None) -> str | None:
    if item is None or clause_id is None:
        return None
    clauses = {clause.id: clause.text for clause in item.program.contract.clauses}
    return clauses.get(clause_id)


TILE_WIDTH = 416
"""Pixels of the width in which each candidate is shown."""
SUPPORT_COLOUR = (90, 200, 255)
"""Of the outlines of what things stand on; those of things are yellow."""
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


def save_cut_out(desk: Desk, path: Path) -> bool:
    """Writes the photo with the outline and the name of each thing that was cut out, and those of
    what things stand on.

    False where nothing was. Raises InputError where it cannot be written.
    """
    item = desk.state.best or desk.round
    scene = desk.session.scene(item.scene) if item is not None and item.scene else None
    if scene is None or scene.photo is None or not scene.masks:
        return False
    with written(path) as partial:
        below = outlined(scene.photo, _supports_seen(scene), SUPPORT_COLOUR)
        partial.write_bytes(png(outlined(below, scene.masks)))
    return True


def _supports_seen(scene: Scene) -> dict[str, np.ndarray]:
    """(H, W) what each support covers that ends within the picture, by name."""
    camera = scene.state.camera
    ending = [
        s.name for s in scene.state.supports if s.shape is not None and s.shape.kind != "floor"
    ]
    if camera is None:
        return {}
    meshes = {name: scene.support_meshes[name] for name in ending if name in scene.support_meshes}
    return {name: silhouette(camera, mesh.vertices, mesh.faces) for name, mesh in meshes.items()}


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
