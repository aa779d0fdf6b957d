"""A gauge study from the rig to the report: every operator or fixture measures every part."""

from __future__ import annotations

import random
import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl

from motorid import csv_text, json_text
from motorid.errors import DataError, UsageError
from motorid.workflow.record import SIM, sim_url

if TYPE_CHECKING:
    from motorid.quality.gauge import GaugeResult, Method
    from motorid.quality.product import Product
    from motorid.rig import Rig
    from motorid.workflow.tasks import Progress, Workers

READINGS, JSON_FILE, REPORT = "readings.csv", "gauge.json", "gauge.html"
CAPTURES = "captures"
Ask = Callable[["Run"], None]


@dataclass(frozen=True)
class Run:
    """One measurement of the study: ``repeat`` counts from 1."""

    part: str
    operator: str
    repeat: int
    path: Path


def plan(
    parts: Sequence[str], operators: Sequence[str], repeats: int, folder: Path, *, seed: int = 1
) -> list[Run]:
    """The runs in the order to make them: in each round every operator takes all parts, shuffled.

    Nobody can then remember what a part gave before (AIAG); equal seeds give equal orders.
    """
    if len(set(parts)) < 2 or repeats < 2:
        raise UsageError("a gauge study needs two different parts or more and two repeats or more")
    order = random.Random(seed)  # noqa: S311 - an order, not a secret
    runs = []
    for repeat in range(1, repeats + 1):
        for operator in operators:
            shuffled = list(dict.fromkeys(parts))
            order.shuffle(shuffled)
            for part in shuffled:
                name = re.sub(r"[^\w.-]", "_", f"{part}_{operator}_{repeat}")
                runs.append(Run(part, operator, repeat, folder / CAPTURES / f"{name}.h5"))
    if len({run.path for run in runs}) != len(runs):
        raise UsageError("two parts or operators would share a file: give them plainer names")
    return runs


def measure(
    runs: Sequence[Run],
    rigs: Mapping[str, Rig],
    options: Mapping[str, str],
    *,
    product: Product | None = None,
    ask: Ask | None = None,
) -> None:
    """Makes the runs that are not on disk yet; ``ask`` waits until the part is mounted.

    ``rigs`` by operator or fixture. ``options`` by part: what a simulated rig is told of its motor,
    as ``load_inertia=1e-8``. A simulated rig gets another seed for every run, so its noise differs,
    and stays the board that its port names, with the errors and the calibration of that one.
    """
    from motorid.acquire.record import capture

    for run in runs:
        if run.path.exists():
            continue
        if ask:
            ask(run)
        run.path.parent.mkdir(parents=True, exist_ok=True)
        rig = rigs[run.operator]
        rig = replace(rig, port=_port(rig.port, options.get(run.part, ""), run))
        program = product.program if product else rig.program
        note = f"gauge study, {run.operator}, repeat {run.repeat}"
        capture(rig, program, run.path, serial=run.part, note=note)


def _port(port: str, options: str, run: Run) -> str:
    from motorid.sim.options import parse_url

    if not port.startswith(SIM):
        if options:
            raise UsageError(
                f"part {run.part}: {options} is for simulated rigs, {port} is a real one"
            )
        return port
    told = dict(parse_qsl(options, keep_blank_values=True))
    told["board"] = str(parse_url(port).board_seed)
    told["seed"] = str(zlib.crc32(f"{run.part}/{run.operator}/{run.repeat}".encode()))
    return sim_url(port, **told)


