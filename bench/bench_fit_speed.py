"""Our fit against two peers on one problem, in one run: ratios of time, and the same minimum.

python bench/bench_fit_speed.py [--archimedes VENV] [--repeats 7] [--rtol 1e-3 1e-4 1e-5 1e-6]
(the archimedes environment is made by bench/peers/setup_archimedes.sh VENV)
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
RTOLS = ("1e-3", "1e-4", "1e-5", "1e-6")
sys.path.insert(0, str(HERE / "peers"))

import problem  # noqa: E402


def peer(python: str, script: str, *args: str) -> dict[str, Any]:
    """One peer's fit in a process of its own: {seconds, evaluations, parameters}."""
    run = subprocess.run(
        [python, str(HERE / "peers" / script), *args], stdout=subprocess.PIPE, text=True, check=True
    )
    return json.loads(run.stdout.strip().splitlines()[-1])


def middle(script: str, path: str, *args: str, runs: int) -> dict[str, Any]:
    """The fit of median time, of so many in this Python."""
    fits = [peer(sys.executable, script, path, *args) for _ in range(runs)]
    return sorted(fits, key=lambda fit: fit["seconds"])[runs // 2]


def report(name: str, fit: dict[str, Any], ours: float, data: dict[str, np.ndarray]) -> None:
    """One row: time, ratio to ours, distance from the minimum by the reference integrator."""
    chi = problem.chi_square(fit["parameters"], data)
    print(
        f"{name:<34}{fit['seconds']:>10.4f} s {fit['seconds'] / ours:>9.1f} x"
        f"   chi-square {chi:.3f}   {fit['evaluations']} evaluations"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--archimedes", help="virtual environment that holds archimedes")
    parser.add_argument("--repeats", type=int, default=7, help="of our fit; of a peer's at most 3")
    parser.add_argument("--rtol", nargs="*", default=RTOLS, help="of LSODA, one row each")
    options = parser.parse_args()
    data = problem.make()
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "problem.npz")
        np.savez(path, **data)
        best = middle("motorid_fit.py", path, runs=options.repeats)
        report("motorid (same start)", best, best["seconds"], data)
        for rtol in options.rtol:
            fit = middle("lsoda_fit.py", path, rtol, runs=min(3, options.repeats))
            report(f"LSODA, rtol {rtol}", fit, best["seconds"], data)
        if options.archimedes:
            python = str(Path(options.archimedes) / "bin" / "python")
            report(
                "archimedes 0.5.0 pem",
                peer(python, "archimedes_fit.py", path),
                best["seconds"],
                data,
            )


if __name__ == "__main__":
    main()
