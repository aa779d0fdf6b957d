"""Every module of the estimator is imported by a test, not only reached by whole fits."""

from __future__ import annotations

from pathlib import Path

from tests.import_statements import imported

ROOM = "motorid/estimate"


def modules(root: Path) -> set[str]:
    """Dotted names of all modules of the room."""
    files = (path.relative_to(root) for path in (root / ROOM).rglob("*.py"))
    return {".".join(path.with_suffix("").parts) for path in files if path.name != "__init__.py"}


def test_every_module_has_a_direct_test(repo_root: Path) -> None:
    files = [path for path in (repo_root / "tests").rglob("*.py") if path.name != "conftest.py"]
    named = {name for path in files for name in imported(path)}
    assert modules(repo_root) - named == set()
