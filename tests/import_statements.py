"""What a Python file imports, by its statements."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path


def imported(path: Path) -> frozenset[str]:
    """Modules, and what may be modules, that a file names, also inside functions or for types."""
    return _imported(path.read_text(encoding="utf-8"))


@cache
def _imported(text: str) -> frozenset[str]:
    return frozenset(name for node in _statements(ast.parse(text).body) for name in names(node))


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """These and all inside them; expressions, most of a tree, hold no import."""
    for node in body:
        yield node
        for field in ("body", "orelse", "finalbody"):
            yield from _statements(getattr(node, field, []))
        for inner in (*getattr(node, "handlers", ()), *getattr(node, "cases", ())):
            yield from _statements(inner.body)


def names(node: ast.AST) -> Iterator[str]:
    """The modules that one statement imports, if it is an import."""
    if isinstance(node, ast.Import):
        yield from (name.name for name in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module == "motorid":
        yield from (f"motorid.{name.name}" for name in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield node.module
        yield from (f"{node.module}.{name.name}" for name in node.names)
