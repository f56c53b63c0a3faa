"""Words with their places in the prompt, and their base forms."""

import re
from dataclasses import dataclass

from physagent_studio.knowledge import word_lists
from physagent_studio.language.tokens import vocabulary as v

_WORD = re.compile(
    r"(?:k|c)?m/(?:s|h)\b|[A-Za-z]+(?:'[a-z]+)?|\d+(?:\.\d+)?|[.,;:!?()]|[^\sA-Za-z\d]"
)


@dataclass(frozen=True, slots=True)
class Token:
    """A word as written, lower case, with its span of characters in the prompt."""

    text: str
    start: int
    end: int


def tokenise(prompt: str) -> tuple[Token, ...]:
    """Words, numbers and punctuation in order; hyphens and dashes separate words."""
    tokens: list[Token] = []
    for match in _WORD.finditer(prompt):
        text = match.group().lower().replace("’", "'")
        if text in "-–—_/":
            continue
        text = "degrees" if text == "°" else text
        if text.endswith("n't") and len(text) > 3:
            cut = match.end() - 3
            stem = "can" if text == "can't" else text[:-3]
            tokens += [Token(stem, match.start(), cut), Token("not", cut, match.end())]
            continue
        if text in _UNMARKED:
            # "Doesnt": the apostrophe forgotten.
            cut = match.end() - 2
            stem = "can" if text == "cant" else text[:-2]
            tokens += [Token(stem, match.start(), cut), Token("not", cut, match.end())]
            continue
        tokens.append(Token(text.removesuffix("'s"), match.start(), match.end()))
    return tuple(tokens)


_UNMARKED = v.words_of(
    "doesnt dont didnt isnt arent wasnt werent hasnt havent wouldnt shouldnt couldnt cant"
)


def verb_base(word: str) -> str | None:
    """The base form of a known verb, or None."""
    if word in v.VERBS:
        return word
    if word in v.IRREGULAR and v.IRREGULAR[word] in v.VERBS:
        return v.IRREGULAR[word]
    return next((base for base in _stems(word) if base in v.VERBS), None)


def looks_like_verb(word: str) -> bool:
    """Whether an unknown word has the ending of an inflected verb."""
    return len(word) > 4 and word.endswith(("ing", "ed"))


def _stems(word: str) -> list[str]:
    stems: list[str] = []
    if word.endswith("ies") and len(word) > 4:
        stems.append(word[:-3] + "y")
    if word.endswith("ied") and len(word) > 4:
        stems.append(word[:-3] + "y")
    for ending in ("ing", "ed", "es", "s"):
        if word.endswith(ending) and len(word) > len(ending) + 1:
            stem = word[: -len(ending)]
            stems += [stem, stem + "e"]
            if len(stem) > 2 and stem[-1] == stem[-2]:
                stems.append(stem[:-1])
    return stems


def singular(word: str) -> str:
    """The singular of a regular noun; a word that is no plural comes back unchanged."""
    if word in word_lists().singulars:
        return word
    if word in word_lists().plurals:
        return word_lists().plurals[word]
    if word.endswith("ies") and len(word) > 4:
        return word[:-3] + "y"
    if word.endswith(("ches", "shes", "sses", "xes")):
        return word[:-2]
    if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 3:
        return word[:-1]
    return word


def is_number(word: str) -> bool:
    """Whether the word is a number in figures or letters."""
    return word.replace(".", "", 1).isdecimal() or word in v.NUMBERS


def is_participle(word: str) -> bool:
    """Whether the form can be a past participle."""
    return word in v.PARTICIPLES or word.endswith("ed")
