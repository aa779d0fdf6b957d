"""The licences of what is installed, and whether each is allowed where it is used.

    python -m tools.supply.licences         a line for each package
    python -m tools.supply.licences --check

GPL programs (the boards' compiler, the emulator) run beside motorid and are no packages of it.
"""

from __future__ import annotations

import hashlib
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from license_expression import LicenseSymbol, Licensing, get_spdx_licensing
from packaging.utils import canonicalize_name

from tools.supply.packages import ROOT, SupplyError, closure, installed, wanted

TABLE = Path(__file__).with_suffix(".toml")
LONGEST = 80  # characters of a field License that names one, and is not its text


@cache
def table() -> dict[str, Any]:
    """What licences.toml says."""
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))


def licence(name: str) -> str:
    """The SPDX expression of an installed package.

    Raises:
        SupplyError: Neither its metadata nor licences.toml states one.
    """
    read = table()["read"].get(canonicalize_name(name))
    if read:
        return str(read["licence"])
    metadata = installed(name).metadata
    field = (metadata.get("License") or "").strip()
    classifiers = metadata.get_all("Classifier") or []
    said = [
        metadata.get("License-Expression") or "",
        field if len(field) <= LONGEST else "",
        *(one.rpartition(" :: ")[2] for one in classifiers if one.startswith("License ::")),
    ]
    for words in filter(None, said):
        expression = table()["words"].get(words, words)
        if not unknown(expression):
            return str(expression)
    raise SupplyError(
        f"{name}: no SPDX licence in its metadata; read it and state it in {TABLE.name}"
    )


@cache
def _spdx() -> Licensing:
    """All licences that SPDX knows; it takes a moment to read."""
    return get_spdx_licensing()


@cache
def unknown(expression: str) -> bool:
    """Whether SPDX has no such licence."""
    return bool(_spdx().validate(expression).errors)


def allowed(expression: str, where: str) -> bool:
    """Whether a package of that licence may be used there: "run" or "extra"."""
    names = set(table()["allowed"]["run"])
    if where != "run":
        names |= set(table()["allowed"]["extra"])
    return _allowed(_spdx().parse(expression, validate=True), names)


def _allowed(node: Any, names: set[str]) -> bool:
    """One branch of an OR is enough; an AND and a WITH need every part in their own words."""
    if isinstance(node, LicenseSymbol) or not getattr(node, "args", ()):
        return str(node) in names
    parts = [_allowed(part, names) for part in node.args]
    return any(parts) if node.operator.strip() == "OR" else all(parts)


def uses() -> dict[str, str]:
    """Where each package of this environment is used: "run" or "extra"."""
    run = closure(wanted("run"))
    return {name: "run" if name in run else "extra" for name in sorted(closure(wanted("test")))}


def faults() -> Iterator[str]:
    """A sentence for each package whose licence is unknown or not allowed."""
    for name, where in uses().items():
        try:
            found = licence(name)
        except SupplyError as error:
            yield str(error)
            continue
        if not allowed(found, where):
            yield f"{name}: {found} is not allowed for {where} ({TABLE.name})"
    for one in table()["firmware"]:
        if unknown(one["licence"]):
            yield f"{one['name']}: SPDX has no {one['licence']}"
    for one in table()["vendored"]:
        yield from _vendored_faults(one)


def _vendored_faults(one: dict[str, Any]) -> Iterator[str]:
    """A file of others must be what they published, under a licence that a run may have."""
    if unknown(one["licence"]) or not allowed(one["licence"], "run"):
        yield f"{one['name']}: {one['licence']} is not allowed inside the package ({TABLE.name})"
    if not (ROOT / one["text"]).is_file():
        yield f"{one['name']}: its licence {one['text']} is missing"
    for name, digest in one["files"].items():
        path = ROOT / name
        if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            yield f"{name}: not the file of {one['name']} {one['version']} ({TABLE.name})"


def main(arguments: list[str]) -> int:
    """Exit code 1 where ``--check`` finds a licence that is not allowed."""
    if "--check" not in arguments:
        for name, where in uses().items():
            print(f"{name:28} {where:6} {licence(name)}")
        return 0
    found = list(faults())
    for sentence in found:
        print(sentence, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
