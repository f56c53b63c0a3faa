"""Turns of phrase that are put into plainer order before a sentence is cut into chunks."""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from physagent_studio.language.syntax.idioms import in_plain_words
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, singular, verb_base

UNREAD = re.compile(
    r"\b(?:by neither|nothing happens|first and(?! then\b| the (?:others?|rest)\b)|but not both"
    r"|the only one|on the left and right"
    r"|(?:nearest|closest) (?:to )?(?:the|it)|nor (?:does|do|did|is|are)|too \w+ to"
    r"|(?:one|ones|two|three) (?:below|above))\b|^only (?:after|when|once|then)\b"
)
"""Turns that change what a clause says in a way that is not read, and is said so."""


def rewritten(tokens: Sequence[Token], nouns: frozenset[str]) -> tuple[Token, ...]:
    """The tokens in plainer words, with "but" as an exception where it is one.

    nouns: the words of the case's names, which are no verbs.
    """
    found = _pliant(_behind(_at_rest(tuple(tokens)), nouns), nouns)
    found = _brought_down(
        _more_and_more(_unlikened(_shown(_wanted(_on_the_brink(_to_where(found))))))
    )
    return _excepted(in_plain_words(_in_company(found), nouns), nouns)


def _in_company(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "The cup glides to the right, the saucer along with it": along with the saucer."""
    words = [token.text for token in tokens]
    for at in range(len(words) - 2):
        with_it = words[at] in ("along", "together") and words[at + 1] == "with"
        if not with_it or words[at + 2] not in ("it", "them", "him", "her"):
            continue
        first = next((i for i in range(at, -1, -1) if words[i] in _ENDS - {"and"}), -1) + 1
        if 0 < first < at and not any(verb_base(word) for word in words[first:at]):
            moved = (*tokens[at : at + 2], *tokens[first:at])
            return (*tokens[: first - 1], *moved, *_in_company(tokens[at + 3 :]))
    return tokens


_ENDS = frozenset(".,;:!?") | v.CONJUNCTIONS | v.SUBORDINATORS


def _at_rest(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Nothing happens": nothing moves. "Nothing happens to the cup": the cup does not move."""
    words = [token.text for token in tokens]
    for at, pair in enumerate(pairwise(words)):
        if pair != ("nothing", "happens"):
            continue
        after = at + 2
        if not any(word.isalpha() for word in (*words[:at], *words[after:])):
            return (*tokens[: at + 1], replace(tokens[at + 1], text="moves"), *tokens[after:])
        if words[after : after + 1] == ["to"]:
            end = next((i for i in range(after, len(words)) if words[i] in _ENDS), len(words))
            still = (replace(tokens[at], text=word) for word in ("does", "not", "move"))
            return (*tokens[:at], *tokens[after + 1 : end], *still, *_at_rest(tokens[end:]))
    return tokens


_AFTER = {
    "follows": "goes", "follow": "go", "following": "going", "followed": "went",
    "chases": "goes", "chase": "go", "chasing": "going", "chased": "went",
}  # fmt: skip


def _behind(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "The ball follows the truck", "chases it": goes after it; not "follows a curve"."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        said = [t.text for t in tokens[at + 1 : at + 5]]
        led = next((w for w in said if w not in v.DETERMINERS | v.PLAIN_ADJECTIVES | v.COLOURS), "")
        thing = led in nouns - v.LANDMARKS.keys() or said[:1] in (["it"], ["them"])
        if token.text in _AFTER and thing:
            found += [replace(token, text=word) for word in (_AFTER[token.text], "after")]
        else:
            found.append(token)
    return tuple(found)


_LIKE = v.words_of("like as if though it they was were is are made of from out a an some")
"""What comes before the stuff that something behaves like."""


def _pliant(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "Wobbles like jelly", "as if it were made of rubber": that it gives way and comes back."""
    for at, token in enumerate(tokens):
        first = at
        while first and tokens[first - 1].text in _LIKE | v.PLAIN_ADJECTIVES:
            first -= 1
        said = [t.text for t in tokens[first:at]]
        likened = [i for i, word in enumerate(said) if word in ("like", "as")]
        if token.text in v.PLIANT - nouns and likened:
            first += likened[0]
            way = Token("pliantly", tokens[first].start, token.end)
            return (*tokens[:first], way, *_pliant(tokens[at + 1 :], nouns))
    return tokens


_BECOMES = v.words_of("get become grow")
_GRADUALLY = {"slower": "slows", "faster": "accelerates", "quicker": "accelerates"}


def _more_and_more(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Rolls slower and slower": and slows."""
    found = tokens
    for at in range(len(tokens) - 3, 0, -1):
        one, link, other, *_ = (*(token.text for token in found[at : at + 3]), "", "", "")
        if one == other and link == "and" and one in _GRADUALLY:
            # "Gets faster and faster": speeds up, with no verb before it.
            first = at - (verb_base(found[at - 1].text) in _BECOMES)
            links = () if first < at else ("and",)
            start, end = found[first].start, found[at + 2].end
            said = tuple(Token(word, start, end) for word in (*links, _GRADUALLY[one]))
            found = (*found[:first], *said, *found[at + 3 :])
    return found


def _unlikened(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Slides off as if it were pulled": it slides off; what that looks like is no event."""
    for at, pair in enumerate(pairwise([token.text for token in tokens])):
        if pair in (("as", "if"), ("as", "though")):
            rest = range(at + 2, len(tokens))
            end = next((i for i in rest if tokens[i].text in _CLOSES), len(tokens))
            return (*tokens[:at], *_unlikened(tokens[end:]))
    return tokens


def _on_the_brink(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Is pushed to the brink of falling": and nearly falls."""
    for at in range(1, len(tokens) - 4):
        to, the, brink, of, what = (token.text for token in tokens[at : at + 5])
        turn = to in ("to", "on", "at") and (the, of) == ("the", "of")
        base = verb_base(what)
        if turn and brink in ("brink", "verge", "point") and what.endswith("ing") and base:
            first, last = tokens[at].start, tokens[at + 4].end
            said = (Token(word, first, last) for word in ("and", "nearly", f"{base}s"))
            return (*tokens[:at], *said, *_on_the_brink(tokens[at + 5 :]))
    return tokens


def _to_where(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Rolls to where the cup is": to the cup."""
    for at in range(len(tokens) - 3):
        if (tokens[at].text, tokens[at + 1].text) != ("to", "where"):
            continue
        ends = range(at + 3, min(at + 7, len(tokens)))
        end = next((i for i in ends if tokens[i].text in _STANDS), None)
        if end is not None and tokens[at + 2].text in v.DETERMINERS:
            rest = _to_where(tokens[end + 1 :])
            return (*tokens[: at + 1], *tokens[at + 2 : end], *rest)
    return tokens


_STANDS = v.words_of("is stands lies sits are stand lie sit")
_WANTS = v.words_of("want would like wish need 'd love please see have")
"""What stands before what a person wants to happen."""


def _wanted(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "I want the bottle to fall over": the bottle falls over."""
    words = [token.text for token in tokens]
    if words[:1] not in (["i"], ["we"]) or words[1:2] in ([], ["see"]):
        return tokens
    start = next((i for i, word in enumerate(words) if i and word not in (*_WANTS, "to")), 1)
    rest = tokens[start:]
    does = next((i for i, t in enumerate(rest[:-1]) if t.text == "to" and i), None)
    if start == 1 or does is None or verb_base(rest[does + 1].text) != rest[does + 1].text:
        return rest if start > 1 else tokens
    return (*rest[:does], *rest[does + 1 :])


_FILMED = v.words_of("shot video clip scene view footage animation closeup close film")


def _shown(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "A close-up of a car driving off": a car drives off. The camera always stays still."""
    words = [token.text for token in tokens]
    of = next((i for i, word in enumerate(words[:7]) if word in ("of", "showing")), 0)
    if of > 1 and words[0] in v.DETERMINERS and _FILMED & {*words[1:of]}:
        return _shown(tokens[of + 1 :])
    for at in range(len(words) - 2):
        said, how = words[at : at + 2], words[at + 2 : at + 4]
        if said == ["the", "camera"] and set(how[:1]) <= _HOLDS:
            end = at + 4
            end += end < len(words) and words[end] in ("while", "as", "and", ",", ".")
            if set(how[1:]) <= v.POSTURES.keys() | {"static", "fixed"}:
                return (*tokens[:at], *_shown(tokens[end:]))
    return tokens


_HOLDS = v.words_of("is stays remains keeps holds")
_CLOSES = frozenset(".,;:!?")


def _brought_down(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Falls and takes the cup down with it": and knocks the cup over."""
    found = list(tokens)
    for at, token in enumerate(tokens):
        said = [t.text for t in tokens[at + 1 : at + 8]]
        down = next((i for i in range(len(said) - 2) if said[i : i + 2] == ["down", "with"]), None)
        if token.text in _TAKES and down:
            found[at] = replace(token, text=_TAKES[token.text])
            what = found[at + 1 : at + 1 + down]
            over = replace(tokens[at + 1 + down], text="over")
            return (*found[: at + 1], *what, over, *_brought_down(tokens[at + down + 4 :]))
    return tokens


_TAKES = {
    **dict.fromkeys(("takes", "brings", "drags", "pulls"), "knocks"),
    **dict.fromkeys(("take", "bring", "drag", "pull"), "knock"),
    **dict.fromkeys(("taking", "bringing", "dragging", "pulling"), "knocking"),
}


def _is_verb(word: str, nouns: frozenset[str]) -> bool:
    return verb_base(word) is not None and word not in nouns and singular(word) not in nouns


_ALL = ("all", "every", "each", "everything", "none", "no", "nothing", "both")


def _excepted(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "Every pin but the left one falls", "all fall but the left one": but for it."""
    found = list(tokens)
    words = [token.text for token in tokens]
    for at in (i for i, word in enumerate(words) if word == "but" and i + 1 < len(words)):
        if words[at - 1 : at + 2] == ["all", "but", "one"]:
            # "All but one of the cups": however many that are.
            continue
        said = ("does", "do", "did", "will", "has", "have")
        verbs = [
            i
            for i, word in enumerate(words)
            if _is_verb(word, nouns) or word in v.BE or word in said
        ]
        end = next((i for i in range(at, len(words)) if words[i] in ".,;:!?"), len(words))
        whole = any(word in _ALL for word in words[max(at - 6, 0) : at])
        subject = not any(i < at for i in verbs)
        trailing = not any(at < i < end for i in verbs) and words[at + 1] in v.DETERMINERS
        if whole and (subject or trailing):
            found[at] = replace(tokens[at], text="except")
    return tuple(found)
