"""A simulated line: motors that vary, drift and are sometimes bad, judged against the truth.

    python bench/bench_line.py [MOTORS=60] [JOBS=cores] [FOLDER]        (1000 for the full line)

Every motor is captured, judged by products/sim-disc.toml and put into a history by processes that
share it. FOLDER keeps what is done: kill it and call it again. One motor in 33 has a defect of the
kinds in docs/quality.md; the copper of the others drifts by 3 % over the shift.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.bench_verdicts import NO_ERRORS, in_the_end
from motorid.quality.history import Query, open_history
from motorid.quality.product import Product, load_product
from motorid.rig import Rig
from motorid.workflow.tasks import Task, run_all
from motorid.workflow.trend import from_history

DEFECT_SHARE = 0.03
DEFECTS = {
    "low magnet charge": {"magnet": 0.93},
    "high friction": {"friction": 1.6},
    "shorted turn": {"shorted_turn": 0.05},
    "wrong winding": {"winding": 1.06},
    "unbalanced rotor": {"unbalance": 1e-4},
    "bad brush": {"brush_bounce": 0.5},
    "loose coupling": {"coupling": 1e-3},
    "poor joint": {"copper": 1.1},
    "binds one way": {"asymmetry": 0.1},
}
SPREAD = {"copper": 0.02, "magnet": 0.01, "winding": 0.003, "friction": 0.08}  # standard, relative
DRIFT = 0.03  # of the copper, from the first motor to the last
STATION = {"board": 11, "gain_error": 0.0015, "voltage_gain_error": -0.0006, "offset_error": 1.2}
DISC, DISC_SPREAD = 6.4e-8, 6e-9  # kg·m²


def motors(count: int) -> list[tuple[str, dict[str, Any]]]:
    """Each motor's defect ("" for none) and what the simulated rig is told of it."""
    rng = np.random.default_rng(2026)
    found = []
    for k in range(count):
        options: dict[str, Any] = {n: float(rng.normal(1, s)) for n, s in SPREAD.items()}
        options["copper"] += DRIFT * k / max(1, count - 1)
        options["load_inertia"] = float(rng.normal(DISC, DISC_SPREAD))
        defect = ""
        if rng.random() < DEFECT_SHARE:
            defect = str(rng.choice(list(DEFECTS)))
            options |= DEFECTS[defect]
        found.append((defect, {**options, **STATION, "seed": 1000 + k, "speed": "max"}))
    return found


def inspect(number: int, options: dict[str, Any], folder: Path) -> dict[str, Any]:
    """One motor through the station and into the history; what it was and what was said of it."""
    from motorid.acquire.record import capture
    from motorid.rig import load_rig
    from motorid.sim import truth
    from motorid.workflow.check import judge_files
    from motorid.workflow.history import remember

    product, rig = load_product("sim-disc"), load_rig("sim-line")
    url = f"{rig.port}&{urlencode({k: v for k, v in options.items() if k != 'load_inertia'})}"
    url = url.replace("load_inertia=6.4e-8", f"load_inertia={options['load_inertia']}")
    path = folder / f"D{number:06d}.h5"
    began = time.perf_counter()
    capture(replace(rig, port=url), product.program, path, force=True, serial=path.stem)
    captured = time.perf_counter()
    verdict, _ = judge_files([path], product)
    with open_history(folder / "line.db") as history:
        remember(history, verdict, [path], product, station="simulated")
    real = truth(url) | {"no_load_speed": driven_long(rig, product, options)}
    return {
        "outcome": str(verdict.outcome),
        "marginal": verdict.marginal,
        "failed": [m.quantity for m in verdict.measurements if str(m.outcome) != "PASS"],
        "outside": outside(real, product),
        "risk": sum(1 - (m.conformance or 0.0) for m in verdict.measurements if known(m.quantity)),
        "capture_s": captured - began,
        "judge_s": time.perf_counter() - captured,
    }


PARAMETERS = ("R_25", "K_25", "L", "J", "T0", "B", "no_load_speed")


def known(quantity: str) -> bool:
    """The simulator says what is true of it."""
    return quantity in PARAMETERS


def outside(real: dict[str, Any], product: Product) -> list[str]:
    """The parameters whose true value breaks a limit."""
    limits = product.limits
    return [n for n in PARAMETERS if not limits[n].low <= real[n] <= limits[n].high]


