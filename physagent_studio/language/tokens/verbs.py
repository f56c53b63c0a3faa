"""Verbs that the reader knows, as plain data: their senses, forms and particles."""

from dataclasses import dataclass
from typing import Literal

Gait = Literal["", "drive", "run", "walk"]
"""How what goes by itself does so; each has a pace of its own."""
Kind = Literal["move", "act", "goto", "state", "light", "cause"]


@dataclass(frozen=True, slots=True)
class Verb:
    """What a verb means. kind says who undergoes it.

    move: the subject does it (with a direct object, the object does). act: the subject does it
    to the object. goto: the subject does it with regard to a place or thing. state: how the
    subject is. light: adds nothing of its own (starts to …). cause: subject makes … happen.
    """

    sense: str
    kind: Kind
    manner: tuple[str, ...] = ()
    gait: Gait = ""


def words_of(text: str) -> frozenset[str]:
    """The words of a text, as a set."""
    return frozenset(text.split())


def _verbs(kind: Kind, table: dict[str, str], manner: tuple[str, ...] = ()) -> dict[str, Verb]:
    return {
        word: Verb(sense, kind, manner) for sense, words in table.items() for word in words.split()
    }


def _goes(gait: Gait, words: str) -> dict[str, Verb]:
    return {word: Verb("move", "move", gait=gait) for word in words.split()}


VERBS: dict[str, Verb] = {
    **_verbs(
        "move",
        {
            "fall": "fall plummet plunge tumble drop plop plunk nosedive cascade dive clatter",
            "descend": "descend sink lower",
            "set_down": "set_down",
            "float": "float drift_down waft",
            "roll": "roll trundle trickle",
            "slide": "slide glide slither skate skim",
            "slip": "slip",
            "move": "move go travel advance proceed continue come head shift progress coast scoot "
            "whoosh ease wander budge skitter lurch jolt jerk meander swim",
            "drift": "drift",
            "fly": "fly soar sail swoop",
            "jump": "jump hop leap vault pounce spring",
            "rise": "rise raise elevate ascend climb lift levitate hoist pick",
            "topple": "topple tip overturn capsize keel flop slump",
            "lean": "lean tilt",
            "flip": "flip somersault cartwheel overturn_flip tumble_over",
            "spin": "spin rotate revolve twirl whirl pirouette",
            "turn": "turn pivot swivel twist",
            "curve": "curve bend_path arc veer swerve hook curl",
            "bounce": "bounce rebound ricochet recoil glance deflect carom",
            "stop": "stop halt brake freeze pause",
            "settle": "settle",
            "sway": "sway swing wave flutter flap oscillate wobble rock billow ripple shake "
            "tremble quiver teeter totter rustle jiggle vibrate bob rattle shudder jitter wriggle "
            "flail wiggle twitch quake",
            "bend": "bend bow flex sag droop",
            "collapse": "collapse crumble disintegrate cave implode",
            "break": "break shatter crack snap fracture burst splinter split smash pop explode "
            "tear rip",
            "cut": "cut snip sever",
            "spread": "spread flow scatter spill pour",
            "deform": "deform squash compress squeeze dent crumple buckle flatten squish mash "
            "smush stretch warp bulge deflate",
            "slow": "slow decelerate",
            "accelerate": "accelerate",
            "separate": "separate detach disconnect",
            "reverse": "reverse return",
            "recover": "recover",
        },
    ),
    **_goes("drive", "drive ride cruise steer chug"),
    **_goes(
        "run",
        "run race speed hurtle zip zoom dash barrel career careen rush dart whizz scurry scamper "
        "scuttle jog trot gallop sprint",
    ),
    **_goes(
        "walk",
        "walk stride march amble stroll waddle trek prance toddle roam prowl hobble stagger "
        "stumble",
    ),
    **_verbs("move", {"slide": "skid"}, ("skidding",)),
    **_verbs("move", {"move": "creep inch crawl plod slink tiptoe trudge"}, ("slow",)),
    **_verbs("act", {"push": "nudge"}, ("gentle",)),
    **_verbs("act", {"push": "flick"}, ("flicked",)),
    **_verbs("act", {"set_down": "put place lay insert tuck", "rise": "grab grasp"}),
    **_verbs("act", {"push": "carry bring transport"}, ("carried",)),
    **_verbs("act", {"hit": "bump collide crash ram"}, ("bodily",)),
    **_verbs("act", {"pull": "remove withdraw extract"}, ("out",)),
    **_verbs(
        "act",
        {
            "push": "push shove putt press poke prod propel bump_away force "
            "sweep bat paw swipe deliver",
            "pull": "pull drag tug tow yank draw haul",
            "kick": "kick boot punt",
            "throw": "throw toss hurl fling lob pitch launch shoot yeet chuck heave catapult sling",
            "hit": "hit strike smack slam clip tap contact touch impact "
            "graze meet whack thump wallop swat sideswipe scrape nick punch slap jostle bash "
            "plough plow",
            "knock": "knock bowl_over",
            "crush": "crush trample",
            "blow": "blow buffet",
            "tip_over": "upset upend",
            "catch": "catch",
            "dislodge": "dislodge displace disturb",
        },
    ),
    **_verbs(
        "goto",
        {
            "reach": "reach arrive",
            "cross": "cross traverse overstep",
            "pass": "pass overtake",
            "enter": "enter",
            "land": "land alight touchdown",
            "approach": "approach",
            "leave": "leave exit depart",
            "miss": "miss avoid dodge",
            "circle": "circle orbit encircle",
            "lose": "lose",
        },
    ),
    **_verbs(
        "state",
        {
            "stay": "remain stay keep wait",
            "rest": "rest sit lie stand perch",
            "end": "ends_up",
            "hang": "hang dangle hover",
            "stack": "stack pile balance",
        },
    ),
    **_verbs("light", {"start": "start begin resume", "try": "try attempt manage want"}),
    **_verbs("cause", {"make": "make cause let send set get give", "receive": "receive take"}),
    **_verbs("cause", {"change": "change"}),
    **_verbs("cause", {"drive": "follow"}),
    **_verbs("cause", {"form": "form"}),
}

