"""The words that the reader knows, as plain data; nothing here belongs to one picture."""

from __future__ import annotations

from physagent_studio.language.frames import Way
from physagent_studio.language.tokens.verbs import COMBINED as COMBINED
from physagent_studio.language.tokens.verbs import IRREGULAR as IRREGULAR
from physagent_studio.language.tokens.verbs import PARTICIPLES as PARTICIPLES
from physagent_studio.language.tokens.verbs import VERBS as VERBS
from physagent_studio.language.tokens.verbs import WITH_OBJECT as WITH_OBJECT
from physagent_studio.language.tokens.verbs import Kind as Kind
from physagent_studio.language.tokens.verbs import Verb as Verb
from physagent_studio.language.tokens.verbs import words_of as words_of

FORCE_NOUNS = words_of(
    "force push shove kick nudge impulse hit tap blow bump knock strike poke thrust impact "
    "throw toss pressure"
)
FORCE_SENSE = {"kick": "kick", "throw": "throw", "toss": "throw", "hit": "push", "blow": "push"}

CAUSES: dict[str, str] = {
    "wind": "wind", "breeze": "wind", "gust": "wind", "air": "air", "airflow": "wind",
    "storm": "wind", "draft": "wind", "draught": "wind", "friction": "friction",
    "gravity": "gravity", "drag": "friction", "person": "person", "hand": "person",
    "someone": "person", "player": "person", "finger": "person", "foot": "person",
    "child": "person", "kicker": "person", "weight": "gravity", "inertia": "inertia",
    "momentum": "inertia", **dict.fromkeys(
        words_of(
            "somebody anybody people cat dog kid boy girl baby toddler puppy kitten guy lady man "
            "woman pet bird robot"
        ),
        "person",
    ), "puff": "wind", "impact": "impact", "collision": "impact", "fan": "wind",
}  # fmt: skip

DIRECTIONS: dict[str, str] = {
    "left": "left", "leftward": "left", "leftwards": "left", "right": "right",
    "rightward": "right", "rightwards": "right", "forward": "forward", "forwards": "forward",
    "ahead": "forward", "onward": "forward", "onwards": "forward", "backward": "backward",
    "backwards": "backward", "back": "backward", "up": "up", "upward": "up", "upwards": "up",
    "down": "down", "downward": "down", "downwards": "down", "downhill": "down",
    "uphill": "up", "sideways": "sideways", "sideway": "sideways", "sideward": "sideways",
    "laterally": "sideways", "apart": "outward", "outward": "outward", "outwards": "outward",
    "vertically": "down", "inward": "inward", "inwards": "inward", "away": "off",
    "off": "off", "aside": "sideways", "lateral": "sideways",
}  # fmt: skip

VIEW_WORDS = words_of("picture image frame view shot screen sight")
CAMERA_WORDS = words_of("camera viewer us observer lens you")

MANNERS: dict[str, str] = {
    **dict.fromkeys(words_of("slowly slow gradually leisurely sluggishly"), "slow"),
    "offscreen": "offscreen",
    **dict.fromkeys(
        words_of("gently gentle softly lightly light soft weak weakly mild mildly"), "gentle"
    ),
    **dict.fromkeys(
        words_of("quickly quick fast rapidly rapid swiftly suddenly swift sudden"), "fast"
    ),
    **dict.fromkeys(
        words_of(
            "hard heavily heavy strongly strong forcefully powerfully powerful violently violent "
            "firmly forceful fiercely"
        ),
        "hard",
    ),
    **dict.fromkeys(
        words_of("continuously continuous steadily steady constantly smoothly smooth"), "continuous"
    ),
    **dict.fromkeys(words_of("rhythmically rhythmic periodically periodic repeatedly"), "rhythmic"),
    **dict.fromkeys(("straight", "directly", "vertical"), "straight"),
    **dict.fromkeys(("slightly", "barely"), "slight"),
    "closely": "close",
}

FILLERS = words_of(
    "finally eventually then also just immediately naturally simply together "
    "again afterwards afterward thereby instead soon later now initially first meanwhile please "
    "suddenly still completely fully entirely quite very too so well thus hence "
    "therefore already only even once there here subsequently next under freely "
    "perfectly cleanly really squarely anywhere somewhat promptly soon just out"
)
TIMINGS: dict[str, str] = {"successively": "in_turn", "simultaneously": "together"}
"""How several that do the same stand to each other in time."""
NEARLY = ("nearly", "almost")
"""What nearly happens does not."""
COUNTS = {"once": 1, "twice": 2, "thrice": 3}

