"""The words that the reader knows, as plain data; nothing here belongs to one picture."""

from physagent_studio.knowledge import all_words, kinds, word_lists
from physagent_studio.language.frames import Way
from physagent_studio.language.tokens.verbs import COMBINED as COMBINED
from physagent_studio.language.tokens.verbs import IRREGULAR as IRREGULAR
from physagent_studio.language.tokens.verbs import PARTICIPLES as PARTICIPLES
from physagent_studio.language.tokens.verbs import VERBS as VERBS
from physagent_studio.language.tokens.verbs import WITH_OBJECT as WITH_OBJECT
from physagent_studio.language.tokens.verbs import Gait as Gait
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
    "gravity": "gravity", "drag": "friction", "weight": "gravity", "inertia": "inertia",
    "momentum": "inertia", **dict.fromkeys(sorted(word_lists().actors), "person"), "puff": "wind",
    "impact": "impact", "collision": "impact", "fan": "wind",
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
    "everywhere": "outward", "off": "off", "aside": "sideways", "lateral": "sideways",
}  # fmt: skip

VIEW_WORDS = words_of("picture image frame view shot screen sight")
CAMERA_WORDS = words_of("camera viewer us observer lens you")

MANNERS: dict[str, str] = {
    **dict.fromkeys(
        words_of("slowly slow gradually leisurely sluggishly lazily cautiously hesitantly"), "slow"
    ),
    "offscreen": "offscreen",
    **dict.fromkeys(
        words_of("gently gentle softly lightly light soft weak weakly mild mildly carefully"),
        "gentle",
    ),
    **dict.fromkeys(
        words_of(
            "quickly quick fast rapidly rapid swiftly suddenly swift sudden abruptly briskly madly"
        ),
        "fast",
    ),
    **dict.fromkeys(
        words_of(
            "hard heavily heavy strongly strong forcefully powerfully powerful violently violent "
            "firmly forceful fiercely vigorously energetically furiously wildly"
        ),
        "hard",
    ),
    **dict.fromkeys(
        words_of("continuously continuous steadily steady constantly smoothly smooth"), "continuous"
    ),
    **dict.fromkeys(words_of("rhythmically rhythmic periodically periodic repeatedly"), "rhythmic"),
    **dict.fromkeys(("straight", "directly", "vertical"), "straight"),
    **dict.fromkeys(("slightly", "barely", "slight"), "slight"),
    "closely": "close",
    "pliantly": "pliant",
    "afar": "far",
    "clockwise": "clockwise",
    "counterclockwise": "anticlockwise",
    "anticlockwise": "anticlockwise",
}

