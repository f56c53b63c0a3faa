"""CSV files of Force Prompting and Goal Force: a picture, a point, a force, a caption in each row.

Their point (`coordx`, `coordy`) counts from the lower left corner of a picture of `width` by
`height`; an angle of 0 is to the right, 90 up. A force is the share of its largest; it moves a mark
on the picture by an eighth of its width (none) to a half (full) over the clip, which is what their
generators were taught, and so what a thing is given here as its first velocity.
"""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from physagent_studio.errors import InputError
from physagent_studio.exchange.case_reader import MAX_PROMPT, slug
from physagent_studio.exchange.files import text_of
from physagent_studio.exchange.peer_config import PeerObject, PeerSetup
from physagent_studio.exchange.peers.schedule import Motion, Push
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction import read_photo
from physagent_studio.records.case import Case

MAX_BYTES, MAX_ROWS = 1_000_000, 1000
LEAST, MOST = 1 / 8, 1 / 2
"""Share of the picture's width that a mark goes at no and at full force."""
FULL = {"projectile": 400.0}
"""The force that counts as full where it is none of 0 … 1: Goal Force's largest magnitude."""
_MARKS = ("", "obj1_", "obj2_", "obj3_", "obj4_")
_NONE = -1.0
"""What Goal Force writes where there is nothing."""

Row = Mapping[str, str]


def is_force_file(path: Path) -> bool:
    """Whether a file is a CSV whose first line names a picture and a caption."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with open(path, "rb") as file:
        head = file.readline(4000).decode("utf-8", "replace").strip().split(",")
    return "image" in head and "caption" in head


def load_forces(path: Path, names: Sequence[str] = (), event: str | None = None) -> PeerSetup:
    """One row of the file; event: `row_1`, `row_2`, …, None for the first.

    Raises:
        InputError: in one sentence with file and row: what is wrong and what is allowed.
    """
    rows = _rows(path)
    events = tuple((f"row_{n + 1}", _caption(row)) for n, row in enumerate(rows))
    chosen = event or "row_1"
    if chosen not in dict(events):
        raise InputError(f"{path} has no {chosen} (row_1 … row_{len(rows)})")
    row = rows[[name for name, _ in events].index(chosen)]
    where = f"{path}, {chosen}"
    pixels, image_hash = read_photo(_picture(path, row.get("image") or "", where))
    size = (pixels.shape[1], pixels.shape[0])
    marks = [mark for mark in _MARKS if f"{mark}coordx" in row]
    left_out: list[str] = []
    if marks:
        things = [(mark or "thing", _point(row, mark, size, where)) for mark in marks]
    else:
        things = [(n, _point(row, f"{n}_", size, where)) for n in ("projectile", "target")]
        left_out += _goal(row)
    found = [(slug(name.strip("_")) or "thing", at) for name, at in things if at is not None]
    if len({at for _, at in found}) < len(found):
        found = found[:1]
    if not found:
        raise InputError(f"{where}: no point of a thing (coordx and coordy)")
    called = [slug(name) for name in names] or [name for name, _ in found]
    if len(called) != len(found) or len(set(called)) != len(called) or "" in called:
        raise InputError(f"{where} has {len(found)} things, so as many names are needed")
    marks = marks or ["projectile_"]
    pushes = [
        _push(row, mark, called[n], size, where) for n, mark in enumerate(marks[: len(found)])
    ]
    case = Case(
        name=slug(path.stem) or "case",
        image=pixels,
        image_hash=image_hash,
        objects=tuple(
            (name, Grounding(points=(Click(x=at[0], y=at[1], label=1),)))
            for name, (_, at) in zip(called, found, strict=True)
        ),
        prompt=dict(events)[chosen],
        event=chosen,
        events=events,
    )
    return PeerSetup(
        case=case,
        objects=tuple(PeerObject(name) for name in called),
        left_out=tuple(left_out),
        motion=Motion(pushes=tuple(one for one in pushes if one is not None)),
    )


def _rows(path: Path) -> list[Row]:
    text = text_of(path, MAX_BYTES)
    try:
        rows: list[Row] = list(csv.DictReader(io.StringIO(text), strict=True))
    except csv.Error as error:
        raise InputError(f"{path} is no valid CSV ({error})") from error
    if not 0 < len(rows) <= MAX_ROWS:
        raise InputError(f"{path} has {len(rows)} rows (1 … {MAX_ROWS} are read)")
    return rows


def _caption(row: Row) -> str:
    return " ".join((row.get("caption") or "").split())[:MAX_PROMPT]


def _picture(path: Path, name: str, where: str) -> Path:
    """The picture of a row: beside the file, or in its folder `images`; nowhere else."""
    if not name or Path(name).name != name or name in (".", ".."):
        raise InputError(f"{where}: '{name[:80]}' is no file name of a picture beside it")
    for place in (path.parent / "images" / name, path.parent / name):
        if place.is_file():
            return place
    raise InputError(f"{where}: there is no picture {name} beside it or in its folder images")


def _number(row: Row, key: str, where: str) -> float | None:
    """None where the row has none."""
    said = (row.get(key) or "").strip()
    if not said:
        return None
    try:
        value = float(said)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {key} must be a number, not '{said[:40]}'")
    return value


def _point(row: Row, mark: str, size: tuple[int, int], where: str) -> tuple[float, float] | None:
    """Where a thing is on the photo, from its upper left corner; None where the row says none."""
    x, y = _number(row, f"{mark}coordx", where), _number(row, f"{mark}coordy", where)
    if x is None or y is None or (x, y) == (_NONE, _NONE):
        return None
    width = _number(row, "width", where) or size[0]
    height = _number(row, "height", where) or size[1]
    if not (0 <= x < width and 0 <= y < height):
        raise InputError(f"{where}: the point ({x:g}, {y:g}) is outside of {width:g}×{height:g}")
    return (x + 0.5) * size[0] / width, (height - 0.5 - y) * size[1] / height


def _push(row: Row, mark: str, name: str, size: tuple[int, int], where: str) -> Push | None:
    word = "projectile_force_" if mark == "projectile_" else mark
    angle = _number(row, f"{word}angle", where)
    key = f"{word}magnitude" if mark == "projectile_" else f"{mark}force"
    force = _number(row, key, where)
    if angle is None or force is None or force < 0:
        return None
    share = min(force / FULL.get(mark.strip("_"), 1.0), 1.0)
    far = size[0] * (LEAST + (MOST - LEAST) * share)
    turned = math.radians(angle)
    return Push(name, (far * math.cos(turned), -far * math.sin(turned)))


def _goal(row: Row) -> list[str]:
    """What Goal Force wants to come about, and masses without unit."""
    keys = ("target_indirect_force_angle", "target_indirect_force_magnitude")
    said = [
        f"{key} {row[key]}" for key in keys if (row.get(key) or "-1").strip() not in ("-1", "-1.0")
    ]
    masses = [key for key in row if key and key.endswith("_mass")]
    told = [key for key in masses if (row.get(key) or "-1").strip() not in ("-1", "-1.0", "")]
    goal = [f"the goal ({', '.join(said)}): say it in the prompt"] if said else []
    return goal + [f"{key}: it has no unit" for key in told]