POSTURES: dict[str, str] = {
    "upright": "upright", "standing": "upright", "stable": "still", "still": "still",
    "untouched": "still", "unmoved": "still", "motionless": "still", "stationary": "still",
    "undisturbed": "still", "unharmed": "still", "unscathed": "still", "undamaged": "still",
    "intact": "still", "unaffected": "still", "fixed": "still",
    "put": "still", "supine": "supine", "prone": "prone",
    "flat": "flat", "steady": "still", "balanced": "upright",
    "vertical": "upright", "behind": "still",
}  # fmt: skip

COLOURS = words_of(
    "red orange yellow green blue purple violet pink brown black white gray grey silver gold "
    "golden beige cyan magenta turquoise transparent clear striped dark bright pale"
)
SIZES = {
    **dict.fromkeys(
        words_of("small tiny little smaller smallest littlest mini short shorter shortest"), "small"
    ),
    **dict.fromkeys(
        words_of("large big huge tall giant bigger biggest larger largest massive taller tallest"),
        "large",
    ),
}
POSITIONS: dict[str, str] = {
    "top": "top", "upper": "top", "topmost": "top", "uppermost": "top", "highest": "top",
    "bottom": "bottom", "lower": "bottom", "lowest": "bottom", "lowermost": "bottom",
    "bottommost": "bottom", "left": "left", "leftmost": "left", "lefthand": "left",
    "right": "right", "rightmost": "right", "righthand": "right", "middle": "middle",
    "central": "middle", "center": "middle", "centre": "middle", "front": "front",
    "nearest": "front", "closest": "front", "rear": "back", "back": "back", "far": "back",
    "farthest": "back", "furthest": "back", "near": "front", "outer": "outer",
    "outermost": "outer", "inner": "inner", "innermost": "inner",
}  # fmt: skip
SIDES: dict[str, Way] = {
    "left": "left", "lefthand": "left", "right": "right", "righthand": "right", "far": "away",
    "back": "away", "rear": "away", "near": "toward_camera", "front": "toward_camera",
}  # fmt: skip
"""Which way the sides of a thing lie; "the back of the plate" is a part of it."""
ORDINALS = {"first": 1, "second": 2, "third": 3, "fourth": 4, "fifth": 5, "last": -1}
COUNTED_FROM = {
    "counted_top": "top", "counted_bottom": "bottom", "counted_left": "left",
    "counted_right": "right",
}  # fmt: skip
"""Fixed expressions after a noun: "the second box from the top"."""
NUMBERS = {
    "one": 1, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8,
    "nine": 9, "ten": 10,
}  # fmt: skip
OTHERS = words_of("other others remaining rest")
MATERIAL_WORDS = words_of(
    "wooden metal metallic plastic rubber glass stone ceramic foam paper cardboard clay "
    "leather steel iron concrete icy frozen sandy cotton acrylic"
)
PLAIN_ADJECTIVES = words_of(
    "ripe flat round square long narrow wide original new same whole single nearby hanging "
    "resting moving rolling falling flying standing sliding empty full shifting stationary "
    "old heavy light hard soft loose entire final initial side opposite grassy inside "
    "open free shiny smooth rough"
)

DETERMINERS = words_of(
    "a an the this that these those its their his her our my your each every all both some any "
    "another several no most allbutone either"
)
BOUNDS = words_of("atleast atmost exactly morethan fewerthan")
"""What stands before a number that is a limit: "at least two of the pins"."""
SHARES: dict[str, tuple[float, float]] = {
    "halfway": (0.35, 0.65), "midway": (0.35, 0.65), "alltheway": (0.9, 10.0),
    "partway": (0.1, 0.9), "mostway": (0.6, 1.0), "thirdway": (0.22, 0.45),
}  # fmt: skip
"""How much of a way is gone."""
PRONOUNS = words_of(
    "i we it that this they them itself themselves one others everything anything he she him"
)
AUXILIARIES = words_of(
    "is are was were be been being am has have had do does did will would shall should may "
    "might must could can gets getting becomes become became"
)
BE = words_of("is are was were be been being am gets getting get got becomes become became")
NEGATIONS = words_of("not never n't cannot hardly")
PREPOSITIONS = words_of(
    "on onto upon in into inside within to toward towards from off of over under underneath "
    "beneath below above across along through past against with without by at near beside "
    "behind before after around between among beyond down up outside until via for alongside "
    "about throughout during like starting_with nearest_to except infront leftof rightof atop "
    "as_much_as"
)
CONJUNCTIONS = words_of("and or but then nor")
SUBORDINATORS = words_of(
    "as while when because since so until before after if although though whereas whilst once "
    "where until without assoonas"
)
RELATIVES = frozenset(["that", "which", "who"])

