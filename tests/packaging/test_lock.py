"""The lock pins everything that the package needs, within what pyproject.toml allows."""

import re
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

LINE = re.compile(r"^([A-Za-z0-9._-]+)==(\S+)(?: ; (.+?))? \\$")


@pytest.fixture(scope="module")
def lock(repository: Path) -> str:
    return (repository / "requirements.lock").read_text()


def _pins(lock: str) -> dict[str, list[Requirement]]:
    found: dict[str, list[Requirement]] = {}
    for line in lock.splitlines():
        if line and not line.startswith((" ", "#")):
            assert LINE.match(line), line
            one = Requirement(line.removesuffix(" \\"))
            found.setdefault(canonicalize_name(one.name), []).append(one)
    return found


def test_every_dependency_is_pinned_within_its_bounds(repository: Path, lock: str) -> None:
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    pins = _pins(lock)
    for wanted in map(Requirement, project["dependencies"]):
        own = pins[canonicalize_name(wanted.name)]
        assert all(wanted.specifier.contains(next(iter(one.specifier)).version) for one in own), (
            wanted
        )
    here = {"python_full_version": ".".join(map(str, sys.version_info[:3]))}
    for name, own in pins.items():
        # At most one version of a thing on one machine.
        assert sum(one.marker is None or one.marker.evaluate(here) for one in own) <= 1, name


def test_every_pin_has_hashes_and_names_no_host(lock: str) -> None:
    blocks = re.split(r"\n(?=[A-Za-z0-9])", lock.split("\n", 2)[2])
    assert all("--hash=sha256:" in one for one in blocks)
    assert "://" not in lock
    assert "index-url" not in lock
