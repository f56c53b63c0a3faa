"""Reference contracts: what a prompt demands, written by hand, held against a final rollout."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml
from pydantic import ValidationError

from physagent_studio.contract import measure
from physagent_studio.errors import InputError
from physagent_studio.program.contract import Contract, Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records import Check, Rollout

_PLACES = ("other", "landmark", "near", "before", "toward")
"""Fields of statements that name an object, a support or a landmark."""


@dataclass(frozen=True, slots=True)
class Reference:
    """The verdict of a reference contract on one rollout.

    checks: its statements measured. missing: names that it speaks of and the scene lacks; with
    one of them it cannot be tested and does not hold.
    """

    checks: tuple[Check, ...]
    missing: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every demanded statement was tested and holds."""
        return not self.missing and all(check.ok for check in self.checks if check.demanded)

    @property
    def failing(self) -> tuple[str, ...]:
        """Sentences about what does not hold."""
        absent = tuple(f"the scene has no '{name}'" for name in self.missing)
        return absent + tuple(c.text for c in self.checks if c.demanded and not c.ok)


def reference_path(references: Path, case: str, event: str) -> Path | None:
    """The file of an event's reference contract; None where there is none."""
    path = references / f"{case}__{event}.yaml"
    return path if path.is_file() else None


def load_reference(path: Path) -> Contract:
    """The contract of a reference file; raises InputError where it is not one."""
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        return Contract.model_validate(data["contract"])
    except (OSError, yaml.YAMLError, ValidationError, KeyError, TypeError) as error:
        raise InputError(f"{path} is no reference contract: {error}") from error


def judge(reference: Contract, program: PhysicalProgram, rollout: Rollout) -> Reference:
    """The reference contract, measured on the rollout of `program`."""
    missing = tuple(dict.fromkeys(_missing(reference, program)))
    held = program.model_copy(update={"contract": reference})
    checks = () if missing else measure(held, rollout)
    return Reference(tuple(check for check in checks if not check.always_on), missing)


def _missing(reference: Contract, program: PhysicalProgram) -> Iterator[str]:
    scene = program.scene
    objects = {item.name for item in scene.objects}
    places = objects | {s.name for s in scene.supports} | {m.name for m in scene.landmarks}
    for statement in reference.statements:
        subject = getattr(statement, "subject", None)
        if subject is not None and subject not in objects:
            yield subject
        yield from (name for name in _named(statement) if name not in places)


def _named(statement: Statement) -> Iterator[str]:
    for field in _PLACES:
        name = getattr(statement, field, None)
        if isinstance(name, str):
            yield name
