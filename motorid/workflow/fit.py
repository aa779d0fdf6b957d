"""Captures from files -> an estimate -> the files that a person or a script reads."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motorid.estimate.types import Estimate

ESTIMATE_FILE = "estimate.json"
REPORT_FILE = "report.html"


def fit_files(
    paths: Sequence[Path],
    *,
    fix: Mapping[str, float],
    without: Sequence[str] = (),
    method: str = "ml",
    **search: Any,
) -> Estimate:
    """The estimate that the captures at ``paths`` give together.

    ``search``: ``model``, ``budget`` and ``seed`` of a method that searches.

    Raises DataError where a file is no capture or holds too little, UsageError on a bad option.
    """
    from motorid.capture import store
    from motorid.estimate import fit

    captures = [store.load(path) for path in paths]
    return fit(captures, fix=fix, without=without, method=method, **search)


def as_text(estimate: Estimate) -> str:
    """The estimate as a table for a terminal."""
    from motorid.report import text

    return text.render(estimate)


def as_json(estimate: Estimate) -> str:
    """The estimate as JSON, by the published schema."""
    from motorid.report import json_

    return json.dumps(json_.to_dict(estimate), indent=2, ensure_ascii=False, allow_nan=False)


def check_writable(folder: Path, *, force: bool) -> None:
    """Raises UsageError where ``write_report`` would replace a file without leave."""
    from motorid.capture.whole import refuse_existing

    if folder.is_dir():
        for name in (ESTIMATE_FILE, REPORT_FILE):
            refuse_existing(folder / name, force)


def write_report(estimate: Estimate, folder: Path, *, force: bool = False) -> tuple[Path, ...]:
    """Writes estimate.json and report.html into ``folder``, each whole or not at all.

    Raises UsageError where one exists (unless ``force``), DataError where the disk refuses.
    """
    from motorid.capture.whole import write_whole
    from motorid.report import html

    check_writable(folder, force=force)
    folder.mkdir(parents=True, exist_ok=True)
    pages = {ESTIMATE_FILE: as_json(estimate) + "\n", REPORT_FILE: html.render(estimate)}
    for name, text in pages.items():
        write_whole(folder / name, text.encode(), force=force)
    return tuple(folder / name for name in pages)