RELATIONS: dict[str, str] = {
    "on": "on", "onto": "on", "upon": "on", "in": "in", "into": "into", "inside": "in",
    "within": "in", "to": "toward", "toward": "toward", "towards": "toward", "at": "at",
    "from": "from", "off": "off", "over": "over", "across": "along", "past": "past",
    "beyond": "past", "through": "through", "along": "along", "down": "down", "up": "up",
    "under": "under", "underneath": "under", "beneath": "under", "below": "under",
    "infront": "in_front", "leftof": "left_of", "rightof": "right_of", "atop": "atop",
    "above": "above", "against": "against", "near": "near", "beside": "near", "behind": "behind",
    "before": "before", "after": "after", "around": "around", "between": "between",
    "with": "with", "by": "by", "until": "until", "outside": "off", "alongside": "near",
}  # fmt: skip

GROUND_WORDS = words_of(
    "floor ground grass field lawn pitch lane road street pavement rink ice sand beach court "
    "carpet turf snow asphalt sheet track soil dirt"
)
TABLE_WORDS = words_of(
    "table tabletop desk counter countertop bench worktop surface workbench sideboard nightstand"
)
SUPPORT_CLASSES: tuple[frozenset[str], ...] = (
    TABLE_WORDS,
    words_of("ramp slope incline wedge slide chute hill hillside"),
    frozenset(["belt", "conveyor"]),
    frozenset(["shelf", "ledge", "rack"]),
    frozenset(["step", "stair", "stairs"]),
    frozenset(["wall"]),
    words_of("platform stage podium pedestal"),
)
PARTS: dict[str, str] = {
    "edge": "edge", "rim": "edge", "brink": "edge", "border": "edge", "corner": "edge",
    "side": "side", "end": "end", "bottom": "lower_end", "foot": "lower_end", "toe": "lower_end",
    "base": "lower_end", "top": "upper_end", "crest": "upper_end", "center": "center",
    "centre": "center", "middle": "center", "surface": "surface",
}  # fmt: skip
LANDMARKS: dict[str, str] = {
    "goal": "opening", "net": "opening", "hoop": "opening", "gate": "opening", "hole": "opening",
    "doorway": "opening", "door": "opening", "gap": "opening", "pocket": "opening",
    "line": "line", "stripe": "line", "finish": "line", "target": "point", "bullseye": "point",
    "mark": "point", "marker": "point", "spot": "point", "zone": "area",
    "area": "area", "circle": "area", "square": "area", "region": "area",
}  # fmt: skip
MASS_HEADS = words_of(
    "stack pile row pair set group line bunch tower heap piece block slice number all each "
    "one two three four five six seven eight nine ten some both half"
)
"""Heads that stand for what follows their "of"."""

WITHDRAWING = words_of("pull remove take withdraw yank drag tug kick knock push slide drop vanish")
"""Verbs after which a support is no longer where it was."""
PROPS = words_of("support plate prop base stand holder board block pillar post leg bracket")
"""What may carry a thing that the case does name."""
UNDER = words_of("beneath under underneath below")

IGNORED_NOUNS = words_of(
    "position place motion way air mass direction distance path force time speed balance "
    "support frame stop rest center centre end case fashion manner movement scene image "
    "picture other each result order turn angle height clip video effect action moment origin "
    "location spin halt speed momentum direction stand"
)
"""Nouns that name neither a thing nor a place of the scene."""

SYNONYMS: tuple[frozenset[str], ...] = tuple(
    frozenset(row.split())
    for row in (
        "ball football sphere",
        "car vehicle automobile truck lorry",
        "sled sledge sleigh toboggan",
        "tyre tire",
        "sofa couch settee",
        "cushion pillow",
        "plate dish saucer",
        "jelly jello gelatin pudding",
        "phone smartphone cellphone",
        "water sea ocean lake pond pool",
        "parasol umbrella",
        "cookie biscuit",
        "rug mat",
        "spanner wrench",
        "flag banner",
        "spade shovel",
        "trolley cart",
        "stone rock boulder pebble",
        "can tin",
        "bin trashcan dustbin trash garbage wastebasket",
        "box crate carton package parcel",
        "cube block die box brick",
        "cup mug glass tumbler",
        "bottle flask",
        "suit clothes clothing garment costume outfit laundry dress shirt coat jacket robe",
        "house castle building",
        "tree plant",
        "puck disc disk",
        "pin skittle bowlingpin",
        "stool chair seat",
        "scooter moped motorcycle motorbike",
        "bike bicycle",
        "book volume",
        "duck toy",
        "car toy",
        "balloon",
        "pot vase jar urn",
        "lamp lantern",
        "domino tile",
        "person man woman figure figurine doll",
        "orange apple persimmon lemon lime peach pear melon pumpkin plum grape cherry banana mango "
        "strawberry apricot nectarine grapefruit watermelon kiwi fruit",
    )
)
GENERIC = words_of("object objects thing things item items body stuff")
COLLECTIVES = words_of("fruit crockery tableware cutlery furniture luggage stuff")
"""Nouns that stand for all of a kind without a plural."""
