"""Fixed expressions of several words, and the plainer words that they are read as."""

from collections.abc import Collection, Iterable, Sequence

from physagent_studio.knowledge import word_lists
from physagent_studio.language.tokens.tokens import (
    Token,
    singular,
    verb_base,
)
from physagent_studio.language.tokens.vocabulary import (
    COMBINED,
    COUNTED_FROM,
    DETERMINERS,
    PARTS,
    words_of,
)


def _from_the(side: str) -> str:
    """The ways to say that several begin on a side, and so go on to the other."""
    return "|".join(
        f"{begin} {word} the {where}"
        for begin in ("starting", "beginning")
        for word in ("from", "at", "on", "with")
        for where in (side, f"{side} side", f"{side} end", f"{side}most one", f"{side} one")
    )


_COVER = ("behind", "under", "below", "beneath", "into", "inside", "underneath")
_UNDER = ("under", "underneath", "beneath", "below")
_SAME_PLACE = (
    "where it was", "where it stood", "where it lay",
    *(f"{at} the same {spot}" for at in ("on", "in", "at") for spot in ("spot", "place")),
)  # fmt: skip
_PLAIN = {
    "infront": "in front of",
    "atop": "on top of",
    "leftof": "to the left of|on the left of|left of",
    "rightof": "to the right of|on the right of|right of",
    "near": "next to|right next to|close to",
    "against": "up against",
    "behind": "on the other side of|on the far side of",
    "off": "out of|off of|out from between|from between|"
    + "|".join(f"{way}from {under}" for way in ("", "out ", "away ") for under in _UNDER),
    "before": "short of",
    "closely before": "right before|just before|shortly before|just short of",
    "closely infront": "right in front of|just in front of",
    "hits": "rear ends",
    "around the": "round the",
    "knocks over": "bowls over|mows down",
    "knocked over": "bowled over|mowed down|mown down",
    "knocking over": "bowling over|mowing down",
    "after": "only after|right after|just after|shortly after",
    "to": "over to|in order to",
    "up leftwards": "up to the left|high to the left",
    "up rightwards": "up to the right|high to the right",
    "to the": "up to the",
    **{word: f"back {word}" for word in ("down", "up", "onto", "on", "into", "in")},
    "away_from": "away from",
    "because_of": "because of|due to",
    "alongwith": "along with|together with",
    "masscenter": "center of mass|centre of mass",
    "except": "except for|apart from|other than|with the exception of",
    **{
        f"stays {where}": f"leave it {where}|leaves it {where}|leaving it {where}|"
        f"leave them {where}|leaves them {where}|leaving them {where}"
        for where in words_of("on in at there standing lying beside against inside upright")
    },
    "leftwards": "further left|farther left|to the left|from right to left|" + _from_the("right"),
    "rightwards": "further right|farther right|to the right|from left to right|"
    + _from_the("left"),
    "sideways": "to the side|to one side",
    **{f"from_{word}": f"from {word}" for word in ("behind", "above", "below")},
    "from_left": "from the left|coming from the left|blowing from the left",
    "from_right": "from the right|coming from the right|blowing from the right",
    "from_front": "from the front",
    "from_side": "from the side|from one side",
    "apart": "in opposite directions|away from each other|away from one another|into pieces|"
    "to pieces|into bits|into shards",
    "inwards": "toward each other|towards each other|toward one another|towards one another",
    "counted_top": "from the top",
    "counted_bottom": "from the bottom",
    "reach": "make it to",
    "reaches": "makes it to",
    "reached": "made it to",
    "set_down": "put down|set down|placed down|laid down|put back down|set back down",
    "set_downs": "puts down|sets down|places down|puts back down|sets back down",
    **{f"{stays} still": f"{stays} put" for stays in ("stays", "stay", "remains", "remain")},
    "stops": "gets stuck",
    "stop": "get stuck",
    "stopped": "got stuck",
    "stopping": "getting stuck",
    **{f"goes {way}": f"makes it {way}" for way in ("halfway", "up", "over", "across", "down")},
    **{
        f"{reverses} {to}": "|".join(f"{backs} {word}" for word in said.split())
        for reverses, backs in (("reverses", "backs"), ("reversing", "backing"))
        for to, said in (("into", "into"), ("toward", "toward towards"), ("off", "off"))
    },
    **{
        f"{drives} backwards to": f"{reverses} up to|{backs} up to"
        for drives, reverses, backs in (
            ("drives", "reverses", "backs"),
            ("driving", "reversing", "backing"),
        )
    },
    "twice": "a few times|a couple of times|several times",
    "afar": "a long way|a long distance|a great distance",
    **{f"on the {side}": f"on the far {side}|at the far {side}" for side in ("left", "right")},
    **{f"afar {way}": f"far {way}" for way in words_of("away across past beyond along down out")},
    "ends_up": "ends up|end up|ended up",
    "does not": "fails to|refuses to|is unable to|is not able to",
    "do not": "fail to|refuse to",
    "not": "no longer",
    "supine": "on its back|onto its back",
    "prone": "on its face|onto its face|face down|face first|on its belly|onto its belly|"
    "on its front|onto its front|on its nose|onto its nose|on its snout|onto its snout",
    "sidelong": "on its side|onto its side|on their sides|to its side|onto its left side|"
    "on its left side|to its left side|onto its right side|on its right side|to its right side|"
    "over to its side|over to its left side|over to its right side",
    "inverted": "upside down|on its roof|onto its roof|on its head",
    "stays upright": "rights itself|returns upright|comes back upright|"
    "returns to its upright position|returns to an upright position|"
    "goes back to its upright position|stands upright again",
    "steadily": "at constant speed|with constant speed|at a constant speed|at a steady speed|"
    "at a steady pace|with a constant speed|at constant velocity|with constant velocity",
    "": "at all|in the least|off centre|off center|realistic physics :|realistically :",
    "and": "and in turn|hard enough to|with enough force to|strongly enough to|fast enough to",
    "upright": "on its wheels|on its feet|on its legs|on its paws|on all fours|on its base",
    "lifts": "picks up|takes up",
    "lift": "pick up|take up",
    "lifting": "picking up",
    "lifted": "picked up|taken up",
    "lifted off": "taken off|taken from",
    "there": "right there|just there",
    "briefly": "for a moment|for a second|for a while|for a bit|for an instant|for a short time",
    "stays airborne": "held in the air|held up in the air|held aloft|held in mid air",
    "airborne": "in the air|through the air|in mid air|into the air",
    "motionless": "on the spot|in place|at rest",
    "straight": "head on|head first|headfirst|headlong",
    "over": "off balance|off its balance",
    "hundred": "hundred and",
    **{
        f"afar {side}wards": f"far to the {side}|"
        + "|".join(
            f"to the {side} {rim} of the {view}"
            for rim in ("edge", "side", "border", "end")
            for view in ("picture", "image", "frame", "photo", "photograph", "screen", "view")
        )
        for side in ("left", "right")
    },
    "swap": "swap places|switch places|trade places|change places",
    **{f"moves {where}": f"disappears {where}|vanishes {where}" for where in _COVER},
    **{f"move {where}": f"disappear {where}|vanish {where}" for where in _COVER},
    "moves offscreen": "disappears|vanishes|disappears offscreen|vanishes offscreen|"
    "disappears from view|disappears from sight|vanishes from view|vanishes from sight|"
    "disappears from the picture|disappears from the frame",
    "move offscreen": "disappear|vanish|disappear offscreen|disappear from view",
    **{
        f"{lands} straight": "|".join(f"{lands} {same}" for same in _SAME_PLACE)
        for lands in ("lands", "land", "falls", "fall", "landing")
    },
    **{
        f"{comes} straight down": "|".join(
            f"{comes} {down} {same}" for same in _SAME_PLACE for down in ("down", "back down")
        )
        for comes in ("comes", "come")
    },
    "where_it_started": "where it started|where it came from",
    "m/s": "meters per second|metres per second|meter per second|metre per second",
    "km/h": "kilometers per hour|kilometres per hour",
    "halfway": "half way|half of the way",
    "alltheway": "all the way|the whole way",
    "rhythmically": "back and forth|to and fro|side to side|from side to side|up and down",
    "successively": "one after the other|one after another|one by one|in sequence|in succession|"
    "in turn|in order",
    "simultaneously": "at the same time",
    "accelerating": "gathering speed|gaining speed|picking up speed",
    "accelerates": "gathers speed|picks up speed|gains speed",
    "slowing": "losing speed|losing momentum",
    "up": "up into the sky|into the sky|up to the sky|towards the sky|toward the sky",
    "recovers": "springs back|snaps back|springs back into shape|regains its shape|"
    "returns to its shape|returns to its original shape|goes back to its shape",
    "topples the others successively": "sets off a chain reaction|triggers a chain reaction|"
    "starts a chain reaction|causes a chain reaction",
    # "Which in turn knocks over the cup": it is one thing that does so.
    "which": "which in turn",
    "reverses": "backs up|backs away|backs out",
    "reversing": "backing up|backing away|backing out",
    "reverses offscreen": "backs offscreen",
    "reversing offscreen": "backing offscreen",
    "backwards": "in reverse",
    "turns around": "makes a u-turn|does a u-turn|makes a u turn|does a u turn",
    "naturally": "by itself|by themselves|on its own|on their own|all by itself|all on its own|"
    "all by themselves",
    "slightly": "a little|a bit|a short way|a short distance|a little way",
    "also": "as well",
    "so": "so that",
    "assoonas": "as soon as",
    "atleast": "at least|no fewer than|no less than",
    "atmost": "at most|no more than|not more than",
    "morethan": "more than",
    "fewerthan": "fewer than|less than",
    "atleast two": "two or more",
    "two": "a couple of",
    "most": "most of the",
    "allbutone": "all but one of the|all but one",
    "they": "they both|they all",
    "them": "them both|them all|any of them|either of them",
    "both": "both of them",
    "all": "all of them",
    "all the": "all of the",
    "both the": "both of the",
    "each": "each of the",
    "either": "either of the",
    "the": "any of the",
    "others": "everything else|anything else|the rest|all the rest",
    "the other": "the rest of the",
    # A quantity of nothing denies the clause that it stands in.
    "not all the": "none of the",
    "not them": "none of them|neither of them",
    "not both the": "neither of the",
    "not others": "nothing else",
    "not everything": "nothing",
    "not both": "neither",
    "and not": "nor",
    "not every": "no",
    "without": "with no",
}
"""Fixed expressions by the plainer words that they are read as."""
FIXED: tuple[tuple[tuple[str, ...], str], ...] = tuple(
    (tuple(words.split()), one)
    for words, one in (
        *((words, one) for one, said in _PLAIN.items() for words in said.split("|")),
        *word_lists().joined.items(),
    )
)
ADVERBIAL = words_of(
    "motionless airborne sidelong inverted halfway midway alltheway successively simultaneously "
    "alone nearly almost supine prone where_it_started from_left from_right from_front from_side "
    "from_behind from_above from_below"
)

