"""Repairs of the reconstruction: the factor that a failed finding names, alone, without a run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.factors import may_change
from physagent_studio.agent.rules.planner.wording import proposal
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.verifier.verifier import shortfall
from physagent_studio.contract.view import COVERS
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.program.edits import Edit, SetField, apply
from physagent_studio.program.scene.state import SceneObject, Slab
from physagent_studio.reconstruction.photo.colours import colour_of, places_of
from physagent_studio.reconstruction.placement.static_stability import beyond
from physagent_studio.records import Finding, Proposal, Scene

Repair = tuple[str, str, tuple[Edit, ...]]


def repair_scene(situation: Situation) -> Proposal:
    """The first untried repair of the worst failed finding, or a question."""
    failing = _failing(situation)
    max_looks = 9  # count, 1..20: reconstructions of a first proposal; none of them is simulated
    least_looks = 2  # count, 1..6: of later ones, that are worth less and less
    left = max(int(max_looks / (1 + 0.5 * len(situation.memory.entries))), least_looks)
    for finding in failing:
        fresh = [row for row in _repairs(finding, situation) if _is_fresh(situation, row[2])]
        chosen, left = _best(situation, fresh[:left]), left - len(fresh[:left])
        if chosen is not None:
            factor, words, edits = chosen
            why = f"Because {finding.text}: {words}."
            return proposal(
                situation.program, why, edits, summary=words, factor=factor, confidence=0.5
            )
    for finding in failing:
        last = _last_resort(finding, situation)
        if last is not None and _is_fresh(situation, last[2]):
            factor, words, edits = last
            why = f"Because {finding.text}, and nothing else is left to try: {words}."
            return proposal(
                situation.program, why, edits, summary=words, factor=factor, confidence=0.3
            )
    worst = failing[0] if failing else None
    about = worst.subject if worst is not None else "the picture"
    text = worst.text if worst is not None else _unmeasured(situation)
    item = situation.program.scene.object(about)
    boxed = item is not None and item.grounding.box is not None
    helps = (
        f"click on what is missing of {about}" if boxed else f"click inside {about}, or draw a box"
    )
    asked = f"{text[0].upper()}{text[1:]}. Can you {helps}?"
    return proposal(situation.program, f"nothing is left to try: {text}", question=asked)


def _last_resort(finding: Finding, situation: Situation) -> Repair | None:
    """A thing's outline cut out of a board, which stands where it is seen; then it is doubted.

    Only of what a person drew a box around, and of what nothing is demanded of.
    """
    name = finding.subject
    item = situation.program.scene.object(name)
    if item is None or item.form == "board" or finding.name == "mask":
        return None
    statements = situation.program.contract.statements
    demanded = any(name in statement.model_dump().values() for statement in statements)
    if demanded and item.grounding.box is None:
        return None
    base = f"scene.objects.{name}"
    edits = [SetField(path=f"{base}.form", value="board")]
    edits += [SetField(path=f"{base}.{field}", value=None) for field in ("shape", "position")]
    return "primitive", f"take a board with its outline for {name}", tuple(edits)


def repair_likeness(situation: Situation) -> Proposal | None:
    """Another kind of shape, or another mask, for what is not drawn as the photograph shows it.

    Of the kinds that cover the mask well enough the likeliest one; where none does, the next mask
    that one of them covers. No schedule mends that. None where there is neither.
    """
    for mismatch in situation.assessment.diagnosis:
        item = situation.program.scene.object(mismatch.subject)
        if mismatch.code != "unlike_the_photo" or item is None:
            continue
        repairs = chain(
            _other_shapes(situation, item),
            _other_masks(situation, item.name, f"scene.objects.{item.name}"),
        )
        fresh = (row for row in repairs if _is_fresh(situation, row[2]))
        found = next((row for row in fresh if _is_covered(situation, item.name, row)), None)
        if found is not None:
            factor, words, edits = found
            why = f"Because {mismatch.text}: {words}."
            return proposal(
                situation.program, why, edits, summary=words, factor=factor, confidence=0.5
            )
    return None


def _other_shapes(situation: Situation, item: SceneObject) -> Iterator[Repair]:
    """Kinds of shape, the likeliest first, that cover an object's mask."""
    now = item.shape.kind if item.shape is not None else item.form
    base = f"scene.objects.{item.name}"
    offers = situation.scene.shapes.get(item.name, ()) if situation.scene is not None else ()
    for offer in offers:
        if offer.kind != now and offer.iou >= COVERS:
            yield (
                "primitive",
                f"take {offer.kind} for the shape of {item.name}",
                (
                    SetField(path=f"{base}.form", value=offer.kind),
                    SetField(path=f"{base}.shape", value=None),
                    SetField(path=f"{base}.position", value=None),
                ),
            )


