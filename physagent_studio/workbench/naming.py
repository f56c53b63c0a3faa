"""Things that nobody clicked: found by the words of the sentence, used where they are clear."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from physagent_studio.errors import InputError, Unclear
from physagent_studio.exchange import case_from_image
from physagent_studio.language.sought import Sought, slopes_in, sought_by, things_in
from physagent_studio.program import Click, Grounding
from physagent_studio.reconstruction import reduction_of
from physagent_studio.reconstruction.grounding.proposals import Proposed, Spot, propose
from physagent_studio.records import Case, Image
from physagent_studio.workbench.bearers import with_supports

Seek = Callable[[Image, list[Sought]], Sequence[Proposed]]
"""Looks for things in a photo: `propose`, or the same in another process."""


def case_in_words(
    path: Path,
    prompt: str,
    marks: Mapping[str, Grounding],
    *,
    ask: bool = True,
    seek: Seek = propose,
) -> Case:
    """A case from a photo and a sentence; names without a mark are looked for in the photo.

    Without any name, the things that the sentence speaks of are looked for. Raises Unclear with
    the places that come into question (unless `ask` is False), InputError where the sentence
    names nothing.
    """
    if not ask:
        # A slope that was offered and not marked is read off the picture with what stands on it.
        open_ones = {name for name in slopes_in(prompt) if not _is_marked(marks.get(name))}
        marks = {name: said for name, said in marks.items() if name not in open_ones}
    names = list(marks) or [item.name for item in things_in(prompt)]
    if not names:
        option = ", or say where it is with --object name@x,y" if ask else ""
        raise InputError(
            "the sentence names nothing that could be found in the photo (it is read as English);"
            f" click a thing in it and name it{option}"
        )
    marked = {name: said for name, said in marks.items() if _is_marked(said)}
    if all(name in marked for name in names):
        return with_supports(case_from_image(path, prompt, marked))
    # Any click of its own does until the real one is known; the photo is read and checked by then.
    said = {name: marked.get(name) or Grounding(points=(Click(x=0.001 * (at + 0.5), y=0),))
            for at, name in enumerate(names)}  # fmt: skip
    case = case_from_image(path, prompt, said)
    sought = tuple(
        (name, grounding if given in marked else Grounding())
        for given, (name, grounding) in zip(names, case.objects, strict=True)
    )
    found = with_proposals(
        replace(case, objects=sought), ask=ask, per=reduction_of(path), seek=seek
    )
    return with_supports(found)


def _is_marked(said: Grounding | None) -> bool:
    return said is not None and (bool(said.points) or said.box is not None)


def names_in(prompt: str) -> tuple[str, ...]:
    """Names of the things that a sentence speaks of, in its order, then of what they go down."""
    return tuple(dict.fromkeys((*(item.name for item in things_in(prompt)), *slopes_in(prompt))))


def with_proposals(case: Case, *, ask: bool = True, per: int = 1, seek: Seek = propose) -> Case:
    """The case with its unclicked objects found by their words, marked as proposals.

    ask: raise Unclear where a place is not clear; otherwise the likeliest is taken. per: pixels of
    the file for one of the case, along each side; what is said is in those of the file. Raises
    InputError for a thing for which nothing stands out.
    """
    names = [name for name, grounding in case.objects if not grounding.shows_something]
    if not names or case.image is None:
        return case
    wanted = [sought_by(name, case.prompt) for name in names]
    found = {one.name: one for one in seek(case.image, wanted)}
    unclear = [one for one in found.values() if not (one.spots if not ask else one.clear)]
    if unclear:
        kind = Unclear if all(one.spots for one in unclear) else InputError
        raise kind(_question(unclear, [one for one in found.values() if one.clear], per))
    objects = tuple(
        (name, _grounded(found[name]) if name in found else grounding)
        for name, grounding in case.objects
    )
    return replace(case, objects=objects)


def _grounded(one: Proposed) -> Grounding:
    spot = one.spots[0]
    return Grounding(points=(Click(x=spot.x, y=spot.y),), proposed=True)


def _question(unclear: Sequence[Proposed], clear: Sequence[Proposed], per: int = 1) -> str:
    """One sentence: what is not clear, and where each thing may be, likeliest first."""
    parts = []
    for one in unclear:
        places = ", ".join(_place(one.name, spot, per) for spot in one.spots)
        parts.append(f"{one.name} ({places or 'nothing stands out for it'})")
    known = ", ".join(_place(one.name, one.spots[0], per) for one in clear)
    also = f"; clear: {known}" if known else ""
    return (
        f"where it is in the photo is not clear from words alone: {'; '.join(parts)}{also};"
        " say it with --object name@x,y, or click it in the studio"
    )


def _place(name: str, spot: Spot, per: int) -> str:
    return f"{name}@{spot.x * per:.0f},{spot.y * per:.0f}"
