"""The simulated station's gauge R&R, predicted from its noise, then found by a crossed study.

    python bench/bench_gauge.py [PARTS=5] [FIXTURES=3] [REPEATS=2] [JOBS=cores]

Fixtures are measuring chains with errors drawn from the uncertainties that they declare. The fits'
statistical uncertainty foretells the repeatability; their instrument uncertainty, what fixtures may
differ by. A study of few fixtures finds the latter only within the wide interval of chi-square.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from motorid.quality.gauge import chi_interval
from motorid.quality.study_file import read_rows
from motorid.report.gauge import text
from motorid.rig import load_rig
from motorid.workflow.gauge import analyse_rows, measure, plan, readings, units_known
from motorid.workflow.many import fit_many

QUANTITIES = ("R", "L", "K", "J")


def main(arguments: list[str]) -> int:
    """Exit code 1 where the study contradicts the prediction."""
    parts, fixtures, repeats = (int(a) for a in [*arguments[:3], *"532"[len(arguments[:3]) :]])
    jobs = int(arguments[3]) if len(arguments) > 3 else os.cpu_count() or 1
    rng = np.random.default_rng(77)
    rig = load_rig("sim-line")
    rigs = {}
    for k in range(fixtures):
        gain, voltage, offset = rng.normal(0, 1, 3) * (0.002, 0.001, 2.0)
        errors = f"gain_error={gain}&voltage_gain_error={voltage}&offset_error={offset}"
        errors += f"&clock_ppm={rng.uniform(-50, 50)}"
        rigs[f"fixture-{k + 1}"] = replace(rig, port=f"{rig.port}&speed=max&{errors}")
    motors = {
        f"motor-{k + 1}": f"copper={rng.normal(1, 0.02)}&magnet={rng.normal(1, 0.01)}"
        for k in range(parts)
    }
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runs = plan(list(motors), list(rigs), repeats, folder)
        measure(runs, rigs, motors)
        table = folder / "readings.csv"
        table.write_text(readings(runs, folder, jobs=jobs), encoding="utf-8")
        results = analyse_rows(
            read_rows(table), table.name, quantities=QUANTITIES, units=units_known()
        )
        fits = fit_many([run.path for run in runs], folder, model="six", jobs=jobs)
    print(text(results), end="\n\n")
    wrong = 0
    head = f"{'':<4}{'EV foretold':>14}{'found':>12}{'95 %':>26}"
    print(head + f"{'AV at most':>14}{'found':>12}{'95 %':>26}")
    for result in results:
        quantity = result.study.quantity
        ev, av = result.components["EV"], result.components["AV"]
        instrument = [fit.values[quantity]["instrument"] for fit in fits]
        most = math.sqrt(float(np.mean(np.square(instrument))))
        stated = result.stated_sigma or math.nan
        low, high = ev.interval_95 or (math.nan, math.nan)
        least, widest = chi_interval(av.sigma, fixtures - 1)
        wrong += not low <= stated <= high or least > most
        print(
            f"{quantity:<4}{stated:14.3g}{ev.sigma:12.3g}{f'{low:.3g} to {high:.3g}':>26}"
            f"{most:14.3g}{av.sigma:12.3g}{f'{least:.3g} to {widest:.3g}':>26}"
        )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
