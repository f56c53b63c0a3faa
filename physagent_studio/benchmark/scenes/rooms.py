"""What is around things: the ground that they stand on and the wall or the greenery behind."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.benchmark.scenes.paints import drawn_colour
from physagent_studio.program.scene.camera import Camera

PLACES = {
    "toys": (("planks", "carpet", "check", "tiles"), ("plain", "paper", "shelves", "curtain")),
    "rings": (("tiles", "planks", "cloth", "grass"), ("plain", "tiles", "curtain", "foliage")),
    "kitchen": (("cloth", "planks", "check", "stone"), ("tiles", "plain", "shelves", "paper")),
    "room": (("planks", "carpet", "tiles", "check"), ("paper", "plain", "shelves", "curtain")),
    "meadow": (("grass", "sand", "grass"), ("foliage", "foliage", "bricks")),
    "street": (("asphalt", "stone", "tiles"), ("bricks", "windows", "foliage")),
    "stacks": (("planks", "cloth", "carpet", "stone"), ("plain", "shelves", "paper", "bricks")),
}
"""Which grounds and which walls are found where things of a group are."""
CELLS = 512
"""Side of the tile of noise in cells."""
SHARED, NEAR = 0.2, 14.0
"""Chance that a colour around is close to one of a thing's, and spread between them, levels."""


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """What a camera sees of an empty room, at every pixel.

    points, normals: (H, W, 3) in the world, metres. colour: (H, W, 3) 0 … 255 in even light.
    """

    points: FloatArray
    normals: FloatArray
    colour: FloatArray


def room(
    rng: np.random.Generator, camera: Camera, group: str, colours: Sequence[FloatArray]
) -> Room:
    """The ground at z = 0 up to a wall, both of the kind found around a group.

    colours: those of the things, some of which are found around them too.
    """
    wall_at = float(rng.uniform(4.6, 9.0))
    width, height = camera.size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = camera.rays(np.column_stack([x.ravel(), y.ravel()]).astype(np.float64)).reshape(
        height, width, 3
    )
    origin = np.asarray(camera.position)
    lean = float(rng.uniform(-0.3, 0.3))
    down = np.where(rays[..., 2] < -1e-6, -origin[2] / np.minimum(rays[..., 2], -1e-6), np.inf)
    across = rays[..., 1] + lean * rays[..., 0]
    ahead = wall_at / np.maximum(across, 1e-6)
    is_wall = ahead < down
    points = origin + rays * np.where(is_wall, ahead, down)[..., None]
    normal = np.array([-lean, -1.0, 0.0]) / np.hypot(lean, 1)
    normals = np.where(is_wall[..., None], normal, (0.0, 0.0, 1.0))
    grounds, walls = PLACES[group]
    coarse = np.where(is_wall, ahead, down) / camera.focal
    canvas = _Canvas(rng, coarse, colours)
    floor = canvas.ground(str(rng.choice(grounds)), points)
    back = canvas.wall(str(rng.choice(walls)), points)
    return Room(points, normals, np.where(is_wall[..., None], back, floor))