FILLERS = words_of(
    "finally eventually then also just immediately naturally simply together "
    "again afterwards afterward thereby instead soon later now initially first meanwhile please "
    "suddenly still completely fully entirely quite very too so well thus hence "
    "therefore already only even once there here subsequently next under freely "
    "perfectly cleanly really squarely anywhere somewhat promptly soon just out closer nearer "
    "briefly unexpectedly silently quietly loudly noisily gracefully helplessly playfully clumsily "
    "awkwardly accidentally deliberately intentionally visibly noticeably dramatically "
    "realistically effortlessly inevitably predictably harmlessly safely neatly happily sadly "
    "angrily totally dangerously precariously merely instantly"
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
    "intact": "still", "unaffected": "still", "fixed": "still", "parked": "still",
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
NEARER = {"nearer": "front", "closer": "front", "farther": "back", "further": "back"}
"""Which of two things is meant, before its noun; elsewhere they tell how far something goes."""
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
_SMALL = (
    "one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen "
    "sixteen seventeen eighteen nineteen twenty"
)
_TENS = "thirty forty fifty sixty seventy eighty ninety hundred"
NUMBERS = {
    **{word: count for count, word in enumerate(_SMALL.split(), 1)},
    **{word: 10 * count for count, word in enumerate(_TENS.split(), 3)},
}
OTHERS = words_of("other others remaining rest")
MATERIAL_WORDS = words_of(
    "wooden metal metallic plastic rubber glass stone ceramic foam paper cardboard clay "
    "leather steel iron concrete icy frozen sandy cotton acrylic"
)
PLAIN_ADJECTIVES = words_of(
    "ripe flat round square long narrow wide original new same whole single nearby hanging "
    "resting moving rolling falling flying standing sliding empty full shifting stationary "
    "old heavy light hard soft loose entire final initial side opposite grassy inside "
    "open free shiny smooth rough high low sharp steep great perfect graceful deep shallow mighty "
    "brisk firm complete tight lazy clean beautiful thin thick loud dull quiet"
)

DETERMINERS = words_of(
    "a an the this that these those its their his her our my your each every all both some any "
    "another several no most allbutone either"
)
BOUNDS = words_of("atleast atmost exactly morethan fewerthan")
"""What stands before a number that is a limit: "at least two of the pins"."""
SHARES: dict[str, tuple[float, float]] = {
    "halfway": (0.35, 0.65), "midway": (0.35, 0.65), "alltheway": (0.9, 10.0),
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
    "about throughout during like except infront leftof rightof atop alongwith"
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
    "alongwith": "with",
}  # fmt: skip

GROUND_WORDS = all_words(lambda kind: kind.support == "floor")
PLIANT = word_lists().pliant
LAID = word_lists().laid
"""What lies on the ground: where nobody marks it, it is the ground."""
SUPPORT_CLASSES: dict[str, frozenset[str]] = {
    name: all_words(lambda kind, name=name: kind.surface == name)
    for name in sorted({kind.surface for kind in kinds() if kind.surface})
}
"""Words for what things stand on that may stand for one another."""
SUPPORT_CLASSES["level"] |= {"surface"}
TABLE_WORDS = SUPPORT_CLASSES["level"]
PARTS: dict[str, str] = {
    "edge": "edge", "rim": "edge", "brink": "edge", "border": "edge", "corner": "edge",
    "side": "side", "end": "end", "bottom": "lower_end", "foot": "lower_end", "toe": "lower_end",
    "base": "lower_end", "top": "upper_end", "crest": "upper_end", "center": "center",
    "centre": "center", "middle": "center", "surface": "surface",
}  # fmt: skip
LANDMARKS = {word: kind for kind, said in word_lists().places.items() for word in said}
MASS_HEADS = word_lists().of
"""Heads that stand for what follows their "of"."""

GROWTH = word_lists().growth
"""What moves with the plant that it grows on."""

WITHDRAWING = words_of("pull remove take withdraw yank drag tug kick knock push slide drop vanish")
"""Verbs after which a support is no longer where it was."""
PROPS = word_lists().props
"""What may carry a thing that the case does name."""
LIMBS = word_lists().limbs
"""Parts of a thing that stand for it: "bumps against its leg"."""
HOLDERS = word_lists().holders
"""What something hangs by; where the case does not give it, that tells nothing more."""
SOUNDS = word_lists().sounds
"""What is heard of what happens: "with a crash"."""
UNDER = words_of("beneath under underneath below")

IGNORED_NOUNS = words_of(
    "position place motion way air mass direction distance path force time speed balance "
    "support frame stop rest center centre end case fashion manner movement scene image "
    "picture other each result order turn angle height clip video effect action moment origin "
    "location spin halt speed momentum direction stand peak apex axis amplitude"
)
"""Nouns that name neither a thing nor a place of the scene."""

SYNONYMS: tuple[frozenset[str], ...] = tuple(
    all_words(lambda kind, family=family: family in kind.families)
    for family in sorted({family for kind in kinds() for family in kind.families})
)
GENERIC = words_of("object objects thing things item items body stuff")
COLLECTIVES = word_lists().collectives
"""Nouns that stand for all of a kind without a plural."""
