"""A bent current sensor, a drifting reference, an eccentric encoder: do intervals hold with them?

python bench/bench_chain.py --rigs 200 --out chain.jsonl   go on where the file ends
python bench/bench_chain.py --tables chain.jsonl           the table of what is there

The rigs of bench_coverage.py, with good gains, so that the three errors are not small beside them.
Each error is drawn from the figure that the rig file states of it. Every rig is fitted twice: with
those figures, and as if nobody had stated them.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one rig a core
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from bench.bench_coverage import stored
from bench.coverage.rigs import Bench, draw_bench
from bench.coverage.runs import record
from motorid.capture.model import CURRENT, Capture, Curve
from motorid.errors import MotoridError
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.rig import Calibration, Rig
from tests.six_parameters import fit

Row = dict[str, Any]
LINES = ("current non-linearity", "reference drift", "encoder eccentricity")
CURRENT_GAIN, VOLTAGE_GAIN = (2e-4, 2e-3), (1e-4, 1e-3)  # standard: calibrated ones
NONLINEARITY, DRIFT = (1e-3, 1e-2), (1e-4, 2e-3)  # standard
DRIFT_TIME_S, ECCENTRICITY_RAD = (0.1, 5.0), (2e-4, 5e-3)
SHAPES: tuple[Curve, ...] = ("cubic", "s")  # that the simulator can be
WAYS = ("declared", "undeclared")


@dataclass(frozen=True)
class Rest:
    """What a rig's file states of its chain, and how far off the chain is, in those figures."""

    gain: float
    voltage_gain: float
    nonlinearity: float
    shape: Curve
    drift: float
    time_s: float
    eccentricity_rad: float
    bent_by: float
    drifts_by: float
    gain_off: float

    def of_sim(self) -> dict[str, Any]:
        """The simulator's options. An S is a cubic whose line is turned by 3 of its 4 parts."""
        bent, turned = self.nonlinearity * self.bent_by, self.shape == "s"
        return {
            "current_cubic": 4.0 * bent if turned else bent,
            "gain_error": self.gain * self.gain_off - (3.0 * bent if turned else 0.0),
            "gain_uncertainty": self.gain,
            "voltage_gain_uncertainty": self.voltage_gain,
            "reference_drift": self.drift * self.drifts_by,
            "reference_time": self.time_s,
            "eccentricity": self.eccentricity_rad,
        }

    def stated(self, rig: Rig) -> Rig:
        """The rig with these figures."""
        known = replace(
            rig.calibration.get(CURRENT, Calibration()),
            gain_uncertainty=self.gain,
            nonlinearity=self.nonlinearity,
            nonlinearity_shape=self.shape,
        )
        wiring = replace(
            rig.wiring,
            reference_drift=self.drift,
            reference_time_s=self.time_s,
            encoder_eccentricity_rad=self.eccentricity_rad,
        )
        return replace(rig, wiring=wiring, calibration={**rig.calibration, CURRENT: known})


def drawn(seed: int) -> tuple[Bench, Rest]:
    """The rig of that seed with the rest of its chain."""
    rng = np.random.default_rng([seed, 185])

    def between(ends: tuple[float, float]) -> float:
        return math.exp(rng.uniform(math.log(ends[0]), math.log(ends[1])))

    rest = Rest(
        gain=between(CURRENT_GAIN),
        voltage_gain=between(VOLTAGE_GAIN),
        nonlinearity=between(NONLINEARITY),
        shape=SHAPES[int(rng.integers(len(SHAPES)))],
        drift=between(DRIFT),
        time_s=between(DRIFT_TIME_S),
        eccentricity_rad=between(ECCENTRICITY_RAD),
        bent_by=float(rng.standard_normal()),
        drifts_by=float(rng.standard_normal()),
        gain_off=float(rng.standard_normal()),
    )
    bench = draw_bench(seed)
    rigs = tuple(rest.stated(rig) for rig in bench.rigs)
    return replace(bench, options=replace(bench.options, **rest.of_sim()), rigs=rigs), rest


