"""Captures from files -> an estimate -> the files that a person or a script reads."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import EXIT_DATA, EXIT_DONE

if TYPE_CHECKING:
    from motorid.capture.model import Capture, Stated
    from motorid.estimate.results.estimate import Diagnostic, Estimate
    from motorid.rig import Rig
    from motorid.storage.place import Place

ESTIMATE_FILE = "estimate.json"
REPORT_FILE = "report.html"


def fit_files(
    paths: Sequence[Place],
    *,
    rig: Rig | None = None,
    fix: Mapping[str, float],
    without: Sequence[str] = (),
    method: str = "ml",
    ambient: tuple[float, float] | None = None,
    nameplate: Stated | None = None,
    **search: Any,
) -> Estimate:
    """The estimate that the captures at ``paths`` give together, under another ``rig`` if given.

    ``ambient``: °C and standard uncertainty (K), in place of what the captures hold.
    ``nameplate``: what is known of the motor, over what they hold. ``search``: ``model``, and
    ``budget`` and ``seed`` of a method that searches.

    Raises DataError where a file is no capture or holds too little, UsageError on a bad option,
    RigError where the rig is not of these captures.
    """
    from motorid.storage.captures import load

    captures = [load(path) for path in paths]
    return fit_captures(
        captures, rig=rig, ambient=ambient, nameplate=nameplate, fix=fix, without=without,
        method=method, **search,
    )  # fmt: skip


def fit_captures(
    captures: Sequence[Capture],
    *,
    rig: Rig | None = None,
    ambient: tuple[float, float] | None = None,
    nameplate: Stated | None = None,
    **options: Any,
) -> Estimate:
    """As ``fit_files``, for captures that are loaded already."""
    from motorid.identify import fit

    if rig is not None:
        from motorid.workflow.recalibrate import recalibrated

        captures = [recalibrated(capture, rig) for capture in captures]
    if ambient is not None:
        degrees, doubt = ambient
        captures = [
            replace(capture, ambient_c=degrees, ambient_uncertainty_c=doubt) for capture in captures
        ]
    if nameplate is not None:
        captures = [replace(c, stated=c.stated.under(nameplate)) for c in captures]
    estimate = fit(captures, **options)
    if nameplate is not None:
        figures = {**nameplate.nameplate, **nameplate.thermal}
        estimate = replace(estimate, options={**estimate.options, "nameplate": figures})
    return replace(estimate, diagnostics=(*estimate.diagnostics, *_old(estimate)))


def _old(estimate: Estimate) -> Iterator[Diagnostic]:
    """Calibrations that lie too far from the run that they explain."""
    from motorid.estimate.results.estimate import Diagnostic
    from motorid.rig_calibration import too_old

    said: set[str] = set()
    for one in estimate.inputs:
        cited = {**one, **one.get("reanalysed", {})}.get("calibration")
        taken = _moment(one.get("created"))
        if not cited or taken is None:
            continue
        sentence = too_old(cited, taken)
        if sentence and sentence not in said:
            said.add(sentence)
            yield Diagnostic("calibration_old", "warning", sentence)


def _moment(text: Any) -> datetime | None:
    """When a capture was taken; None where its file does not say it in words that can be read."""
    try:
        found = datetime.fromisoformat(str(text))
    except ValueError:
        return None
    return found if found.tzinfo else found.replace(tzinfo=UTC)


def exit_code(estimate: Estimate, *, strict: bool = False) -> int:
    """Of a fit: 4 where a parameter is not supported, or with ``strict`` where one is doubtful."""
    from motorid.estimate.assembly.doubt import doubtful

    found = doubtful(estimate)
    return EXIT_DATA if any(strict or p.status.unknown for p in found) else EXIT_DONE


def as_text(estimate: Estimate) -> str:
    """The estimate as a table, as wide as the terminal allows; in a file as wide as it likes."""
    from motorid.report import text

    if not (sys.stdout.isatty() or "COLUMNS" in os.environ):
        return text.render(estimate)
    return text.render(estimate, shutil.get_terminal_size((text.WIDTH, 24)).columns)


def as_json(estimate: Estimate) -> str:
    """The estimate as JSON, by the published schema."""
    from motorid.report import json_

    return json_.dumps(estimate).rstrip("\n")


def check_writable(folder: Path, *, force: bool) -> None:
    """Raises UsageError where ``write_report`` would replace a file without leave.

    A new folder may not have the name of a file, such as report.html: a file was meant.
    """
    from motorid.capture.naming import refuse_file_name
    from motorid.capture.whole import refuse_existing

    if not folder.exists():
        refuse_file_name(folder)
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