def _is_covered(situation: Situation, name: str, repair: Repair) -> bool:
    """Whether some kind of shape covers an object's mask then; another mask is looked at first."""
    if repair[0] == "primitive":
        return True
    scene = _looked_at(situation, repair)
    offers = scene.shapes.get(name, ()) if scene is not None else ()
    return any(offer.iou >= COVERS for offer in offers)


def _looked_at(situation: Situation, repair: Repair) -> Scene | None:
    """The scene after a repair; None where nothing can be looked at, or it cannot be made."""
    if situation.look is None:
        return None
    try:
        return situation.look(apply(situation.program, repair[2]).scene)
    except Cancelled:
        raise
    except StudioError:
        return None


def _unmeasured(situation: Situation) -> str:
    """Why a scene in which nothing measured fails does not pass."""
    words = situation.memory.hints[-1:]
    if not situation.assessment.passed:
        return "the scene is not resolved"
    said = f", but you said “{words[0]}”" if words else ", but you said that it does not"
    return f"by every measurement the scene fits the photo{said}"


def _best(situation: Situation, repairs: list[Repair]) -> Repair | None:
    """The repair after which the scene fails least, if it fails less than now; the first where
    nothing can be looked at."""
    if situation.look is None or situation.scene is None:
        return repairs[0] if repairs else None
    best, least = None, shortfall(situation.scene) - 1e-6
    for repair in repairs:
        scene = _looked_at(situation, repair)
        if scene is not None and shortfall(scene) < least:
            best, least = repair, shortfall(scene)
    return best


def _failing(situation: Situation) -> list[Finding]:
    """The findings that the verdict is about, the worst first."""
    scene = situation.scene
    wrong = {m.check for m in situation.assessment.diagnosis}
    found = [f for f in scene.findings if not f.ok] if scene is not None else []
    demanded = [f for f in found if f"{f.kind}.{f.name}.{f.subject}" in wrong]
    margins = {c.id: c.margin for c in situation.assessment.checks}
    return sorted(
        demanded or found, key=lambda f: margins.get(f"{f.kind}.{f.name}.{f.subject}", 0.0)
    )


def _is_fresh(situation: Situation, edits: tuple[Edit, ...]) -> bool:
    if not may_change(situation, edits):
        return False
    rejected = [proposal.edits for proposal, _ in situation.memory.rejected]
    made = [entry.edits for entry in situation.memory.entries]
    if edits in rejected or edits in made:
        return False
    try:
        changed = apply(situation.program, edits)
    except StudioError:
        return False
    return changed.hash not in (situation.program.hash, *situation.memory.tried)


def _repairs(finding: Finding, situation: Situation) -> Iterator[tuple[str, str, tuple[Edit, ...]]]:
    """(factor, words, edits) for a finding, the likeliest first."""
    program, name = situation.program, finding.subject
    item = program.scene.object(name)
    if item is not None and finding.kind in ("points", "mask", "geometry"):
        base = f"scene.objects.{name}"
        if finding.kind == "points":
            yield from _other_clicks(situation, name, base)
        yield from _other_masks(situation, name, base)
        again = (
            SetField(path=f"{base}.shape", value=None),
            SetField(path=f"{base}.position", value=None),
        )
        yield "primitive", f"fit the shape of {name} again", again
    if item is not None and finding.kind in ("placement", "geometry", "support"):
        base = f"scene.objects.{name}"
        if finding.kind != "support":
            again = (SetField(path=f"{base}.position", value=None),)
            yield "placement", f"place {name} again", again
        # How large a thing is follows from how far away it stands.
        fields = ("shape", "position", "support")
        anew = tuple(SetField(path=f"{base}.{field}", value=None) for field in fields)
        yield "support", f"find anew what {name} stands on", anew
        if finding.name == "edge":
            yield from _moved_in(situation, name)
    if program.scene.support(name) is not None:
        path = f"scene.supports.{name}.shape"
        yield "support", f"find {name} again", (SetField(path=path, value=None),)
    if finding.kind == "camera":
        yield from _cameras(situation)


def _moved_in(situation: Situation, name: str) -> Iterator[Repair]:
    """Over the support whose edge it is seen beyond, with all that stands on it."""
    scene = situation.scene
    item = scene.state.object(name) if scene is not None else None
    support = scene.state.support(item.support or "") if scene is not None and item else None
    if scene is None or item is None or support is None or not isinstance(support.shape, Slab):
        return
    step = beyond(item, scene.meshes[name], support.shape)
    moved, edits = (name, *Layout(scene.state).above(name)), []
    for one in scene.state.objects:
        if one.name in moved and one.position is not None:
            x, y, z = one.position
            x, y = (round(at + float(by), 6) for at, by in zip((x, y), step, strict=True))
            edits.append(SetField(path=f"scene.objects.{one.name}.position", value=[x, y, z]))
    yield "placement", f"move {name} onto {support.name}", tuple(edits)