def forgotten(capture: Capture) -> Capture:
    """The same of a rig file that states nothing of the three."""
    current = replace(
        capture.channels[CURRENT], nonlinearity=0.0, nonlinearity_shape=None, full_scale=0.0
    )
    wiring = replace(
        capture.wiring, reference_drift=None, reference_time_s=0.0, encoder_eccentricity_rad=0.0
    )
    return replace(capture, channels={**capture.channels, CURRENT: current}, wiring=wiring)


def score(seed: int) -> Row:
    """The record of one rig; a refusal is in it."""
    bench, rest = drawn(seed)
    row: Row = {"seed": seed, "shape": rest.shape}
    try:
        with tempfile.TemporaryDirectory() as folder:
            runs = record(bench, Path(folder))
    except MotoridError as error:
        return row | {"refused": f"{type(error).__name__}: {error}"}
    without = [forgotten(capture) for capture in runs.captures]
    for name, captures in (("declared", list(runs.captures)), ("undeclared", without)):
        try:
            row[name] = _scored(fit(captures), runs.truth)
        except MotoridError as error:
            row[name] = {"refused": f"{type(error).__name__}: {error}"}
    return row


def _scored(found: Estimate, truth: Mapping[str, float]) -> Row:
    out: Row = {}
    for name in PARAMETERS:
        p = found.parameters[name]
        if p.interval_95 is None or p.value is None:
            continue
        low, high = p.interval_95
        shares = found.budget.get(name, {})
        out[name] = {
            "holds": low <= truth[name] <= high,
            "half": (high - low) / 2.0 / truth[name],
            "off": p.value / truth[name] - 1.0,
            "status": p.status,
            "lines": {line: shares[line] for line in LINES if line in shares},
        }
    return {"parameters": out}


def tables(rows: Sequence[Row]) -> list[str]:
    """How many intervals hold, and how wide they are."""
    good = [
        r for r in rows if all("parameters" in r.get(k, {}) for k in ("declared", "undeclared"))
    ]
    lines = [f"{len(good)} rigs fitted both ways, of {len(rows)}", ""]
    lines.append(
        "| parameter | hold, declared | hold, undeclared | half width, declared / undeclared |"
    )
    lines.append("|---|---|---|---|")
    for name in PARAMETERS:
        pairs = [
            [row[way]["parameters"][name] for way in WAYS]
            for row in good
            if all(name in row[way]["parameters"] for way in WAYS)
        ]
        wider = float(np.median([a["half"] / b["half"] for a, b in pairs]))
        cells = [_share([one["holds"] for one in side]) for side in zip(*pairs, strict=True)]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} | {wider:.2f} |")
    for kind in ("all", *SHAPES):
        cells = [_share([h for r in good if kind in ("all", r["shape"]) for h in _held(r[k])])
                 for k in WAYS]  # fmt: skip
        lines.append(f"| {kind} | {cells[0]} | {cells[1]} | |")
    return lines


def _held(scored: Row) -> list[bool]:
    return [one["holds"] for one in scored["parameters"].values()]


def _share(held: Sequence[bool]) -> str:
    return f"{sum(held)} of {len(held)}" + (f" ({np.mean(held):.1%})" if held else "")


def main() -> None:
    """Studies or prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigs", type=int, default=200)
    parser.add_argument("--first", type=int, default=18_000, help="seed of the first rig")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--tables", type=Path)
    chosen = parser.parse_args()
    if chosen.tables:
        print("\n".join(tables(stored(chosen.tables))))
        return
    rows = stored(chosen.out) if chosen.out else []
    done = {row["seed"] for row in rows}
    for seed in range(chosen.first, chosen.first + chosen.rigs):
        if seed in done:
            continue
        rows.append(score(seed))
        if chosen.out:
            with chosen.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    print("\n".join(tables(rows)))


if __name__ == "__main__":
    main()
