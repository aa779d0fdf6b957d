"""Writes the table of docs/influence-quantities.md from the registry; ``--check`` compares.

The words around the table are written by hand; each row is what a quantity declares of itself.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import ModuleType

from motorid.estimate import effects
from motorid.estimate.effects import registry
from motorid.estimate.effects.action import Action
from motorid.estimate.effects.influence_quantity import InfluenceQuantity

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "influence-quantities.md"
BEGIN = "<!-- rows written by tools/influence_page.py: make docs -->"
END = "<!-- end of those rows -->"
HEAD = ("name", "unit", "scope", "use", "acts on", "meaning", "remedy", "file")
HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
NO_ACTION = "the budget alone"  # its size comes from a room above the effects


def page() -> str:
    """The whole document, its table anew. Raises ValueError where the page has no place for it."""
    before, begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f'{PAGE.name} needs the lines "{BEGIN}" and "{END}"')
    return f"{before}{BEGIN}\n{table()}\n{END}{after}"


def table() -> str:
    """A row for each registered quantity, in the registry's order."""
    at = dict(_declared())
    lines = [HEAD, ("---",) * len(HEAD), *(row(q, at[q]) for q in registry.REGISTRY)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def row(quantity: InfluenceQuantity, module: ModuleType) -> tuple[str, ...]:
    """One quantity, and the module that declares it. Raises ValueError without a docstring."""
    meaning = (module.__doc__ or "").strip().partition("\n")[0]
    if not meaning:
        raise ValueError(f"{module.__name__} has no docstring for its row in {PAGE.name}")
    file = module.__name__.removeprefix(f"{effects.__name__}.").replace(".", "/") + ".py"
    return (
        quantity.name,
        quantity.unit,
        quantity.scope.name.lower(),
        quantity.use.name.lower(),
        ", ".join(map(_acted, quantity.acts)) or NO_ACTION,
        meaning,
        quantity.remedy,
        f"`{file}`",
    )


def _acted(action: Action) -> str:
    """An action in words: its class, and the block or parameter that it names."""
    kind = HUMP.sub(" ", type(action).__name__).lower()
    values = [getattr(action, f.name) for f in fields(action)] if is_dataclass(action) else []
    named = [f"({value.replace('_', ' ')})" for value in values if isinstance(value, str)]
    return " ".join([kind, *named])


def _declared() -> Iterator[tuple[InfluenceQuantity, ModuleType]]:
    """Every quantity with the module that makes it, not those that import it."""
    for found in pkgutil.walk_packages(effects.__path__, f"{effects.__name__}."):
        module = importlib.import_module(found.name)
        if module is registry:
            continue
        source = Path(str(module.__file__)).read_text(encoding="utf-8")
        for name, value in vars(module).items():
            made = re.search(rf"^{re.escape(name)}\b.*=", source, re.MULTILINE)
            for quantity in _quantities(value) if made else ():
                yield quantity, module


def _quantities(value: object) -> Iterator[InfluenceQuantity]:
    """A variable's own, or those of a family that stands in a mapping."""
    if isinstance(value, InfluenceQuantity):
        yield value
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from _quantities(one)


def main(arguments: list[str]) -> int:
    """Exit code 1 where ``--check`` finds the page behind the registry."""
    written = page()
    if "--check" not in arguments:
        PAGE.write_text(written, encoding="utf-8", newline="\n")
        return 0
    if PAGE.read_text(encoding="utf-8") == written:
        return 0
    print(f"{PAGE.name} is behind the registry of influence quantities: make docs", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
