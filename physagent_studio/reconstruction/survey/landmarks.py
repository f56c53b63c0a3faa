"""Landmarks: places clicked, or shown by the picture, lifted into the world."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from physagent_studio.knowledge import colour_bounds, words_of
from physagent_studio.language import seen_by
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Landmark, Support
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright_through
from physagent_studio.reconstruction.photo.colours import pixels_like
from physagent_studio.reconstruction.photo.ellipses import Ellipse
from physagent_studio.reconstruction.survey.frames import Frame
from physagent_studio.reconstruction.survey.painted_lines import Stripe

Pixels = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class LandmarkSettings:
    """Which stripes and lanes of the ground are taken for a landmark."""

    min_strength: float = 0.12  # strength, 0.03..0.5: a fainter line is none
    # 0.3..0.95: of the best one's strength, from which another might be meant
    rival_share: float = 0.6
    # 0..0.2: over the picture's height: lines nearer to it are far-off edges
    below_horizon_ratio: float = 0.03
    max_lane_angle_deg: float = 8.0  # 2..20: between a lane's sides on the ground
    # 0.01..0.3: width over length: a narrower one is a stripe with two edges
    min_lane_ratio: float = 0.06
    max_lane_ratio: float = 2.0  # 0.5..5: width over length: wider ones are no lanes


LANDMARK = LandmarkSettings()

UNASKED = "by its words, nobody clicked it"


@dataclass(frozen=True, slots=True)
class Shown:
    """What the picture shows by itself: an upright frame, level circles, largest first, and

    painted lines, clearest first. tops: round ones, of tables in boxes.
    """

    frame: Frame | None = None
    circles: tuple[Ellipse, ...] = ()
    lines: tuple[Stripe, ...] = ()
    tops: tuple[Ellipse, ...] = ()


def resolve(
    landmarks: Sequence[Landmark], camera: Camera, supports: Sequence[Support], shown: Shown
) -> tuple[tuple[Landmark, ...], tuple[str, ...]]:
    """Landmarks with points where they were clicked or are seen, and words about open ones."""
    out: list[Landmark] = []
    flags: list[str] = []
    for landmark in landmarks:
        points = landmark.points
        if points is None and landmark.pixels:
            points = _lifted(landmark, camera, supports)
        elif points is None:
            height = top_of(landmark.on, supports)
            landmark, said = _proposed(landmark, camera, shown, height)
            points = landmark.points
            flags += said
        if points is None:
            flags.append(f"landmark '{landmark.name}' is open: click it in the photo")
        elif landmark.source == "estimated" and landmark.pixels and _names_line(landmark):
            x, y = _mean(landmark.pixels)
            flags.append(f"landmark '{landmark.name}' was found at ({x:.0f}, {y:.0f}) {UNASKED}")
        out.append(landmark.model_copy(update={"points": points}))
    return tuple(out), tuple(flags)


def _proposed(
    landmark: Landmark, camera: Camera, shown: Shown, height: float
) -> tuple[Landmark, list[str]]:
    """A landmark that nobody clicked, where its name and the picture agree, and what is said of it.

    height: of the level plane that it is on, m.
    """
    named = seen_by(landmark.name)
    frame = shown.frame if "frame" in named else None
    update: dict[str, object] = {}
    if frame is not None and landmark.kind == "opening":
        update = {"pixels": frame.corners, "points": _opening(np.array(frame.corners), camera)}
    elif frame is not None:
        feet = frame.corners[:2]
        places = on_plane(camera, feet, 0.0)
        if np.isfinite(places).all():
            points = _triples(places if landmark.kind != "point" else places.mean(0)[None])
            update = {"pixels": feet, "points": points}
    elif "circle" in named and shown.circles:
        update = _circle(landmark, camera, shown.circles[0])
    elif _names_line(landmark):
        places = _on_ground(landmark, camera, shown.lines, height)
        if len(places) != 1:
            return landmark, _places(landmark.name, places)
        pixels = places[0]
        update = {"pixels": pixels, "points": _triples(on_plane(camera, pixels, height))}
    if update.get("points") is None:
        return landmark, []
    return landmark.model_copy(update={**update, "source": "estimated"}), []


def _places(name: str, places: Sequence[Pixels]) -> list[str]:
    """What to say of a landmark that may be in several places."""
    if not places:
        return []
    middles = [np.mean(pixels, axis=0) for pixels in places[:3]]
    where = " or ".join(f"({x:.0f}, {y:.0f})" for x, y in middles)
    return [f"landmark '{name}' may be at {where} {UNASKED}"]


def _on_ground(
    landmark: Landmark, camera: Camera, lines: Sequence[Stripe], height: float
) -> list[Pixels]:
    """Pixels of a line, or of the corners of a lane, that rival one another; the best first."""
    named = words_of(landmark.name)
    least = camera.horizon + LANDMARK.below_horizon_ratio * camera.size[1]
    word = next((word for word in named if word in colour_bounds()), None)
    free = [
        stripe
        for stripe in lines
        if stripe.strength >= LANDMARK.min_strength
        and min(y for _, y in stripe.ends) > least
        and np.isfinite(on_plane(camera, stripe.ends, height)).all()
        and (word is None or _is_called(stripe, word))
    ]
    graded: list[tuple[float, Pixels]] = [(stripe.strength, stripe.ends) for stripe in free]
    is_lane = "band" in seen_by(landmark.name)
    if landmark.kind == "area" or (landmark.kind != "point" and is_lane):
        graded = _lanes(free, camera, height)
        if landmark.kind == "line":
            # The line in the middle of a lane's two sides.
            graded = [(g, (_mean((c[0], c[3])), _mean((c[1], c[2])))) for g, c in graded]
    graded.sort(key=lambda row: -row[0])
    rivals = [pixels for grade, pixels in graded if grade > LANDMARK.rival_share * graded[0][0]]
    return rivals if landmark.kind != "point" else [(_mean(pixels),) for pixels in rivals]


def _is_called(stripe: Stripe, word: str) -> bool:
    patch = np.array([[stripe.color]], np.uint8)
    return bool(pixels_like(patch, word).all())


def _names_line(landmark: Landmark) -> bool:
    return "line" in seen_by(landmark.name)


def _mean(pixels: Pixels) -> tuple[float, float]:
    x, y = np.mean(pixels, axis=0)
    return float(x), float(y)


def _lanes(lines: Sequence[Stripe], camera: Camera, height: float) -> list[tuple[float, Pixels]]:
    """Pairs of lines that run side by side on the ground, as four corners, with their strength."""
    out: list[tuple[float, Pixels]] = []
    for one, other in combinations(lines, 2):
        a, b = (on_plane(camera, stripe.ends, height)[:, :2] for stripe in (one, other))
        along, beside = a[1] - a[0], b[1] - b[0]
        length = float(np.hypot(*along))
        turned = float(along @ beside) < 0
        beside = -beside if turned else beside
        cross = along[0] * beside[1] - along[1] * beside[0]
        angle = np.degrees(np.arctan2(abs(cross), float(along @ beside)))
        normal = np.array([-along[1], along[0]]) / max(length, 1e-9)
        gap = float(np.abs((b.mean(0) - a.mean(0)) @ normal))
        if (
            angle > LANDMARK.max_lane_angle_deg
            or not LANDMARK.min_lane_ratio < gap / max(length, 1e-9) < LANDMARK.max_lane_ratio
        ):
            continue
        ends = other.ends[::-1] if turned else other.ends
        corners = (one.ends[0], one.ends[1], ends[1], ends[0])
        out.append((min(one.strength, other.strength), corners))
    return out


def _circle(landmark: Landmark, camera: Camera, seen: Ellipse) -> dict[str, object]:
    """The circle on the floor whose picture an ellipse is: its centre, or its outline."""
    turn = np.linspace(0, 2 * np.pi, 17)[:-1]
    rim = np.stack(
        [seen.x + seen.width / 2 * np.cos(turn), seen.y + seen.height / 2 * np.sin(turn)], 1
    )
    places = on_plane(camera, rim, 0.0)
    if not np.isfinite(places).all():
        return {}
    middle = np.append((places[:, :2].min(0) + places[:, :2].max(0)) / 2, 0.0)
    if landmark.kind in ("area", "opening"):
        pixels = tuple((float(x), float(y)) for x, y in rim)
        return {"pixels": pixels, "points": _triples(places)}
    pixel = camera.project(middle[None])[0][0]
    return {"pixels": ((float(pixel[0]), float(pixel[1])),), "points": _triples(middle[None])}


def _triples(places: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in places)


def _lifted(
    landmark: Landmark, camera: Camera, supports: Sequence[Support]
) -> tuple[tuple[float, float, float], ...] | None:
    pixels = np.array(landmark.pixels, float)
    if landmark.kind == "opening":
        return _opening(pixels, camera)
    places = on_plane(camera, pixels, top_of(landmark.on, supports))
    if not np.isfinite(places).all():
        return None
    return _triples(places)


def _opening(pixels: np.ndarray, camera: Camera) -> tuple[tuple[float, float, float], ...] | None:
    """An upright opening: its lowest two pixels are on the floor and fix its plane."""
    low = np.argsort(-pixels[:, 1], kind="stable")[:2]
    feet = on_plane(camera, pixels[low], 0.0)
    if not np.isfinite(feet).all():
        return None
    along = feet[1] - feet[0] if len(feet) > 1 else np.array([1.0, 0, 0])
    normal = np.cross(along, (0.0, 0.0, 1.0))
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    places = on_upright_through(camera, pixels, feet[0], normal)
    if not np.isfinite(places).all():
        return None
    return tuple((float(x), float(y), max(float(z), 0.0)) for x, y, z in places)


def top_of(name: str | None, supports: Sequence[Support]) -> float:
    """Height of a support's level top, m; the floor's for an unknown name."""
    for support in supports:
        if support.name == name and support.shape is not None:
            if support.shape.kind == "box":
                return support.shape.position[2] + support.shape.size[2] / 2
            if support.shape.kind == "floor":
                return support.shape.height
    return 0.0
