"""Which packages an installation needs, by pyproject.toml and by the lock files."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parent.parent.parent
LOCKS = {"run": ROOT / "locks" / "run.txt", "test": ROOT / "locks" / "test.txt"}
COMPILER_LOCK = ROOT / "locks" / "zig.txt"  # beside any environment: build/zig
SHA256 = re.compile(r"--hash=sha256:([0-9a-f]{64})")


class SupplyError(Exception):
    """A package that is not as it is locked, or has a licence that nobody allowed."""


@dataclass(frozen=True)
class Pin:
    """One locked package: its name as pip compares names, and what pip demands of its files."""

    name: str
    version: str
    requirement: Requirement
    sha256: tuple[str, ...]

    @property
    def applies(self) -> bool:
        """Whether this machine needs it at all."""
        marker = self.requirement.marker
        return marker is None or marker.evaluate()


def pins(path: Path) -> dict[str, Pin]:
    """The packages of a lock file, by name.

    Raises:
        SupplyError: A line names no exact version, or no hash.
    """
    found = {}
    for line in path.read_text(encoding="utf-8").replace("\\\n", " ").splitlines():
        wanted = line.partition("#")[0].partition("--hash")[0].strip()
        if not wanted:
            continue
        requirement, hashes = Requirement(wanted), tuple(SHA256.findall(line))
        (exact,) = [str(one) for one in requirement.specifier] or [""]
        if not exact.startswith("==") or not hashes:
            raise SupplyError(f"{path.name}: {wanted}: no exact version with its hashes: make lock")
        name = canonicalize_name(requirement.name)
        found[name] = Pin(name, exact.removeprefix("=="), requirement, hashes)
    return found


def wanted(what: str) -> list[Requirement]:
    """Requirements that pyproject.toml names for "run" or "test", with those of the build."""
    table = _pyproject()
    named = [*table["build-system"]["requires"], *table["project"]["dependencies"]]
    if what == "test":
        named += table["project"]["optional-dependencies"]["dev"]
    return [Requirement(one) for one in named]


def wanted_compiler() -> list[Requirement]:
    """The C compiler for machines without one; no environment of ours holds it."""
    return [Requirement(one) for one in _pyproject()["dependency-groups"]["compiler"]]


def wanted_by_users() -> list[Requirement]:
    """Requirements of every extra but that of developers."""
    extras = _pyproject()["project"]["optional-dependencies"]
    return [Requirement(one) for extra in extras if extra != "dev" for one in extras[extra]]


def _pyproject() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def installed(name: str) -> Distribution:
    """What an environment says of a package.

    Raises:
        SupplyError: It is not installed.
    """
    try:
        return distribution(name)
    except PackageNotFoundError:
        raise SupplyError(f"{name} is not installed: make .venv/ready-to-test") from None


def needs(package: Distribution, extras: Iterable[str] = ()) -> Iterator[Requirement]:
    """Requirements of an installed package that hold on this machine."""
    asked = ["", *extras]
    for text in package.requires or ():
        one = Requirement(text)
        if one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in asked):
            yield one


def closure(named: Iterable[Requirement]) -> dict[str, list[Requirement]]:
    """Every package that these need on this machine, with the requirements made of each."""
    found: dict[str, list[Requirement]] = {}
    followed: set[tuple[str, str]] = set()
    queue = [one for one in named if one.marker is None or one.marker.evaluate()]
    while queue:
        one = queue.pop()
        name = canonicalize_name(one.name)
        found.setdefault(name, []).append(one)
        for extra in {"", *one.extras} - {done for who, done in followed if who == name}:
            followed.add((name, extra))
            queue.extend(needs(installed(name), {extra}))
    return found
