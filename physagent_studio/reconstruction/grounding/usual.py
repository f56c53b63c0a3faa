"""What a name says: the usual size of a thing, and which shapes it may have.

Sizes are those of everyday things, in metres, of the *longer visible side* (height of a
bottle, length of a car, diameter of a ball). `spread` is one standard deviation of the natural
logarithm: 0.05 for a thing that rules fix, 0.6 for one that comes in all sizes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

ROUND = ("sphere", "ellipsoid")
TURNED = ("revolved", "cylinder", "frustum")
BOXES = ("box",)
FREE = ("inflated",)


@dataclass(frozen=True, slots=True)
class Usual:
    """metres: longer visible side. spread: of its logarithm. shapes: likely ones, best first.

    depth: usual extent away from the viewer as a share of the width; None for round things.
    aspect: usual height over width as it stands, and the spread of its logarithm. lies: of what
    lies rather than stands, its thickness over its length; 1 for what is as thick as it is wide.
    """

    metres: float
    spread: float
    shapes: tuple[str, ...] = ()
    known: bool = True
    depth: float | None = None
    aspect: tuple[float, float] | None = None
    lies: float | None = None


UNKNOWN = Usual(0.3, 1.0, (), False)
"""Nothing known: an object is taken to be 0.3 m."""

_TABLE: dict[str, Usual] = {}


def _add(metres: float, spread: float, shapes: tuple[str, ...], *names: str) -> None:
    for name in names:
        _TABLE[name] = Usual(metres, spread, shapes)


_add(0.22, 0.04, ("sphere",), "soccer ball", "football", "soccerball")
_add(0.24, 0.04, ("sphere",), "basketball")
_add(0.21, 0.04, ("sphere",), "volleyball", "handball")
_add(0.217, 0.04, ("sphere",), "bowling ball")
_add(0.067, 0.04, ("sphere",), "tennis ball", "baseball", "cricket ball")
_add(0.043, 0.04, ("sphere",), "golf ball", "ping pong ball", "table tennis ball", "squash ball")
_add(0.057, 0.04, ("sphere",), "billiard ball", "pool ball", "cue ball", "snooker ball")
_add(0.016, 0.2, ("sphere",), "marble")
_add(0.35, 0.3, ("sphere",), "beach ball", "balloon", "exercise ball")
_add(0.15, 0.6, ("sphere",), "ball", "sphere", "globe")
_add(0.38, 0.04, TURNED, "bowling pin", "pin", "skittle")
_add(0.29, 0.06, TURNED, "curling stone")
_add(0.25, 0.35, (*TURNED, "ellipsoid"), "stone", "rock", "boulder", "pebble")
_add(0.076, 0.05, ("cylinder",), "puck", "hockey puck")
_add(0.10, 0.4, FREE, "toy car", "model car", "toy truck", "toy train", "toy bus", "toy")
_add(4.3, 0.1, FREE, "car", "taxi", "van", "vehicle")
_add(8.0, 0.4, FREE, "truck", "bus", "train", "tram", "boat", "airplane")
_add(1.75, 0.1, FREE, "bicycle", "bike", "motorcycle", "motorbike")
_add(1.0, 0.12, FREE, "scooter", "kick scooter")
_add(0.8, 0.1, FREE, "skateboard", "snowboard", "sled", "sledge")
_add(0.06, 0.5, BOXES, "cube", "toy cube", "wooden cube")
_add(0.016, 0.2, BOXES, "dice", "die")
_add(0.10, 0.6, BOXES, "block", "brick toy", "toy block")
_add(0.15, 0.5, BOXES, "foam block", "foam")
_add(0.075, 0.2, BOXES, "jenga block", "domino", "matchbox", "eraser", "lego", "lego brick")
_add(0.215, 0.1, BOXES, "brick")
_add(0.24, 0.2, BOXES, "book", "notebook", "dictionary", "textbook")
_add(0.35, 0.5, BOXES, "box", "package", "parcel", "carton", "cardboard box", "gift", "present")
_add(0.5, 0.3, BOXES, "crate", "chest", "suitcase", "luggage", "drawer", "cooler")
_add(0.33, 0.15, BOXES, "laptop", "tablet", "tray", "briefcase")
_add(0.15, 0.15, BOXES, "phone", "smartphone", "remote", "soap", "wallet", "card")
_add(0.88, 0.15, TURNED, "barrel", "drum", "keg")
_add(0.30, 0.2, ("frustum", "cylinder"), "bucket", "pail", "flowerpot", "plant pot")
_add(0.75, 0.25, TURNED, "trash can", "bin", "garbage can", "dustbin", "waste bin", "wastebasket")
_add(0.7, 0.2, ("frustum", "revolved"), "traffic cone", "cone")
_add(0.30, 0.3, ("revolved", "ellipsoid"), "pumpkin", "watermelon")
_add(0.20, 0.25, ("ellipsoid", "sphere"), "melon", "cabbage", "coconut", "pineapple")
_add(0.08, 0.12, ("sphere", "ellipsoid", "revolved"), "apple", "orange", "peach", "mandarin")
_add(0.08, 0.12, ("ellipsoid", "revolved"), "persimmon", "tomato", "onion", "lemon", "lime")
_add(0.10, 0.2, ("ellipsoid", "revolved"), "pear", "potato", "mango", "avocado", "kiwi")
_add(0.06, 0.1, ("ellipsoid",), "egg", "plum", "apricot", "fig", "walnut")
_add(0.03, 0.3, ("ellipsoid",), "strawberry", "cherry", "grape", "nut", "olive")
_add(0.024, 0.15, ("cylinder",), "coin", "button", "token", "medal", "poker chip", "bottle cap")
_add(0.19, 0.15, FREE, "banana", "carrot", "cucumber", "corn")
_add(1.2, 0.3, FREE, "table", "desk", "coffee table", "dining table", "workbench")
_add(0.6, 0.3, FREE, "nightstand", "side table", "bedside table", "cart", "trolley", "stroller")
_add(0.42, 0.3, FREE, "stool", "footstool", "step stool")
_add(0.9, 0.15, FREE, "chair", "armchair", "highchair")
_add(0.12, 0.15, ("revolved", "cylinder"), "can", "soda can", "tin", "jar")
_add(0.12, 0.15, TURNED, "mug", "cup", "teacup")
_add(0.15, 0.2, TURNED, "glass", "tumbler", "wine glass", "goblet", "candle", "lantern")
_add(0.25, 0.15, TURNED, "bottle", "vase", "jug", "pitcher", "thermos", "flask")
_add(0.17, 0.25, ("revolved", "frustum"), "bowl", "basket", "teapot", "kettle", "pot")
_add(0.26, 0.15, ("cylinder", "revolved"), "plate", "dish", "pan", "frisbee", "disc")
_add(0.15, 0.12, ("cylinder", "revolved"), "saucer", "coaster", "lid", "pizza", "pancake")
_add(0.62, 0.15, ("torus", "cylinder"), "tyre", "tire", "wheel", "lifebuoy", "life buoy")
_add(0.09, 0.2, ("torus",), "doughnut", "donut", "bagel", "bracelet", "bangle", "sprinkled donut")
_add(0.2, 0.6, ("torus",), "ring", "quoit", "washer", "hoop")
_add(0.9, 0.2, ("torus",), "hula hoop", "inner tube", "swim ring", "inflatable ring", "rubber ring")
_add(0.4, 0.3, ("torus",), "wreath", "steering wheel")
_add(0.16, 0.2, ("cylinder", "capsule"), "pen", "pencil", "marker", "crayon", "screwdriver")
_add(0.05, 0.2, ("cylinder", "capsule"), "battery", "cork", "lipstick", "cigarette", "thimble")
_add(0.4, 0.4, ("cylinder", "capsule"), "log", "tube", "pipe", "rolling pin", "rod")
_add(0.18, 0.25, ("capsule", "cylinder"), "sausage", "hot dog", "baguette", "roller")
_add(0.18, 0.2, FREE, "spoon", "fork", "knife", "key", "scissors", "comb", "toothbrush", "wrench")
_add(0.2, 0.4, FREE, "leaf", "feather", "glove", "fish", "snake")
_add(0.9, 0.3, FREE, "umbrella", "broom", "ladder", "lamp", "guitar", "sign")
_add(0.8, 0.3, FREE, "suit", "dress", "coat", "jacket", "shirt", "clothes", "costume", "towel")
_add(0.5, 0.5, FREE, "flag", "cloth", "curtain", "blanket", "kite", "pillow", "bag", "backpack")
_add(0.28, 0.15, FREE, "shoe", "boot", "sneaker", "hat", "helmet")
_add(0.35, 0.4, FREE, "teddy", "teddy bear", "doll", "figurine", "robot", "statue", "bust")
_add(0.09, 0.3, FREE, "rubber duck", "duck", "toy soldier", "chess piece", "snail", "mouse")
_add(8.0, 0.5, FREE, "tree", "palm", "oak")
_add(0.4, 0.5, FREE, "plant", "flower", "bouquet", "bonsai", "cactus", "bush")
_add(7.0, 0.4, (*BOXES, *FREE), "house", "building", "cabin", "tower")
_add(0.3, 0.4, FREE, "sand house", "sand castle", "sandcastle", "toy house", "dollhouse")
_add(0.3, 0.4, FREE, "gingerbread house", "card house", "block tower", "cake")
_add(1.5, 0.3, ("revolved", "inflated"), "snowman")
_add(1.7, 0.1, FREE, "person", "man", "woman", "dancer", "player", "mannequin")
_add(1.1, 0.2, FREE, "child", "boy", "girl", "kid")
_add(0.7, 0.3, FREE, "dog", "sheep", "goat", "cat", "bird", "chicken")
_add(2.2, 0.3, FREE, "horse", "cow", "elephant", "bear", "bull")

_DEPTH = {"car": 0.42, "truck": 0.35, "bus": 0.25, "train": 0.2, "stool": 0.65, "chair": 0.9}
_DEPTH |= {"table": 0.6, "desk": 0.5, "workbench": 0.5, "nightstand": 0.8, "cart": 0.6}
_DEPTH |= {"house": 0.8, "castle": 0.8, "tower": 1.0, "building": 0.8, "cabin": 0.9, "sofa": 0.5}
_DEPTH |= {"suit": 0.25, "dress": 0.25, "coat": 0.25, "jacket": 0.25, "shirt": 0.2, "towel": 0.08}
_DEPTH |= {"scooter": 0.1, "bicycle": 0.12, "bike": 0.12, "motorcycle": 0.25, "motorbike": 0.25}
_DEPTH |= {"laptop": 0.7, "shoe": 0.4, "boot": 0.4, "bench": 0.4, "bag": 0.4, "backpack": 0.5}

_ASPECT = {"pin": (3.1, 0.1), "skittle": (3.1, 0.2), "bottle": (3.2, 0.25), "cube": (1.05, 0.15)}
_ASPECT |= {"can": (1.7, 0.25), "cup": (1.1, 0.2), "mug": (1.1, 0.2), "glass": (1.7, 0.3)}
_ASPECT |= {"pumpkin": (0.9, 0.2), "persimmon": (0.8, 0.2), "orange": (1.0, 0.08)}
_ASPECT |= {"apple": (1.0, 0.1), "egg": (1.1, 0.25), "cone": (1.4, 0.3), "barrel": (1.4, 0.2)}
_ASPECT |= {"bin": (1.5, 0.3), "bucket": (1.0, 0.2), "person": (2.8, 0.3), "snowman": (1.7, 0.3)}
_ASPECT |= {"stool": (0.9, 0.35), "chair": (1.6, 0.3), "vase": (1.8, 0.4), "tree": (1.1, 0.4)}
_ASPECT |= {"scooter": (0.95, 0.25), "car": (0.55, 0.3), "suit": (1.4, 0.4), "house": (1.0, 0.3)}

_LIES = {"spoon": 0.04, "fork": 0.04, "knife": 0.04, "key": 0.04, "scissors": 0.04, "comb": 0.03}
_LIES |= {"toothbrush": 0.06, "wrench": 0.04, "leaf": 0.03, "feather": 0.04, "glove": 0.15}
_LIES |= dict.fromkeys(("pipe", "rod", "sausage", "hot dog", "baguette"), 1.0)
_LIES |= dict.fromkeys(("pen", "pencil", "marker", "crayon", "screwdriver", "log"), 1.0)
_LIES |= {"banana": 1.0, "carrot": 1.0, "cucumber": 1.0, "corn": 1.0, "snake": 1.0, "fish": 0.3}

_TIMES = {"toy": 0.35, "tiny": 0.5, "mini": 0.5, "miniature": 0.35, "small": 0.75, "little": 0.75}
_TIMES |= {"big": 1.3, "large": 1.4, "huge": 1.8, "giant": 2.5, "sand": 0.3, "paper": 0.6}

HEIGHTS: dict[str, float] = {
    "table": 0.75,
    "tabletop": 0.75,
    "desk": 0.74,
    "workbench": 0.85,
    "counter": 0.9,
    "countertop": 0.9,
    "worktop": 0.9,
    "sideboard": 0.8,
    "nightstand": 0.55,
    "bench": 0.45,
    "stool": 0.45,
    "chair": 0.45,
    "bed": 0.5,
    "shelf": 1.0,
    "ledge": 0.9,
    "windowsill": 0.9,
    "conveyor": 0.6,
    "belt": 0.6,
    "platform": 0.4,
    "stage": 0.6,
    "pedestal": 0.9,
    "podium": 0.9,
    "stand": 0.6,
    "box": 0.35,
    "crate": 0.4,
    "step": 0.17,
    "stair": 0.17,
    "block": 0.1,
    "plank": 0.1,
    "board": 0.05,
    "tray": 0.03,
    "mat": 0.01,
    "rail": 0.1,
    "railway": 0.15,
    "railroad": 0.15,
}
"""Usual height of a support's top above the floor, m."""

