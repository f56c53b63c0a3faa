"""An annotation file: more of what a person would click, laid over a case; never an action."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from physagent_studio.exchange.case_clicks import horizon_of, scale_of
from physagent_studio.exchange.case_reader import CLICKED, MAX_OBJECTS, CaseReader
from physagent_studio.program.scene.state import Grounding, Landmark, Support
from physagent_studio.records.case import Case

Named = TypeVar("Named", Support, Landmark)


def annotated(case: Case, path: Path | str) -> Case:
    """The case with the clicks of an annotation file laid over it.

    The file has the form of case.yaml with `horizon`, `scale`, `objects`, `supports` and
    `landmarks` alone. Clicks on an object of the case are added to its own, a box replaces its
    box; a support or a landmark of the same name gains the marks, or is replaced.

    Raises:
        InputError: in one sentence, with file and line: what is wrong and what is allowed.
    """
    assert case.image is not None, "only a case with a photo can be clicked on"
    size = (case.image.shape[1], case.image.shape[0])
    reader = CaseReader(Path(path), CLICKED)
    objects = _objects(reader, case, size)
    supports = _over(case.supports, tuple(_on(case, s) for s in reader.supports(size)))
    names = [*(name for name, _ in objects), *(support.name for support in supports)]
    landmarks = _over(case.landmarks, reader.landmarks(size, names))
    reader.check_names()
    _check_unique(reader, (*names, *(landmark.name for landmark in landmarks)))
    scale = scale_of(reader, [name for name, _ in objects])
    horizon = horizon_of(reader, size)
    return replace(
        case,
        objects=objects,
        supports=supports,
        landmarks=landmarks,
        horizon=case.horizon if horizon is None else horizon.row,
        roll=case.roll if horizon is None else horizon.roll,
        scale=case.scale if scale.metres is None else scale,
    )


def _objects(
    reader: CaseReader, case: Case, size: tuple[int, int]
) -> tuple[tuple[str, Grounding], ...]:
    known = dict(case.objects)
    for name, place, entry in reader.things("objects", MAX_OBJECTS):
        reader.known(place, entry, ("points", "box"))
        if name not in known:
            listed = ", ".join(known)
            raise reader.fail(place, f"the case has no object '{name}' (known: {listed})")
        more = reader.grounding(place, entry, size)
        before = known[name]
        known[name] = before.model_copy(
            update={"points": (*before.points, *more.points), "box": more.box or before.box}
        )
    return tuple(known.items())


def _on(case: Case, support: Support) -> Support:
    """The support with the clicks that the case has for it already."""
    before = next((item for item in case.supports if item.name == support.name), None)
    if before is None:
        return support
    new = support.grounding
    grounding = before.grounding.model_copy(
        update={
            "points": (*before.grounding.points, *new.points),
            "box": new.box or before.grounding.box,
            "marks": new.marks or before.grounding.marks,
        }
    )
    shape = support.shape if support.shape is not None else before.shape
    return before.model_copy(update={"grounding": grounding, "shape": shape})


def _check_unique(reader: CaseReader, names: Sequence[str]) -> None:
    for name, place in reader.names.items():
        if names.count(name) > 1:
            raise reader.fail(place, f"the case has something else that is called '{name}'")


def _over(below: tuple[Named, ...], above: tuple[Named, ...]) -> tuple[Named, ...]:
    """Both, in order; where a name is in both, the upper one."""
    merged = {item.name: item for item in below} | {item.name: item for item in above}
    return tuple(merged.values())
