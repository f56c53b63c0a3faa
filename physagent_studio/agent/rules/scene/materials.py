"""What things are made of, by their name and the adjectives the prompt gives them."""

from __future__ import annotations

import re

from physagent_studio.language.tokens.tokens import singular
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.scene.materials import MATERIALS

_WORDS: dict[str, str] = {
    "wood": "wood wooden stool chair bench crate barrel block domino jenga plank table desk shelf"
    " board house cabin ladder tree trunk log branch pencil chess",
    "metal": "metal metallic steel iron scooter bike bicycle motorcycle motorbike can bell coin"
    " key pot pan kettle lamp knife fork spoon hammer trashcan trash bin bucket car truck robot",
    "rubber": "rubber tire tyre puck duck bowling eraser bouncy basketball",
    "ice": "ice icy frozen icecube iceberg",
    "glass": "glass bottle vase jar window crystal marble goblet acrylic",
    "plastic": "plastic toy lego cup frisbee dice die pin balloon doll figurine conveyor",
    "stone": "stone rock boulder pebble brick statue granite curling",
    "foam": "foam sponge styrofoam polystyrene pillow cushion mattress",
    "paper": "paper book notebook magazine newspaper card dictionary envelope plane",
    "ceramic": "ceramic plate mug bowl teapot teacup porcelain flowerpot",
    "clay": "clay mud dough plasticine",
    "fruit": "fruit apple orange persimmon pumpkin lemon lime peach pear melon watermelon tomato"
    " potato onion egg banana strawberry cake bread plum cherry",
    "snow": "snow snowman snowball",
    "cardboard": "cardboard box carton package parcel",
    "leather": "soccer football volleyball handball baseball tennis",
    "fabric": "fabric cloth suit shirt dress coat jacket clothes costume flag curtain towel sock"
    " blanket teddy plush hat bag sail laundry garment",
    "grass": "grass lawn field pitch turf",
    "carpet": "carpet rug mat",
    "concrete": "concrete road street pavement asphalt",
}
_BY_WORD: dict[str, str] = {
    word: material for material, words in _WORDS.items() for word in words.split()
}
_HOLLOW: dict[str, float] = {
    word: density
    for density, words in (
        (25.0, "balloon"),
        (90.0, "trash trashcan bin bucket basket tent umbrella lampshade lantern"),
        (
            180.0,
            "can cup mug pot pan kettle vase jar bowl drum suitcase helmet",
        ),
        (250.0, "stool chair bench car truck motorcycle motorbike train robot lamp crate"),
        (600.0, "scooter bike bicycle ladder"),
        (400.0, "toy doll figurine duck teapot bottle barrel house tree plant"),
    )
    for word in words.split()
}
"""Mean density, kg/m³, of what is mostly air inside its outline: empty vessels, frames, shells.

An open vessel whose walls are modelled weighs as its material does."""
_SPECIFIC = frozenset(MATERIALS) | words_of("wooden metallic steel iron icy frozen acrylic")


_TINTS = words_of("orange lime peach plum cherry lemon melon")
_FOOD = words_of("slice half piece peel fruit cake pie tree juice pulp seed stone")


def _is_tint(after: list[str]) -> bool:
    """Whether a fruit before these words is only a colour: an orange ring, but an orange slice."""
    after = [word for word in after if len(word) > 1]
    return bool(after) and not any(word in _FOOD for word in after)


def material_of(name: str, prompt: str, default: str = "plastic") -> str:
    """The row of the materials table for a thing of that name, as the prompt describes it."""
    words = [singular(word) for word in re.findall(r"[a-z]+", name.lower())]
    said = _described(words, prompt)
    toy = ["toy"] if "toy" in words else []
    nouns = [w for k, w in enumerate(words) if w not in _TINTS or not _is_tint(words[k + 1 :])]
    for word in (*[w for w in words if w in _SPECIFIC], *said, *toy, *reversed(nouns)):
        if word in _BY_WORD:
            return _BY_WORD[word]
    return default


def density_of(name: str) -> float | None:
    """Mean density of a thing that is hollow or a frame; None where it is solid."""
    words = [singular(word) for word in re.findall(r"[a-z]+", name.lower())]
    found = [_HOLLOW[word] for word in words if word in _HOLLOW]
    return min(found) if found and "sand" not in words else None


def _described(words: list[str], prompt: str) -> list[str]:
    """Material adjectives, and kinds of ball or stone, said right before the name's noun."""
    text = [singular(word) for word in re.findall(r"[a-z]+", prompt.lower())]
    found: list[str] = []
    for index, word in enumerate(text):
        if word == words[-1]:
            before = text[max(0, index - 3) : index]
            found += [w for w in reversed(before) if w in _SPECIFIC or w in ("curling", "soccer")]
    return found


def is_sheet(name: str) -> bool:
    """Whether a thing of that name is a cloth."""
    return material_of(name, "") == "fabric" and not {"teddy", "plush", "bag", "hat"} & set(
        name.lower().split("_")
    )


def is_flag(name: str) -> bool:
    """Whether it is a cloth that is held along one side."""
    return bool({"flag", "pennant", "ensign"} & set(name.lower().split("_")))


def is_loose(name: str) -> bool:
    """Whether it is made of grains."""
    loose = words_of("sand sandcastle gravel dirt soil rice sugar salt grain")
    return any(word in loose for word in name.lower().split("_"))