def readings(
    runs: Sequence[Run],
    folder: Path,
    *,
    product: Product | None = None,
    jobs: Workers = 1,
    progress: Progress | None = None,
) -> str:
    """The study's readings as CSV: fitted parameters, or a product's quantities, a row a run.

    Raises DataError naming the first run that gives none: a crossed study needs all of them.
    """
    rows = _judged(runs, product) if product else _fitted(runs, folder, jobs, progress)
    names = [n for n in rows[0] if all(row.get(n, ("", ""))[0] is not None for row in rows)]
    head = ["part", "operator", "repeat", *(c for n in names for c in (n, f"u({n})"))]
    return csv_text.table(
        head,
        (
            [run.part, run.operator, run.repeat, *(cell for name in names for cell in row[name])]
            for run, row in zip(runs, rows, strict=True)
        ),
    )


_Row = dict[str, tuple[Any, Any]]  # quantity -> value and standard uncertainty


def _fitted(
    runs: Sequence[Run], folder: Path, jobs: Workers, progress: Progress | None
) -> list[_Row]:
    from motorid.estimate.results.estimate import SIX
    from motorid.workflow.many import fit_many

    paths = [run.path for run in runs]
    fits = fit_many(paths, folder, model=SIX, jobs=jobs, progress=progress)
    for fit in fits:
        if fit.failure:
            raise DataError(f"{fit.path}: {fit.failure}; remove it and run the study again")
    return [{n: (v["value"], v["statistical"]) for n, v in fit.values.items()} for fit in fits]


def _judged(runs: Sequence[Run], product: Product) -> list[_Row]:
    from motorid.workflow.check import judge_files

    rows = []
    for run in runs:
        verdict, _ = judge_files([run.path], product)
        measured = [m for m in verdict.measurements if not m.limit.condition]
        rows.append({m.quantity: (m.reading.value, None) for m in measured})
    return rows


def analyse_rows(
    rows: Sequence[Mapping[str, str]],
    where: str,
    *,
    quantities: Sequence[str] = (),
    tolerances: Mapping[str, float] | None = None,
    units: Mapping[str, str] | None = None,
    method: Method = "anova",
    alpha: float | None = None,
) -> list[GaugeResult]:
    """The study of each quantity that ``rows`` hold (or of those asked for)."""
    from motorid.quality.gauge import analyse
    from motorid.quality.study_file import nested_study_of, quantities_of, study_of

    found = [q for q in quantities_of(rows) if not q.startswith("u(")]
    names = list(quantities) or found
    if not names:
        raise DataError(f"{where} has no column of numbers to study")
    results = []
    for name in names:
        claim = f"u({name})"
        stated = claim if claim in quantities_of(rows) else ""
        unit = (units or {}).get(name, "")
        if method == "nested":
            study = nested_study_of(rows, name, where, unit=unit)
        else:
            study = study_of(rows, name, where, unit=unit, stated=stated)
        tolerance = (tolerances or {}).get(name)
        results.append(analyse(study, method=method, tolerance=tolerance, alpha=alpha))
    return results


def tolerances_of(product: Product) -> dict[str, float]:
    """The widths of a product's two-sided limits, by quantity."""
    found = {name: limit.high - limit.low for name, limit in product.limits.items()}
    return {name: width for name, width in found.items() if 0 < width < float("inf")}


def units_known(product: Product | None = None) -> dict[str, str]:
    """Units by quantity: the fit's parameters, and what a product limits."""
    from motorid.estimate.results.estimate import UNITS

    named = product.limits if product else {}
    return UNITS | {name: "" if one.unit == "1" else one.unit for name, one in named.items()}


def write(
    results: Sequence[GaugeResult], folder: Path, *, title: str, force: bool = False
) -> list[Path]:
    """gauge.json and gauge.html. Raises UsageError where one exists, unless ``force``."""
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.report import gauge, gauge_html

    folder.mkdir(parents=True, exist_ok=True)
    plain = json_text.dumps(gauge.to_dict(results), indent=2)
    pages = {JSON_FILE: plain + "\n", REPORT: gauge_html.render(results, title)}
    for name in pages:
        refuse_existing(folder / name, force)
    for name, text in pages.items():
        write_whole(folder / name, text.encode(), force=force)
    return [folder / name for name in pages]