def driven_long(rig: Rig, product: Product, options: dict[str, Any]) -> float:
    """rad/s of the motor itself at 25 °C after a second at the product's voltage."""
    port = rig.port.replace("load_inertia=6.4e-8", f"load_inertia={options['load_inertia']}")
    of_chain = {*STATION, *NO_ERRORS, "load_inertia", "speed"}
    own = {name: value for name, value in options.items() if name not in of_chain}
    with tempfile.TemporaryDirectory() as name:
        return in_the_end(replace(rig, port=port), product, {**own, "ambient": 25.0}, Path(name))


def main(arguments: list[str]) -> int:
    """Prints the outcome against the truth; exit code 1 where a defect escapes or one is lost."""
    count = int(arguments[0]) if arguments else 60
    jobs = int(arguments[1]) if len(arguments) > 1 else os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as name:
        folder = Path(arguments[2]) if len(arguments) > 2 else Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        line = motors(count)
        limits = load_product("sim-disc").digest
        tasks = [
            Task(inspect, (k, options, folder), {"motor": k, "options": options, "limits": limits})
            for k, (_, options) in enumerate(line)
        ]
        results = run_all(tasks, folder / "runs", jobs, show)
        lost = report(line, results, folder)
    return int(lost)


def show(done: int, total: int) -> None:
    """Progress, every tenth."""
    if done and done % max(1, total // 10) == 0:
        print(f"  {done} of {total}", file=sys.stderr, flush=True)


def report(
    line: list[tuple[str, dict[str, Any]]], results: list[dict[str, Any]], folder: Path
) -> bool:
    """The figures; True where a defect passed or the history lost or doubled a motor."""
    bad = [bool(defect or r["outside"]) for (defect, _), r in zip(line, results, strict=True)]
    passed = [r["outcome"] == "PASS" for r in results]
    escapes = [k for k, (b, p) in enumerate(zip(bad, passed, strict=True)) if b and p]
    rejects = [k for k, (b, p) in enumerate(zip(bad, passed, strict=True)) if not b and not p]
    marginal = [k for k in rejects if results[k]["marginal"]]
    promise = sum(r["risk"] for r, p in zip(results, passed, strict=True) if p)
    print(f"{len(line)} motors: {sum(bad)} bad ({sum(bool(d) for d, _ in line)} by a defect)")
    print(f"escapes         {len(escapes)}   the guard band promises at most {promise:.2f}")
    print(f"false rejects   {len(rejects)}   of which {len(marginal)} MARGINAL, as it was asked to")
    for k in escapes:
        print(f"  escaped  D{k:06d}: {line[k][0] or results[k]['outside']}")
    for k in rejects:
        print(f"  rejected D{k:06d}: {', '.join(results[k]['failed'])}")
    caught = Counter(d for (d, _), p in zip(line, passed, strict=True) if d and not p)
    defects = Counter(d for d, _ in line if d)
    print("defects caught  " + "; ".join(f"{d} {caught[d]}/{n}" for d, n in defects.items()))
    spent = [(r["capture_s"], r["judge_s"]) for r in results]
    capture_s, judge_s = np.median(np.array(spent), axis=0)
    print(f"median          capture {capture_s:.2f} s (simulated), judge {judge_s:.2f} s")
    with open_history(folder / "line.db") as history:
        serials = [row.serial for row in history.results(Query(kind="check"))]
    whole = sorted(serials) == [f"D{k:06d}" for k in range(len(line))]
    print(f"history         {len(serials)} results, {'none' if whole else 'SOME'} lost or doubled")
    trend(folder)
    slipped = any(line[k][0] for k in escapes)
    return slipped or not whole


def trend(folder: Path) -> None:
    """What motorid trend makes of the copper's drift."""
    from motorid.quality.trend import trend as analyse

    with open_history(folder / "line.db") as history:
        at = {row.serial: row.id for row in history.results()}
    series = from_history(str(folder / "line.db"), "R_25", Query(kind="check"))
    assert len(series.values) == len(at)
    if len(at) < 3:
        print("trend of R_25   three motors or more make one")
        return
    found = analyse(
        series.values, series.days, quantity="R_25", lower=series.lower, upper=series.upper,
        baseline=max(20, len(series.values) // 4) if len(series.values) >= 20 else None,
    )  # fmt: skip
    able = found.capability
    assert able is not None
    print(f"trend of R_25   {len(found.alarms)} rules alarm; Ppk {able.ppk.value:.2f}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
