"""The annotations in tests/annotations: they fit the pictures of their cases."""

from __future__ import annotations

from pathlib import Path

from physagent_studio.exchange import annotated, load_case


def test_each_annotation_fits_its_case(cases_dir: Path, repository: Path):
    notes = sorted((repository / "tests" / "annotations").glob("*.yaml"))
    assert notes
    for folder in (cases_dir / path.stem for path in notes):
        case = load_case(folder)
        noted = annotated(case, repository / "tests" / "annotations" / f"{folder.name}.yaml")
        assert noted.horizon is not None
        assert noted.scale.reference in dict(case.objects)
        assert (noted.prompt, noted.events) == (case.prompt, case.events)
        boxes = {name: grounding.box for name, grounding in noted.objects}
        for name, grounding in noted.objects:
            box = boxes[name]
            assert box is not None
            inside = [c for c in grounding.points if c.label]
            assert all(box[0] <= c.x <= box[2] and box[1] <= c.y <= box[3] for c in inside)


def test_no_annotation_is_left_without_its_case(cases_dir: Path, repository: Path):
    noted = {path.stem for path in (repository / "tests" / "annotations").glob("*.yaml")}
    assert noted <= {path.parent.name for path in cases_dir.glob("*/case.yaml")}