GROUND = frozenset(
    [
        "floor",
        "ground",
        "grass",
        "lawn",
        "field",
        "pitch",
        "road",
        "street",
        "pavement",
        "ice",
        "rink",
        "lane",
        "track",
        "sand",
        "beach",
        "snow",
        "carpet",
        "court",
        "asphalt",
    ]
)
RAMPS = frozenset(["ramp", "slope", "incline", "chute", "slide", "wedge", "hill"])
STAIRS = frozenset(["stairs", "steps", "staircase", "stairway", "stairwell", "stoop", "bleachers"])
RAILS = frozenset(["rails", "tracks", "railway", "railroad", "railtrack", "traintrack"])
RISER = 0.17
"""Usual height of a step, m."""
_NUMBERS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
_WOODY = ("tree", "palm", "oak", "pine", "sapling", "bush")
GROWS = frozenset([*_WOODY, "plant", "flower", "stalk", "grass", "bamboo", "reed", "cactus"])
WALLS = frozenset(["wall", "backdrop", "fence"])


def words_of(name: str) -> tuple[str, ...]:
    """Lower-case words of a name such as `left_pin2`, numbers dropped, plurals made singular."""
    return tuple(_singular(word) for word in re.findall(r"[a-z]+", name.lower()))


def _singular(word: str) -> str:
    if word in _TABLE or len(word) < 4 or not word.endswith("s") or word.endswith("ss"):
        return word
    for stem in (word[:-1], word[:-2], word[:-3] + "y"):
        if stem in _TABLE or stem in HEIGHTS:
            return stem
    return word


