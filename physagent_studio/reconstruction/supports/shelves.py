"""Boards of one shelf: above one another at one depth, each as much higher as it is seen higher."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from physagent_studio.knowledge import Usual, is_board
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.supports.stances import Stance


def boards_of(state: SceneState, rows: int) -> dict[str, tuple[float, float]]:
    """Supports that are boards of one shelf, the lowest first, with the pixel that was clicked.

    rows: height of the picture. None of fewer than two, or where two are seen at one height.
    """
    found: dict[str, tuple[float, float]] = {}
    for item in state.supports:
        inside = [(c.x, c.y) for c in item.grounding.points if c.label]
        is_open = item.shape is None and not item.grounding.marks
        if is_open and inside and is_board(item.name):
            x, y = np.median(inside, axis=0)
            found[item.name] = (float(x), float(y))
    found = dict(sorted(found.items(), key=lambda pair: -pair[1][1]))
    heights = np.array([y for _, y in found.values()])
    min_rows_ratio = 0.02  # 0.005..0.1: over the picture's height: two boards so near are one
    apart = len(found) > 1 and float(np.diff(-heights).min()) > min_rows_ratio * rows
    return found if apart else {}


def on_boards(
    boards: Mapping[str, tuple[float, float]],
    state: SceneState,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
) -> dict[str, str]:
    """What each thing stands on: the board of the shelf, where its foot is seen at one."""
    out = dict(on)
    if not boards:
        return out
    rows = np.array([y for _, y in boards.values()])
    # 0.1..0.5: of the way to the next board: a foot so near stands on this one
    near_board_share = 0.35
    reach = near_board_share * float(np.abs(np.diff(rows)).min())
    for name, stance in stances.items():
        item = state.object(name)
        if on[name] not in (FLOOR, *boards) or (item is not None and item.support is not None):
            continue
        off = np.abs(rows - stance.foot[1])
        if off.min() < reach:
            out[name] = list(boards)[int(off.argmin())]
    return out


def shelf_rises(
    boards: Mapping[str, tuple[float, float]],
    camera: Camera,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    usual: Mapping[str, Usual],
) -> dict[str, float]:
    """Height of each board over the ground, as a share of the camera's height above it.

    What is known of things on the boards and on the ground tells how far the shelf is; where
    nothing does, the lowest board is as high as the boards are apart.
    """
    if not boards:
        return {}
    rays = camera.rays(np.array(list(boards.values())))
    # How far below the camera a board is for each metre that it is away.
    drops = -rays[:, 2] / rays[:, 1]
    far = _distance(camera, boards, stances, on, usual)
    if far is None or not 0 < far * float(drops[0]) < 0.98:
        far = 1 / max(float(2 * drops[0] - drops[1]), 1e-6)
    shares = 1 - far * drops
    if not (np.diff(shares) > 0).all() or shares[0] <= 0 or shares[-1] > 4:
        return {}
    return {name: float(share) for name, share in zip(boards, shares, strict=True)}


def _distance(
    camera: Camera,
    boards: Mapping[str, tuple[float, float]],
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    usual: Mapping[str, Usual],
) -> float | None:
    """How far the shelf is away in camera heights over the ground; None where sizes do not tell."""
    shelved = _metres([n for n in stances if on[n] in boards], camera, stances, usual)
    grounded = [n for n in stances if on[n] == FLOOR and stances[n].foot[1] > camera.horizon + 2]
    heights = []
    for name in grounded:
        ray = camera.rays(np.array([stances[name].foot]))[0]
        away = _metres([name], camera, stances, usual)
        if away is not None and ray[2] < 0:
            heights.append(math.log(away * -float(ray[2]) / float(ray[1])))
    if shelved is None or not heights:
        return None
    return shelved / math.exp(float(np.median(heights)))


def _metres(
    names: Sequence[str],
    camera: Camera,
    stances: Mapping[str, Stance],
    usual: Mapping[str, Usual],
) -> float | None:
    """How far things are away by their usual sizes, m: the geometric mean, the surer count more."""
    known = [name for name in names if usual[name].known]
    if not known:
        return None
    logs = [math.log(usual[n].metres * camera.focal / max(stances[n].extent, 1)) for n in known]
    return math.exp(float(np.average(logs, weights=[1 / usual[n].spread ** 2 for n in known])))
