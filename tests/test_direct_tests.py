"""Every module of the estimator is imported by a test, not only reached by whole fits."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.import_statements import imported

ROOM = "motorid/estimate"
MOST_FILES = 20


def modules(root: Path) -> set[str]:
    """Dotted names of all modules of the room."""
    files = (path.relative_to(root) for path in (root / ROOM).rglob("*.py"))
    return {".".join(path.with_suffix("").parts) for path in files if path.name != "__init__.py"}


@pytest.mark.slow
def test_every_module_has_a_direct_test(repo_root: Path) -> None:
    files = [path for path in (repo_root / "tests").rglob("*.py") if path.name != "conftest.py"]
    named = {name for path in files for name in imported(path)}
    assert modules(repo_root) - named == set()


def test_no_folder_of_it_is_too_full_to_find_a_module_in(repo_root: Path) -> None:
    folders = Counter(path.parent for path in (repo_root / ROOM).rglob("*.py"))
    assert {str(one): n for one, n in folders.items() if n > MOST_FILES} == {}