IRREGULAR: dict[str, str] = {
    "swam": "swim", "swum": "swim", "slunk": "slink",
    "fell": "fall", "fallen": "fall", "threw": "throw", "thrown": "throw", "flew": "fly",
    "flown": "fly", "slid": "slide", "hung": "hang", "swung": "swing", "blew": "blow",
    "blown": "blow", "struck": "strike", "stricken": "strike", "broke": "break",
    "broken": "break", "spun": "spin", "went": "go", "gone": "go", "came": "come",
    "lost": "lose", "bent": "bend", "shook": "shake", "shaken": "shake", "sent": "send",
    "made": "make", "lay": "lie", "laid": "lay", "lying": "lie", "stood": "stand",
    "kept": "keep", "began": "begin", "begun": "begin", "rose": "rise", "risen": "rise",
    "caught": "catch", "drove": "drive", "driven": "drive", "sank": "sink", "sunk": "sink",
    "leapt": "leap", "crept": "creep", "got": "get", "gotten": "get", "gave": "give",
    "given": "give", "took": "take", "taken": "take", "met": "meet", "ran": "run",
    "sat": "sit", "dove": "dive", "froze": "freeze", "frozen": "freeze", "slung": "sling",
    "cut": "cut", "split": "split", "shot": "shoot", "rode": "ride", "overturned": "overturn",
    "hit": "hit", "set": "set", "let": "let", "burst": "burst", "flung": "fling",
    "sprang": "spring", "sprung": "spring", "put": "put", "held": "hold", "lowers": "sink",
    "lowered": "sink", "lowering": "sink", "swept": "sweep", "drew": "draw", "drawn": "draw",
}  # fmt: skip
"""Irregular forms; those that are past participles as well as regular `-ed` read as passive."""

PARTICIPLES = words_of(
    "fallen thrown flown hung swung blown struck broken spun lost bent shaken sent made laid "
    "frozen slung cut kept caught driven sunk given taken met hit set split shot flung hung "
    "slid held put swept set_down drawn"
)

