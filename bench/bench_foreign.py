"""Other people's logs, one awkward habit each: what the fit makes of them, against the truth.

python bench/bench_foreign.py            the table of docs/import.md
python bench/bench_foreign.py --only jit --runs 5   cases by a part of their name, of so many seeds
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.foreign.cases import CASES, MAPS, MOTOR, Case, logs
from motorid.capture.table import read_table
from motorid.errors import MotoridError
from motorid.estimate.results.estimate import Estimate
from tests.six_parameters import fit


def estimate(case: Case, folder: Path, seed: int = 0) -> Estimate:
    """What the fit says of a case's files."""
    captures = []
    for k, text in enumerate(logs(case, seed)):
        path = folder / f"log-{k}.csv"
        path.write_text(text, encoding="utf-8")
        maps = ["time=t:s", *(MAPS[c] for c in case.columns)]
        captures.append(read_table(path, maps, **case.options))
    return fit(captures, fix=case.fix)


def truths() -> dict[str, float]:
    """Parameters and combinations of the motor."""
    m = asdict(MOTOR)
    R, K, B, J, T0 = (m[n] for n in ("R", "K", "B", "J", "T0"))
    return m | {
        "J/K": J / K, "B/K": B / K, "T0/K": T0 / K, "B/J": B / J, "T0/J": T0 / J,
        "JR/(K²+RB)": J * R / (K**2 + R * B), "K/(K²+RB)": K / (K**2 + R * B),
        "T0·R/K": T0 * R / K, "K·T0/J": K * T0 / J,
        "J/K²": J / K**2, "B/K²": B / K**2,
    }  # fmt: skip


def cells(found: Estimate, told: tuple[str, ...]) -> list[str]:
    """Error in percent, and in units of the 95 % half-width, for each."""
    out = []
    true = truths()
    for name in told:
        p = {**found.parameters, **found.combinations}.get(name)
        if p is None or p.value is None or p.interval_95 is None:
            out.append("—")
            continue
        half = (p.interval_95[1] - p.interval_95[0]) / 2
        off = p.value - true[name]
        out.append(f"{100 * off / true[name]:+.2f} ({abs(off) / half if half else 0:.1f})")
    return out


def main() -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="")
    parser.add_argument("--runs", type=int, default=1)
    chosen = parser.parse_args()
    told: tuple[str, ...] = ()
    for case in CASES:
        if chosen.only in case.name and tuple(case.told) != told:
            told = tuple(case.told)
            print("\n| log | " + " | ".join(told) + " |\n|---|" + "---|" * len(told))
        for seed in range(chosen.runs if chosen.only in case.name else 0):
            with tempfile.TemporaryDirectory() as folder:
                try:
                    row = cells(estimate(case, Path(folder), seed), tuple(case.told))
                except MotoridError as error:
                    row = [str(error)]
            print(f"| {case.name} | " + " | ".join(row) + " |", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
