"""Our fit against two peers on one problem, in one run: ratios of time, and the same minimum.

python bench/bench_fit_speed.py [--archimedes VENV]
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
sys.path.insert(0, str(HERE / "peers"))

import problem  # noqa: E402


def peer(python: str, script: str, *args: str) -> dict[str, Any]:
    """One peer's fit in a process of its own: {seconds, evaluations, parameters}."""
    run = subprocess.run(
        [python, str(HERE / "peers" / script), *args], capture_output=True, text=True, check=True
    )
    return json.loads(run.stdout.strip().splitlines()[-1])


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
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    data = problem.make()
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "problem.npz")
        np.savez(path, **data)
        ours = [peer(sys.executable, "motorid_fit.py", path) for _ in range(options.repeats)]
        ours.sort(key=lambda fit: fit["seconds"])
        best = ours[len(ours) // 2]
        report("motorid (same start)", best, best["seconds"], data)
        for rtol in ("1e-3", "1e-4", "1e-5", "1e-6"):
            fits = [peer(sys.executable, "lsoda_fit.py", path, rtol) for _ in range(3)]
            fits.sort(key=lambda fit: fit["seconds"])
            report(f"LSODA, rtol {rtol}", fits[1], best["seconds"], data)
        if options.archimedes:
            python = str(Path(options.archimedes) / "bin" / "python")
            report(
                "archimedes 0.5.0 pem",
                peer(python, "archimedes_fit.py", path),
                best["seconds"],
                data,
            )


main()
