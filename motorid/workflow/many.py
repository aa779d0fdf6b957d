"""Many captures, each fitted by itself, on all cores: resumable, and a bad one stops nothing."""

from __future__ import annotations

import hashlib
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
from motorid.reading import open_file
from motorid.version import __version__
from motorid.workflow.recalibrate import cited
from motorid.workflow.tasks import Progress, Result, Task, Workers, run_all

if TYPE_CHECKING:
    from motorid.rig import Rig

RUNS, TABLE = "runs", "fits.csv"
SUFFIX = ".h5"
CHUNK = 1 << 20


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


def captures_in(places: Sequence[Path]) -> list[Path]:
    """The capture files among ``places``; a folder stands for those in it, at any depth.

    Raises DataError where a folder holds none.
    """
    found: list[Path] = []
    for place in places:
        if not place.is_dir():
            found.append(place)
            continue
        inside = sorted(p for p in place.rglob(f"*{SUFFIX}") if not p.name.startswith("."))
        if not inside:
            raise DataError(f"the folder {place} holds no capture ({SUFFIX}): name another")
        found += inside
    return list(dict.fromkeys(found))


def captures_of_history(
    where: str, *, serial: str = "", since: datetime | None = None
) -> list[Path]:
    """Where the history says that the captures of these motors are.

    Raises DataError where it knows none.
    """
    from motorid.quality.history import open_history

    with open_history(where, create=False) as history:
        rows = history.captures(serial=serial)
    found = [Path(r.path) for r in rows if since is None or (r.created and r.created >= since)]
    if not found:
        raise DataError(f"the history {where} knows no such capture: widen the query")
    return list(dict.fromkeys(found))


def fit_many(
    paths: Sequence[Path],
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


def _sha256(path: Path) -> str | MotoridError:
    try:
        return sha256_of(path)
    except DataError as error:
        return error


def sha256_of(path: Path) -> str:
    """The digest of a file's bytes. Raises DataError where they cannot be read."""
    digest = hashlib.sha256()
    try:
        with open_file(path, DataError) as file:
            while piece := file.read(CHUNK):
                digest.update(piece)
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror or error}") from None
    return digest.hexdigest()


def _fit(path: Path, sha256: str, options: Mapping[str, Any], rig: Rig | None) -> Result:
    """One capture's answer as plain data; whatever goes wrong is its failure and nobody else's."""
    from motorid.capture import store
    from motorid.workflow.fit import fit_captures

    began = time.perf_counter()
    result: Result = {"sha256": sha256, "serial": "", "values": {}, "findings": [], "failure": ""}
    try:
        capture = store.load(path)
        if capture.sha256 != sha256:
            raise DataError(f"{path} changed while it was fitted: run again")
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


def _fitted(path: Path, result: Result) -> Fitted:
    said = str(result["failure"]).replace(os.path.abspath(path), str(path))  # as a worker named it
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
    places: Sequence[Path],
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