def is_listed(name: str) -> bool:
    """Whether exactly these words are a known kind of thing, as "bowling pin" is."""
    return " ".join(words_of(name)) in _TABLE


def usual_size(name: str, context: str = "") -> Usual:
    """What is usual for a thing of that name; `context` (a prompt) may make it more special.

    "stone" alone is any stone, but "yellow_stone" in a sentence about "curling stones" is one
    of those: a longer table entry counts if the sentence has it and it ends with the name's noun.
    """
    words = words_of(name)
    for size in (3, 2, 1):
        for start in range(len(words) - size, -1, -1):
            entry = _TABLE.get(" ".join(words[start : start + size]))
            if entry is not None:
                found = _special(words[start + size - 1], context) or entry if size == 1 else entry
                before = words[:start] + words[start + size :]
                depth = next((_DEPTH[w] for w in reversed(words) if w in _DEPTH), None)
                aspect = next((_ASPECT[w] for w in reversed(words) if w in _ASPECT), None)
                if aspect is None and found.shapes[:1] == ("sphere",):
                    aspect = (1.0, 0.08)
                lies = next((_LIES[w] for w in reversed(words) if w in _LIES), None)
                return replace(_sized(found, before), depth=depth, aspect=aspect, lies=lies)
    return UNKNOWN