_KNOCKED = ("knocks over", "knocked over", "knocking over")


def join_fixed(
    tokens: Sequence[Token], names: Iterable[tuple[str, ...]], nouns: Collection[str] = ()
) -> tuple[Token, ...]:
    """Replaces fixed expressions by plainer ones, and the case's own names of several words by one
    token each; all tokens of a replacement have the span of what was written.

    nouns: words of the case's names; "from the top shelf" is from that shelf, and "to the left
    cup" to that cup.
    """
    own = [(words, "_".join(words)) for words in names if len(words) > 1]
    rows = enumerate(sorted([*own, *FIXED], key=lambda row: -len(row[0])))
    begins: dict[str, list[tuple[int, tuple[tuple[str, ...], str]]]] = {}
    for row in rows:
        begins.setdefault(row[1][0][0], []).append(row)
    joined: list[Token] = []
    index = 0
    while index < len(tokens):
        first = tokens[index].text
        beginning = (row for form in {first, singular(first)} for row in begins.get(form, ()))
        for _, (words, one) in sorted(beginning):
            part = tokens[index : index + len(words)]
            after = tokens[index + len(words) : index + len(words) + 2]
            told = len(part) == len(words) and _same(part, words, one)
            if told and not _is_literal(words, one, tokens[max(index - 1, 0)], after, nouns):
                joined += [Token(word, part[0].start, part[-1].end) for word in one.split()]
                index += len(words)
                break
        else:
            joined.append(tokens[index])
            index += 1
    return tuple(joined)