def _other_clicks(
    situation: Situation, name: str, base: str
) -> Iterator[tuple[str, str, tuple[Edit, ...]]]:
    """Places in the picture that have the colour of the name and that nothing else has taken."""
    scene, word = situation.scene, colour_of(name)
    item = situation.program.scene.object(name)
    if scene is None or scene.photo is None or word is None or item is None:
        return
    if item.grounding.settled or item.grounding.box is not None:
        return
    others = [mask for other, mask in scene.masks.items() if other != name]
    taken = np.any(others, axis=0) if others else np.zeros(scene.photo.shape[:2], bool)
    for x, y in places_of(scene.photo, word, taken):
        edits = (
            SetField(path=f"{base}.grounding.points", value=[{"x": x, "y": y, "label": 1}]),
            SetField(path=f"{base}.grounding.candidate", value=0),
            SetField(path=f"{base}.shape", value=None),
            SetField(path=f"{base}.position", value=None),
            SetField(path=f"{base}.support", value=None),
        )
        yield "image points", f"click {name} at ({x:.0f}, {y:.0f}), where it is {word}", edits


def _other_masks(
    situation: Situation, name: str, base: str
) -> Iterator[tuple[str, str, tuple[Edit, ...]]]:
    """The segmenter's other masks, best first, with everything that followed from the mask open.

    A mask that a person has chosen stays, and a box that is drawn around the thing is not left.
    """
    scene = situation.scene
    item = situation.program.scene.object(name)
    assert item is not None
    if item.grounding.settled:
        return
    offers = scene.candidates.get(name, ()) if scene is not None else ()
    count, box = len(offers), item.grounding.box
    tried = _tried_masks(situation, name)
    left = [c for c in range(count) if c not in tried and c != item.grounding.candidate]
    left = [c for c in left if box is None or _within(box, offers[c].mask)]
    best = max(tried, key=lambda c: tried[c], default=None)
    if not left and best is not None and best != item.grounding.candidate:
        # None of them fits: back to the one that came nearest.
        left = [best]
    for candidate in left:
        edits = (
            SetField(path=f"{base}.grounding.candidate", value=candidate),
            SetField(path=f"{base}.shape", value=None),
            SetField(path=f"{base}.position", value=None),
        )
        yield "mask candidate", f"take mask {candidate + 1} of {count} for {name}", edits


def _within(box: tuple[float, float, float, float], mask: NDArray[np.bool_]) -> bool:
    """Whether a mask (H, W) ends about where a box that was drawn around the thing does."""
    x0, y0, x1, y1 = box
    loose_ratio = 0.06  # 0..0.2: of the longer side, by which a hand draws a box too narrow
    wide = loose_ratio * max(x1 - x0, y1 - y0)
    rows, columns = mask.nonzero()
    inside = (rows > y0 - wide) & (rows < y1 + wide) & (columns > x0 - wide) & (columns < x1 + wide)
    most_share = 0.02  # 0..0.1: of a mask, that may lie outside all the same
    return bool(np.count_nonzero(~inside) <= most_share * len(rows))


def _tried_masks(situation: Situation, name: str) -> dict[int, float]:
    """How well each mask that was tried for an object fitted, by its number."""
    item = situation.program.scene.object(name)
    check = f"mask.reprojection.{name}"
    found: dict[int, float] = {}
    path = f"scene.objects.{name}.grounding.candidate"
    for number, entry in enumerate(situation.memory.entries):
        chosen = [e.value for e in entry.edits if isinstance(e, SetField) and e.path == path]
        if number == 0 or not found:
            found.setdefault(0, entry.margins_before.get(check, -1.0))
        if chosen and isinstance(chosen[0], int):
            found[chosen[0]] = entry.margins_after.get(check, -1.0)
    if item is not None:
        now = {c.id: c.margin for c in situation.assessment.checks}
        found[item.grounding.candidate] = now.get(check, -1.0)
    return found


def _cameras(situation: Situation) -> Iterator[tuple[str, str, tuple[Edit, ...]]]:
    """The picture's own horizon where one was stated, then horizons a few percent of the picture
    higher and lower; with the geometry open again."""
    scene = situation.program.scene
    camera = scene.camera
    if camera is None:
        return
    opened: list[Edit] = [SetField(path="scene.camera", value=None)]
    for item in scene.objects:
        opened.append(SetField(path=f"scene.objects.{item.name}.position", value=None))
        opened.append(SetField(path=f"scene.objects.{item.name}.shape", value=None))
    for support in scene.supports:
        opened.append(SetField(path=f"scene.supports.{support.name}.shape", value=None))
    if camera.source == "given":
        own = SetField(path="scene.horizon", value=None)
        yield "camera", "take the horizon that the picture shows", (own, *opened)
    rows = camera.size[1]
    for share in (-0.08, 0.08, -0.16, 0.16):
        row = SetField(path="scene.horizon", value=round(camera.horizon + share * rows, 1))
        way = "higher" if share < 0 else "lower"
        words = f"put the horizon {abs(share):.0%} of the picture {way}"
        yield "camera", words, (row, *opened)
