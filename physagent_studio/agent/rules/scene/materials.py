"""What things are made of, by their name and the adjectives the prompt gives them."""

import re
from collections.abc import Sequence

from physagent_studio.knowledge import kind_of, kinds_in, material_words, word_lists
from physagent_studio.language.hints import called
from physagent_studio.language.tokens.tokens import singular
from physagent_studio.program.scene.state import SceneObject


def made_of(name: str, prompt: str) -> str | None:
    """The row of the materials table for a thing of that name, as the prompt describes it.

    None where neither its name nor an adjective says it.
    """
    own = [singular(word) for word in re.findall(r"[a-z]+", name.lower())]
    table = material_words()
    for word in (*own, *_adjectives(own, prompt)):
        if word in table:
            return table[word]
    kind = kind_of(called(name, prompt))
    meant = (word_lists().meant[word] for word in own[:-1] if word in word_lists().meant)
    return next(meant, None if kind is None else kind.material)


def material_of(name: str, prompt: str) -> str:
    """The same, and the material that an object has by itself where nothing says it."""
    return made_of(name, prompt) or SceneObject.model_fields["material"].default


def ground_material(prompt: str, ground: str) -> str:
    """What the ground is made of: what is played on it, or the word that the prompt has for it."""
    said = kinds_in(prompt)
    played = next((kind.ground for kind, _ in said if kind.ground is not None), None)
    word = next((word for kind, word in said if kind.support == "floor"), ground)
    return played or material_of(word, prompt)


def unknown(name: str, prompt: str) -> str | None:
    """What is assumed of a thing of which its name and the prompt say nothing."""
    if kind_of(name) is not None or made_of(name, prompt) is not None:
        return None
    return f"what {name} is made of is not known; taken as {material_of(name, prompt)}"


def _adjectives(own: Sequence[str], prompt: str) -> list[str]:
    """Words said right before the name's noun, the nearest first."""
    text = [singular(word) for word in re.findall(r"[a-z]+", prompt.lower())]
    found: list[str] = []
    max_adjectives = 3  # words, 1..5: before a noun: "the small red wooden box"
    for index, word in enumerate(text):
        if own and word == own[-1]:
            found += reversed(text[max(0, index - max_adjectives) : index])
    return found