class _Canvas:
    """Draws patterns at places of a plane; what is finer than a pixel is left out.

    footprint: (H, W) metres across a pixel. colours: some that are there already.
    """

    def __init__(
        self, rng: np.random.Generator, footprint: FloatArray, colours: Sequence[FloatArray]
    ) -> None:
        self.rng = rng
        self.colours = colours
        self.footprint = footprint
        noise = rng.normal(0, 1, (CELLS, CELLS)).astype(np.float32)
        soft = cv2.GaussianBlur(noise, (0, 0), 1.2, borderType=cv2.BORDER_REFLECT)
        self.noise = soft / soft.std()

    def ground(self, kind: str, points: FloatArray) -> FloatArray:
        """(H, W, 3) a ground of a kind, and often a rug or sheets of paper on it."""
        turn = float(self.rng.uniform(-0.8, 0.8))
        cos, sin = np.cos(turn), np.sin(turn)
        x = points[..., 0] * cos - points[..., 1] * sin
        y = points[..., 0] * sin + points[..., 1] * cos
        out = self._ground(kind, x, y)
        for _ in range(int(self.rng.integers(0, 3)) if kind not in ("grass", "sand") else 0):
            middle = self.rng.uniform((-1.2, 1.8), (1.2, 4.5))
            half = self.rng.uniform(0.15, 1.0, 2)
            u = (points[..., 0] - middle[0]) * cos + (points[..., 1] - middle[1]) * sin
            v = (points[..., 1] - middle[1]) * cos - (points[..., 0] - middle[0]) * sin
            round_ = self.rng.random() < 0.3
            held = (u / half[0]) ** 2 + (v / half[1]) ** 2 < 1
            held = held if round_ else (abs(u) < half[0]) & (abs(v) < half[1])
            colour = self._striped(self._colour("any"), u, float(self.rng.uniform(0.05, 0.4)), 0.5)
            out[held] = (colour + self._grain(u, v, 60, 5.0))[held]
        return out

    def _ground(self, kind: str, x: FloatArray, y: FloatArray) -> FloatArray:
        if kind == "planks":
            return self._planks(x, y)
        if kind == "tiles":
            return self._tiles(x, y, float(self.rng.uniform(0.2, 0.5)), "pale")
        if kind in ("check", "cloth"):
            return self._cloth(x, y)
        role, fine, depth = {
            "grass": ("grass", 18.0, 17.0),
            "sand": ("wood", 25.0, 9.0),
            "carpet": ("any", 45.0, 10.0),
            "asphalt": ("metal", 40.0, 12.0),
            "stone": ("metal", 6.0, 13.0),
        }[kind]
        base = self._colour(role)
        broad = self._grain(x, y, 1.5, 9.0)
        fleck = self._grain(x, y, fine, depth) + self._grain(x, y, 2.3 * fine, 0.7 * depth)
        return base + (broad + fleck) * (0.8, 1.0, 0.7)

    def wall(self, kind: str, points: FloatArray) -> FloatArray:
        """(H, W, 3) a wall of a kind with what hangs or stands there."""
        x, z = points[..., 0], points[..., 2]
        out = self._wall(kind, x, z)
        if kind in ("plain", "paper", "bricks", "tiles"):
            for _ in range(int(self.rng.integers(0, 5))):
                middle, half = self.rng.uniform((-3, 0.3), (3, 2.5)), self.rng.uniform(0.1, 0.7, 2)
                u, v = abs(x - middle[0]) / half[0], abs(z - middle[1]) / half[1]
                out[(u < 1) & (v < 1)] = self._colour("any")
                inner = self._colour("any") + self._grain(x, z, 3.0, 18.0)
                held = (u < 0.85) & (v < 0.85)
                out[held] = inner[held]
        return out

    def _wall(self, kind: str, x: FloatArray, z: FloatArray) -> FloatArray:
        if kind == "foliage":
            leaves = self._colour("grass") + self._grain(x, z, 2.0, 22.0)
            leaves += self._grain(x, z, 8.0, 14.0)
            sky = self._colour("pale") * (0.9, 1.0, 1.08)
            line = 1.6 + 0.5 * self._grain(x, 0 * z, 0.6, 1.0)[..., 0]
            return np.where((z > line)[..., None], sky, leaves)
        if kind == "shelves":
            wide = float(self.rng.uniform(0.06, 0.2))
            tints = self.rng.uniform(40, 220, (97, 3))
            row, column = np.floor(z / 0.45).astype(int), np.floor(x / wide).astype(int)
            books = tints[(column * 31 + row * 17) % 97]
            top = 0.25 + 0.17 * ((column * 7 + row * 13) % 5) / 5
            gap = (z - row * 0.45 > top) | (x - column * wide < 0.12 * wide)
            return np.where(gap[..., None], self._colour("dark"), books)
        if kind == "bricks":
            return self._bricks(x, z)
        if kind == "windows":
            pane = (np.mod(x, 1.6) > 0.6) & (np.mod(z - 0.5, 1.5) > 0.5)
            front = self._colour("any") + self._grain(x, z, 12.0, 5.0)
            return np.where(pane[..., None], self._colour("glass"), front)
        if kind == "tiles":
            return self._tiles(x, z, float(self.rng.uniform(0.15, 0.4)), "pale")
        base = self._colour("pale" if self.rng.random() < 0.6 else "any")
        if kind == "paper":
            return self._striped(base, x, float(self.rng.uniform(0.1, 0.5)), 0.35)
        if kind == "curtain":
            return base + 22 * np.sin(x * self.rng.uniform(8, 22))[..., None]
        return base + self._grain(x, z, 1.0, 5.0)

    def _planks(self, x: FloatArray, y: FloatArray) -> FloatArray:
        wide = float(self.rng.uniform(0.1, 0.35))
        number = np.floor(x / wide).astype(int)
        shades = self.rng.normal(0, 11, 101)
        grain = self._grain(x, y * 0.06, 14.0, 11.0) + self._grain(x, y * 0.03, 40.0, 5.0)
        out = self._colour("wood") + shades[number % 101][..., None] + grain
        seam = x - number * wide < 0.006 + self.footprint * 0.5
        return np.where(seam[..., None], out * 0.6, out)

    def _tiles(self, x: FloatArray, y: FloatArray, wide: float, role: str) -> FloatArray:
        a, b = np.floor(x / wide).astype(int), np.floor(y / wide).astype(int)
        shades = self.rng.normal(0, 5, 101)
        out = self._colour(role) + shades[(a * 13 + b * 29) % 101][..., None]
        out = out + self._grain(x, y, 5.0, 4.0)
        if self.rng.random() < 0.4:
            out = np.where(((a + b) % 2 == 0)[..., None], out, self._colour("any"))
        joint = np.minimum(np.mod(x, wide), np.mod(y, wide)) < 0.012
        return np.where(joint[..., None], self._colour("metal"), out)

    def _cloth(self, x: FloatArray, y: FloatArray) -> FloatArray:
        base, wide = self._colour("pale"), float(self.rng.uniform(0.12, 0.5))
        other = self._colour("any")
        share = 0.5 * (np.mod(x, wide) < wide / 2) + 0.5 * (np.mod(y, wide) < wide / 2)
        share = share[..., None] * (self.rng.random() < 0.75)
        return base * (1 - share) + other * share + self._grain(x, y, 50.0, 4.0)

    def _bricks(self, x: FloatArray, z: FloatArray) -> FloatArray:
        row = np.floor(z / 0.16).astype(int)
        along = x + 0.2 * (row % 2)
        column = np.floor(along / 0.4).astype(int)
        shades = self.rng.normal(0, 12, 101)
        out = self._colour("warm") * 0.85 + shades[(row * 19 + column * 7) % 101][..., None]
        joint = (np.mod(z, 0.16) < 0.02) | (np.mod(along, 0.4) < 0.02)
        return np.where(joint[..., None], self._colour("metal"), out + self._grain(x, z, 20.0, 7.0))

    def _striped(self, base: FloatArray, x: FloatArray, wide: float, share: float) -> FloatArray:
        other = base * (1 - share) + self._colour("any") * share
        return np.where((np.mod(x, wide) < wide / 2)[..., None], base, other)

    def _colour(self, role: str) -> FloatArray:
        if self.rng.random() < SHARED:
            near = self.colours[int(self.rng.integers(len(self.colours)))]
            return np.clip(near + self.rng.normal(0, NEAR, 3), 15, 245)
        if role != "grass":
            return drawn_colour(self.rng, role)
        return np.array([1.0, 1.25, 0.55]) * self.rng.uniform(70, 140)

    def _grain(self, x: FloatArray, y: FloatArray, fineness: float, depth: float) -> FloatArray:
        """(H, W, 1) noise with so many bumps a metre, up to about `depth` levels."""
        shift = self.rng.uniform(0, CELLS, 2)
        u = np.mod(2 * x * fineness + shift[0], CELLS).astype(np.float32)
        v = np.mod(2 * y * fineness + shift[1], CELLS).astype(np.float32)
        found = cv2.remap(self.noise, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        seen = np.clip(1.2 - 1.5 * self.footprint * fineness, 0, 1)
        return np.asarray(found, np.float64)[..., None] * depth * seen[..., None]
