"""Captures from files -> an estimate -> the files that a person or a script reads."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import UsageError

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
) -> Estimate:
    """The estimate that the captures at ``paths`` give together.

    Raises DataError where a file is no capture or holds too little, UsageError on a bad option.
    """
    from motorid.capture import store
    from motorid.estimate import fit

    captures = [store.load(path) for path in paths]
    return fit(captures, fix=fix, without=without, method=method)


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
    for name in (ESTIMATE_FILE, REPORT_FILE):
        if (folder / name).exists() and not force:
            raise UsageError(
                f"{folder / name} exists; give --force to replace it, or another folder"
            )


def write_report(estimate: Estimate, folder: Path, *, force: bool = False) -> tuple[Path, ...]:
    """Writes estimate.json and report.html into ``folder``, each whole or not at all."""
    from motorid.report import html

    check_writable(folder, force=force)
    folder.mkdir(parents=True, exist_ok=True)
    pages = {ESTIMATE_FILE: as_json(estimate) + "\n", REPORT_FILE: html.render(estimate)}
    return tuple(_write_whole(folder / name, text) for name, text in pages.items())


def _write_whole(path: Path, text: str) -> Path:
    """A reader finds the old file or the new one, never half of one."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_text(text, encoding="utf-8", newline="\n")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path
