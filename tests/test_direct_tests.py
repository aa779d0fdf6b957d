"""Every module of the estimator is imported by a test, not only reached by whole fits."""

from __future__ import annotations

from pathlib import Path

from tests.import_statements import imported

ROOM = "motorid/estimate"
BY_FITS_ALONE: dict[str, str] = {
    "motorid.estimate.selection.predicted_gain": "whole fits hold which terms are chosen",
}
"""At most MOST modules that whole fits test well enough, each with the reason."""
MOST = 10


def modules(root: Path) -> set[str]:
    """Dotted names of all modules of the room."""
    files = (path.relative_to(root) for path in (root / ROOM).rglob("*.py"))
    return {".".join(path.with_suffix("").parts) for path in files if path.name != "__init__.py"}


def test_every_module_has_a_direct_test(repo_root: Path) -> None:
    files = [path for path in (repo_root / "tests").rglob("*.py") if path.name != "conftest.py"]
    named = {name for path in files for name in imported(path)}
    untested = modules(repo_root) - named
    assert untested <= set(BY_FITS_ALONE), "write a test that imports it"
    assert set(BY_FITS_ALONE) <= untested, "it has a test, or is gone: take it off the list"


def test_the_list_is_short_and_each_has_a_reason() -> None:
    assert len(BY_FITS_ALONE) <= MOST
    assert all(len(reason) > 20 for reason in BY_FITS_ALONE.values())
