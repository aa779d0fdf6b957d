"""Many captures, each fitted by itself, on all cores: resumable, and a bad one stops nothing."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import csv_text
from motorid.capture.whole import refuse_existing, write_whole
from motorid.errors import DataError, MotoridError
from motorid.estimate.results.estimate import AUTO
from motorid.storage.captures import captures_in as captures_in
from motorid.storage.captures import load
from motorid.storage.captures import sha256_of as sha256_of
from motorid.storage.place import place
from motorid.version import __version__
from motorid.workflow.recalibrate import cited
from motorid.workflow.tasks import Progress, Result, Task, Workers, run_all

if TYPE_CHECKING:
    from motorid.rig import Rig
    from motorid.storage.place import Place

RUNS, TABLE = "runs", "fits.csv"


@dataclass(frozen=True)
class Fitted:
    """One capture's answer. ``values``: name -> {value, statistical, instrument, total, status}.

    ``failure`` says why there is none. ``seconds``: what loading and fitting took.
    """

    path: str
    sha256: str
    serial: str
    values: Mapping[str, Mapping[str, Any]]
    findings: tuple[str, ...]
    failure: str
    seconds: float


def captures_of_history(
    where: str, *, serial: str = "", since: datetime | None = None
) -> list[Place]:
    """Where the history says that the captures of these motors are.

    Raises DataError where it knows none.
    """
    from motorid.quality.history import open_history

    with open_history(where, create=False) as history:
        rows = history.captures(serial=serial)
    found = [place(r.path) for r in rows if since is None or (r.created and r.created >= since)]
    if not found:
        raise DataError(f"the history {where} knows no such capture: widen the query")
    return list(dict.fromkeys(found))


def fit_many(
    paths: Sequence[Place],
    folder: Path,
    *,
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
    method: str = "ml",
    model: str = AUTO,
    rig: Rig | None = None,
    jobs: Workers = 1,
    progress: Progress | None = None,
) -> list[Fitted]:
    """Fits each capture by itself; answers in the order of ``paths``, whatever finishes first.

    ``folder`` keeps every finished answer, by the capture's SHA-256, the options and the ``rig`` to
    re-analyse them with: interrupt and call again. ``jobs``: see ``Workers``.
    ``model``: six does without the search for a better one, which adds findings and no values.
    """
    options = {"fix": dict(fix or {}), "without": list(without), "method": method, "model": model}
    under = {"rig": cited(rig)} if rig is not None else {}
    known = {path: _sha256(path) for path in paths}
    tasks = [
        Task(
            _fit,
            (path, sha256, options, rig),
            {"capture": sha256, "options": options, "motorid": __version__, **under},
            partial(_failed, sha256),
        )
        for path, sha256 in known.items()
        if isinstance(sha256, str)
    ]
    results = iter(run_all(tasks, folder / RUNS, jobs, progress))
    answers = {
        path: _unreadable(sha256) if isinstance(sha256, MotoridError) else next(results)
        for path, sha256 in known.items()
    }
    return [_fitted(path, answers[path]) for path in paths]


def _sha256(path: Place) -> str | MotoridError:
    try:
        return sha256_of(path)
    except DataError as error:
        return error


def _fit(path: Place, sha256: str, options: Mapping[str, Any], rig: Rig | None) -> Result:
    """One capture's answer as plain data; whatever goes wrong is its failure and nobody else's."""
    from motorid.workflow.fit import fit_captures

    began = time.perf_counter()
    result: Result = {"sha256": sha256, "serial": "", "values": {}, "findings": [], "failure": ""}
    try:
        capture = load(path, sha256)
        result["serial"] = str(capture.provenance.get("serial", ""))
        estimate = fit_captures([capture], rig=rig, **options)
        result["values"] = _values({**estimate.parameters, **estimate.at_25, **estimate.derived})
        worth = [d for d in estimate.diagnostics if d.severity != "info"]
        result["findings"] = [d.code for d in worth]
    except MotoridError as error:
        result["failure"] = str(error)
    except Exception as error:  # a defect of the fit must not cost the other captures
        result["failure"] = f"internal error, {type(error).__name__}: {error}"
    return result | {"seconds": time.perf_counter() - began}


def _values(named: Mapping[str, Any]) -> dict[str, Any]:
    from motorid.report.json_ import plain

    fields = ("value", "statistical", "instrument", "total", "status", "unit")
    return {name: {f: plain(getattr(p, f)) for f in fields} for name, p in named.items()}


def _unreadable(error: MotoridError) -> Result:
    return _failed("", str(error))


def _failed(sha256: str, says: str) -> Result:
    """The answer of a capture that has none."""
    found: Result = {"sha256": sha256, "serial": "", "values": {}, "findings": []}
    return found | {"failure": says, "seconds": 0.0}


def _fitted(path: Place, result: Result) -> Fitted:
    said = str(result["failure"])
    if isinstance(path, Path):
        said = said.replace(os.path.abspath(path), str(path))  # as a worker named it
    fields = {**result, "findings": tuple(result["findings"]), "failure": said}
    return Fitted(path=str(path), **fields)


def table(fits: Sequence[Fitted]) -> str:
    """CSV, a row a capture: values and total standard uncertainties in SI, or the failure."""
    names = list(dict.fromkeys(name for fit in fits for name in fit.values))
    head = ["path", "serial", "sha256", "failure", "findings"]
    head += [column for n in names for column in (n, f"u({n})", f"{n} status")]
    return csv_text.table(head, ([*_head(fit), *_cells(fit, names)] for fit in fits))


def _head(fit: Fitted) -> list[str]:
    return [fit.path, fit.serial, fit.sha256, fit.failure, " ".join(fit.findings)]


def _cells(fit: Fitted, names: Sequence[str]) -> Iterator[Any]:
    for name in names:
        found = fit.values.get(name, {})
        yield from (found.get("value"), found.get("total"), found.get("status", ""))


def fit_to_files(
    places: Sequence[Place],
    folder: Path,
    *,
    force: bool = False,
    progress: Callable[[], Progress] | None = None,
    **options: Any,
) -> tuple[list[Fitted], Path]:
    """``fit_many`` over files and folders, with the table in ``folder``; see there.

    Raises UsageError where the table exists, DataError where no capture at all could be fitted.
    """
    paths = captures_in(places)
    folder.mkdir(parents=True, exist_ok=True)
    refuse_existing(folder / TABLE, force)
    fits = fit_many(paths, folder, progress=progress() if progress else None, **options)
    write_whole(folder / TABLE, table(fits).encode(), force=force)
    if all(fit.failure for fit in fits):
        raise DataError(
            f"none of {len(fits)} captures could be fitted; the first: {fits[0].failure}"
        )
    return fits, folder / TABLE


def summary(fits: Sequence[Fitted]) -> str:
    """What a person reads at the end: how many, how spread, what failed."""
    import numpy as np

    good = [fit for fit in fits if not fit.failure]
    lines = [f"{len(good)} of {len(fits)} captures fitted"]
    names = dict.fromkeys(name for fit in good for name in fit.values)
    for name in names:
        found = [f.values[name] for f in good if name in f.values]
        values = np.array([v["value"] for v in found if v["value"] is not None], dtype=float)
        if len(values) > 1:
            low, middle, high = np.quantile(values, [0.05, 0.5, 0.95])
            unit = found[0]["unit"]
            lines.append(f"  {name:<6} {middle:.5g} {unit}, 5 % to 95 %: {low:.5g} to {high:.5g}")
    lines += [f"FAILED {fit.path}: {fit.failure}" for fit in fits if fit.failure]
    return "\n".join(lines)
