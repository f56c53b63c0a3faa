"""What the photo's tools do: ask the finder, or post one group of edits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from physagent_studio.errors import InputError
from physagent_studio.program import Edit, apply
from physagent_studio.reconstruction.grounding.similar_things import covered, similar
from physagent_studio.records import Case, Image, ShapeOffer
from physagent_studio.studio.desk_apart import LOOKING
from physagent_studio.studio.first_scene import marked, unwritten
from physagent_studio.studio.guesses import disproved
from physagent_studio.studio.intents import photo as intents_photo
from physagent_studio.workbench import Snapshot, commands, photo_edits

if TYPE_CHECKING:
    from physagent_studio.studio.commands.actions import Studio


def find_masks(intent: intents_photo.FindMasks, studio: Studio, browser: int) -> None:
    """Looks for the candidate masks; the page hears of them on `masks`."""
    case, image = _photo(studio.snapshot)
    name, grounding = intent.name, intent.grounding
    scene = marked(studio.snapshot)
    desk, shown = studio.photo_desk, studio.snapshot.scene
    out = {name, *disproved(scene, shown, name, grounding)}
    said = [(item.name, item.grounding) for item in scene.objects if item.name not in out]

    def find(*, whole: bool) -> dict[str, Any]:
        photo_edits.check_grounding(case, name, grounding)
        stop = partial(studio.finder.overtaken, browser, "masks") if whole else None
        return desk.masks(image, name, [*said, (name, grounding)], shown, whole, stop, early)

    def early(found: dict[str, Any]) -> None:
        studio.finder.tell_early(browser, "masks", intent.ticket, found)

    studio.finder.ask(
        browser, "masks", intent.ticket, partial(find, whole=False), partial(find, whole=True)
    )


def find_edge(intent: intents_photo.FindEdge, studio: Studio, browser: int) -> None:
    """Looks for the way along edges; the page hears of it on `edge`."""
    _, image = _photo(studio.snapshot)
    desk, start, end = studio.photo_desk, intent.start, intent.end
    studio.finder.ask(browser, "edge", intent.ticket, lambda: desk.way(image, start, end))


def take_mask(intent: intents_photo.TakeMask, studio: Studio, browser: int) -> None:
    """Takes a mask over into the program."""
    case, _ = _photo(studio.snapshot)
    name, grounding = intent.name, intent.grounding

    def edits_of(s: Snapshot) -> tuple[Edit, ...]:
        wrong = disproved(s.program.scene, s.scene, name, grounding)
        if wrong:
            _ask_for(studio, browser, name, sorted(wrong))
        return photo_edits.mask_edits(
            s.program, case, s.state.pinned, name, grounding, layer=intent.layer, wrong=wrong
        )

    _post(studio, edits_of, f"mask of {name}")


def _ask_for(studio: Studio, browser: int, name: str, wrong: list[str]) -> None:
    """Asks for the first of the things whose place another has taken."""
    spoken, other = name.replace("_", " "), wrong[0].replace("_", " ")
    text = f"The words had found {other} where {spoken} is: mark {other} as well."
    choose = {"do": "select", "kind": "object", "name": wrong[0]}
    studio.say(browser, "info", text, (f"Choose {other}", choose))


def find_alike(intent: intents_photo.FindAlike, studio: Studio, browser: int) -> None:
    """Looks for unmarked things like a marked one; the page hears of them on `like`."""
    _, image = _photo(studio.snapshot)
    scene, name = studio.snapshot.scene, intent.name
    named = {item.name for item in studio.snapshot.program.scene.objects}
    masks = {} if scene is None else {n: m for n, m in scene.masks.items() if n in named}

    def find() -> dict[str, Any]:
        if name:
            same = studio.apart.submit(similar, image, name, masks, limits=LOOKING)
            return {"name": name, "found": {name: same}}
        if scene is None or scene.plate is None:
            return {"name": "", "found": {}}
        found = studio.apart.submit(covered, image, scene.plate, masks, limits=LOOKING)
        return {"name": "", "found": found}

    studio.finder.ask(browser, "like", intent.ticket, find)


def mark_alike(intent: intents_photo.MarkAlike, studio: Studio, browser: int) -> None:
    """Marks things in boxes, each a thing of its own, as one step of undo."""
    case, _ = _photo(studio.snapshot)

    def edits_of(s: Snapshot) -> tuple[Edit, ...]:
        return photo_edits.alike_edits(s.program, case, s.state.pinned, intent.name, intent.boxes)

    _post(studio, edits_of, f"things like {intent.name}")


def set_horizon(intent: intents_photo.SetHorizon, studio: Studio, browser: int) -> None:
    """Moves the horizon."""
    case, _ = _photo(studio.snapshot)
    _post(
        studio,
        lambda s: photo_edits.horizon_edits(
            s.program, case, s.state.pinned, intent.row, intent.roll
        ),
        "horizon",
    )


def set_size(intent: intents_photo.SetSize, studio: Studio, browser: int) -> None:
    """Sets the size of an object, and with it all metres."""
    case, _ = _photo(studio.snapshot)
    name, metres = intent.name, intent.metres
    _post(
        studio,
        lambda s: photo_edits.size_edits(s.program, case, s.state.pinned, name, metres),
        f"size of {name}",
    )


def place_ramp(intent: intents_photo.PlaceRamp, studio: Studio, browser: int) -> None:
    """Places a ramp."""
    case, _ = _photo(studio.snapshot)
    marks = (intent.toe, intent.foot, intent.top)
    name = intent.name or ""
    _post(
        studio,
        lambda s: photo_edits.ramp_edits(s.program, case, s.state.pinned, name, marks),
        "ramp",
    )


def switch_form(intent: intents_photo.SwitchForm, studio: Studio, browser: int) -> None:
    """Fits another kind of shape."""
    _photo(studio.snapshot)
    name, kind = intent.name, intent.kind
    _post(
        studio,
        lambda s: photo_edits.form_edits(s.program, s.state.pinned, name, kind, _offers(s, name)),
        f"shape of {name}",
    )


def _offers(snapshot: Snapshot, name: str) -> tuple[ShapeOffer, ...]:
    """The shapes that were fitted to an object's mask, best first."""
    return () if snapshot.scene is None else snapshot.scene.shapes.get(name, ())


