"""What `motorid plan` promises against what the simulated rig gives: every packaged simulated rig.

Each rig is planned from its nameplate, and the plan is run over SEEDS specimens (noise, gain and
clock errors drawn as declared) on simulated time, through the wire and the default fit. Beside each
other, as half widths of 95 % intervals: asked, promised for the worst motor and for this one, the
median that the fits state, and 1.96 times the RMS error against the simulator's truth. Exit code 1
where stated or actual exceeds FACTOR times what was promised for the worst motor.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motorid.acquire.record import capture_all
from motorid.capture import store
from motorid.errors import RigError
from motorid.estimate.uncertainty.intervals import NORMAL_95, POSITIVE
from motorid.plan.propose import Plan
from motorid.rig import Rig, load_rig
from motorid.rig_file import presets
from motorid.sim import truth
from motorid.workflow.plan import plan_run
from motorid.workflow.record import adjusted
from tests.six_parameters import fit

SEEDS = 20
FACTOR = 1.25


@dataclass(frozen=True)
class Row:
    """Half widths of one parameter; as in ``Want``."""

    name: str
    asked: float
    worst: float
    expected: float
    stated: float
    actual: float
    missed: int  # fits that did not give it

    @property
    def kept(self) -> bool:
        """Whether promise and simulated rig agree."""
        return not self.missed and max(self.stated, self.actual) <= FACTOR * self.worst


def confirm(rig: Rig, plan: Plan, seeds: int, folder: Path) -> list[Row]:
    """The plan over so many specimens of the rig's motor."""
    stated: dict[str, list[float]] = {p.want.name: [] for p in plan.promises}
    errors: dict[str, list[float]] = {p.want.name: [] for p in plan.promises}
    for seed in range(1, seeds + 1):
        url = f"{rig.port}&seed={seed}"
        paths = [folder / f"{rig.name}-{seed}-{run}.h5" for run in range(plan.repeats)]
        estimate = fit(
            [store.load(p) for p in capture_all(replace(rig, port=url), plan.program, paths)]
        )
        true = truth(url)
        for name in stated:
            p = estimate.parameters[name]
            if p.value is None or p.total is None:
                continue
            unit = true[name] if name in POSITIVE else 1.0
            stated[name].append(NORMAL_95 * p.total / unit)
            errors[name].append((p.value - true[name]) / unit)
    return [
        Row(
            p.want.name,
            p.want.reach,
            p.reach,
            p.expected,
            float(np.median(stated[p.want.name] or [np.inf])),
            NORMAL_95 * float(np.sqrt(np.mean(np.square(errors[p.want.name] or [np.inf])))),
            seeds - len(stated[p.want.name]),
        )
        for p in plan.promises
    ]


def main() -> int:
    """Prints the table; 1 where a promise was not kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rigs", nargs="*", default=[n for n in presets() if n.startswith("sim")])
    parser.add_argument("--seeds", type=int, default=SEEDS)
    options = parser.parse_args()
    broken = 0
    for name in options.rigs:
        rig = adjusted(load_rig(name), speed="max")
        try:
            plan = plan_run(rig, ())
        except RigError as error:
            print(f"{name}: {error}")
            continue
        print(f"{name}: {plan.repeats} x {plan.program.duration_s:.4f} s, {options.seeds} seeds")
        print(f"{'':>4}{'asked':>10}{'worst':>10}{'this':>10}{'stated':>10}{'actual':>10}")
        with tempfile.TemporaryDirectory() as folder:
            for row in confirm(rig, plan, options.seeds, Path(folder)):
                widths = (row.asked, row.worst, row.expected, row.stated, row.actual)
                mark = "" if row.kept else f"  BROKEN ({row.missed} not given)"
                print(f"{row.name:>4}" + "".join(f"{w:10.3g}" for w in widths) + mark)
                broken += not row.kept
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