def _is_literal(
    words: tuple[str, ...],
    one: str,
    before: Token,
    following: Sequence[Token],
    nouns: Collection[str],
) -> bool:
    """Whether the words of an expression mean what they say where they stand."""
    after = following[0].text if following else "."
    if one.endswith(("leftwards", "rightwards")) or one in COUNTED_FROM:
        # "To the left cup", "to the left edge of the table".
        of = after == "side" and len(following) > 1 and following[1].text == "of"
        return singular(after) in nouns or of or PARTS.get(after) in ("edge", "end")
    if one in _KNOCKED:
        # "Pushes the bowls over the edge".
        return singular(words[0]) in nouns
    if words == ("up", "and", "down"):
        # "Rolls up and down the ramp".
        return after in DETERMINERS
    if words == ("no",):
        # "No: the bottle falls over" is no quantity.
        return not after[0].isalnum()
    return words == ("over", "to") and _goes_over(before.text)


def _goes_over(word: str) -> bool:
    """ "Is knocked over to the right": over, and that way; "rolls over to the box" is to it."""
    return COMBINED.get((verb_base(word) or "", "over")) in ("topple", "knock_over")


def _same(part: Sequence[Token], words: tuple[str, ...], one: str) -> bool:
    last = part[-1].text
    return all(t.text == w for t, w in zip(part[:-1], words, strict=False)) and (
        last == words[-1] or ("_" in one and singular(last) == words[-1])
    )