COMBINED: dict[tuple[str, str], str] = {
    ("fall", "over"): "topple", ("fall", "apart"): "collapse", ("tumble", "over"): "topple",
    ("tip", "over"): "topple", ("topple", "over"): "topple", ("roll", "over"): "flip",
    ("turn", "over"): "flip", ("flip", "over"): "flip", ("turn", "around"): "turn_around",
    ("turn", "back"): "turn_around", ("turn", "about"): "turn_around", ("spin", "around"): "spin",
    ("turn", "left"): "curve", ("turn", "right"): "curve", ("bend", "left"): "curve",
    ("bend", "right"): "curve", ("bend", "to"): "curve",
    ("knock", "over"): "knock_over", ("knock", "down"): "knock_over",
    ("knock", "off"): "push", ("push", "over"): "knock_over", ("kick", "over"): "knock_over",
    ("tip", "off"): "fall", ("blow", "over"): "knock_over", ("come", "off"): "leave",
    ("slip", "off"): "slip", ("break", "apart"): "break", ("break", "up"): "break",
    ("slow", "down"): "slow", ("speed", "up"): "accelerate", ("fly", "off"): "fly",
    ("take", "off"): "rise", ("lift", "off"): "rise", ("go", "over"): "cross",
    ("bounce", "off"): "bounce", ("bounce", "back"): "bounce", ("come", "down"): "fall",
    ("go", "down"): "descend", ("move", "down"): "descend", ("push", "down"): "push",
    ("swing", "around"): "turn_around", ("drift", "down"): "float", ("sway", "down"): "float",
    ("float", "down"): "float", ("spread", "out"): "spread", ("cave", "in"): "collapse",
    ("roll", "back"): "reverse", ("slide", "back"): "reverse", ("move", "back"): "reverse",
    ("knock", "away"): "push", ("hit", "over"): "knock_over",
    ("come", "back"): "reverse", ("go", "back"): "reverse", ("float", "up"): "rise",
    ("drift", "up"): "rise", ("fly", "up"): "rise", ("shoot", "up"): "rise", ("go", "up"): "rise",
    ("blast", "off"): "rise",
    ("keel", "over"): "topple", ("blow", "down"): "knock_over", ("tumble", "down"): "fall",
    ("pop", "out"): "move", ("pop", "off"): "move", ("pop", "up"): "rise",
    ("knock", "flat"): "knock_over", ("crash", "down"): "fall",
    ("run", "over"): "crush", ("give", "in"): "collapse", ("slump", "over"): "topple",
    ("flop", "over"): "topple", ("curl", "around"): "curve",
    ("take", "down"): "knock_over", ("bring", "down"): "knock_over",
    **{(verb, "down"): "set_down" for verb in ("put", "place", "set")},
}  # fmt: skip
"""A verb with a particle or direction after it, where that makes another sense."""

WITH_OBJECT: dict[tuple[str, str], str] = {
    ("lose", "balance"): "lose_balance", ("lose", "support"): "lose_support",
    ("lose", "contact"): "lose_support", ("lose", "footing"): "slip", ("lose", "grip"): "slip",
    ("lose", "speed"): "slow", ("lose", "height"): "descend", ("lose", "momentum"): "slow",
    ("change", "direction"): "reverse", ("reverse", "direction"): "reverse",
    ("come", "rest"): "stop", ("come", "stop"): "stop", ("come", "halt"): "stop",
    ("gain", "speed"): "accelerate", ("make", "turn"): "curve", ("hit", "ground"): "land",
    ("hit", "floor"): "land", ("keep", "balance"): "stay", ("make", "contact"): "hit",
    ("make", "jump"): "jump", ("make", "leap"): "jump", ("make", "hop"): "jump",
    ("take", "leap"): "jump", ("make", "flip"): "flip", ("make", "somersault"): "flip",
    ("follow", "arc"): "curve",
    ("follow", "curve"): "curve", ("follow", "path"): "move", ("form", "arc"): "curve",
    ("form", "curve"): "curve", ("form", "c"): "curve", ("form", "circle"): "circle",
    ("make", "circle"): "circle", ("hold", "position"): "stay", ("keep", "position"): "stay",
    ("keep", "place"): "stay", ("give", "way"): "collapse",
}  # fmt: skip
"""A verb with the head of its object (or of its "to …"), where that makes another sense."""