def _post(studio: Studio, edits_of: Callable[[Snapshot], tuple[Edit, ...]], reason: str) -> None:
    """Checks a group of edits while the person still looks, then has it carried out."""
    snapshot = studio.snapshot
    if unwritten(snapshot):
        if snapshot.busy is None:
            raise InputError(f"the {reason} needs a scene to belong to: press Start to make one")
        # What it changes is being made now.
        studio.once_written(lambda: _post(studio, edits_of, reason))
        return
    if snapshot.read_only:
        raise InputError("an earlier round is open read-only; go on from here to edit it")
    edits = edits_of(snapshot)
    apply(snapshot.program, edits)
    studio.workbench.post(commands.ApplyEdits(edits, reason))


def _photo(snapshot: Snapshot) -> tuple[Case, Image]:
    if snapshot.case is None or snapshot.case.image is None:
        raise InputError("this program has no photo")
    return snapshot.case, snapshot.case.image


ACTIONS: dict[type, Callable[..., None]] = {
    intents_photo.FindMasks: find_masks,
    intents_photo.FindEdge: find_edge,
    intents_photo.FindAlike: find_alike,
    intents_photo.MarkAlike: mark_alike,
    intents_photo.TakeMask: take_mask,
    intents_photo.SetHorizon: set_horizon,
    intents_photo.SetSize: set_size,
    intents_photo.PlaceRamp: place_ramp,
    intents_photo.SwitchForm: switch_form,
}
"""What each intent does."""