def _special(noun: str, context: str) -> Usual | None:
    text = " ".join(words_of(context))
    for key, entry in _TABLE.items():
        if key.endswith(f" {noun}") and f" {key} " in f" {text} ":
            return entry
    return None


def _sized(entry: Usual, adjectives: tuple[str, ...]) -> Usual:
    for word in adjectives:
        if word in _TIMES:
            entry = replace(entry, metres=entry.metres * _TIMES[word], spread=entry.spread + 0.2)
    return entry


def support_height(name: str) -> float | None:
    """Usual height of a support's top above the floor, m; None where the name says nothing."""
    for word in reversed(words_of(name)):
        if word in HEIGHTS:
            return HEIGHTS[word]
    return None


def is_stairs(name: str) -> bool:
    """Whether a support of that name has several steps; one step or stair is a block."""
    return bool(STAIRS & set(re.findall(r"[a-z]+", name.lower())))


def told_steps(text: str) -> int | None:
    """How many steps words tell: "three_steps", "a flight of four stairs"; None for none."""
    found = re.search(
        rf"\b({'|'.join(_NUMBERS)})\s+(?:\w+\s+){{0,2}}?(?:steps|stairs|treads)\b",
        text.lower().replace("_", " "),
    )
    return _NUMBERS.index(found.group(1)) + 2 if found else None


def is_rails(name: str) -> bool:
    """Whether a support of that name is a pair of rails."""
    return bool(RAILS & set(re.findall(r"[a-z]+", name.lower())))


def grows(name: str) -> bool:
    """Whether a thing of that name is rooted where it stands; a pine table is not."""
    return bool(GROWS & set(words_of(name)[-1:]))


def support_kind(name: str) -> str:
    """`floor`, `ramp`, `wall` or `slab`: what a support of that name is. Stairs are a ramp."""
    words = set(words_of(name))
    if words & RAMPS or is_stairs(name):
        return "ramp"
    if words & WALLS:
        return "wall"
    if words & HEIGHTS.keys():
        return "slab"
    return "floor" if words & GROUND else "slab"
