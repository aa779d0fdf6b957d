"""Suspects: every fault put into simulated captures, and what it is called; false alarms.

python bench/bench_suspects.py                         all motors, one seed, every fault
python bench/bench_suspects.py --part clean --seeds 5  captures without a fault
python bench/bench_suspects.py --part scale            scale errors, by nameplate and by disc
python bench/bench_suspects.py --part cost             what the look costs

Prints a table of what was put in against what was named, and ends with 1 when a goal is missed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import timeit
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.errors import MotoridError
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.diagnosis.suspects import suspects
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Estimate
from motorid.sim.motor import motors
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import CHAIN, COMMANDED, RPM, SCALES, Case, Runs
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, DUTIES, Bench, without_nameplate
from tests.six_parameters import fit

NAMED_GOAL, ALARM_GOAL = 0.9, 0.05
COST_GOAL_S = 0.03
NOTHING, FAILED = "(nothing)", "(no fit)"
ROUGH = "&cogging={cogging:g}&ripple=0.01"  # a fifth of the Coulomb torque; 1 %


def benches(folder: Path, seeds: Sequence[int], only: Sequence[str]) -> Iterator[Bench]:
    """Every motor, program and seed."""
    for motor in motors():
        if not only or any(motor.startswith(name) for name in only):
            for program in (DIRECTIONS, DUTIES):
                for seed in seeds:
                    yield Bench(motor, seed, program, folder)


def named(capture: Capture, scales: bool = False) -> tuple[str, Estimate | None]:
    """The code of the first suspect that a fit of ``capture`` names, and the estimate."""
    try:
        estimate = fit([capture])
    except MotoridError:
        return FAILED, None
    codes = [s.code for s in estimate.suspects if s.strength == "named"]
    hidden = {c.code for c in scale_errors.CAUSES}
    codes = [c for c in codes if (c in hidden) == scales]
    return (codes[0] if codes else NOTHING), estimate


def moved(good: Estimate, bad: Estimate | None) -> tuple[float, float]:
    """The largest relative bias, and the largest in units of half a stated 95 % interval."""
    shifts, widths = [0.0], [0.0]
    for name, p in (bad.parameters if bad is not None else {}).items():
        q = good.parameters.get(name)
        if p.value and p.total and q is not None and q.value:
            shifts.append(abs(p.value / q.value - 1.0))
            widths.append(abs(p.value - q.value) / (1.96 * p.total))
    return max(shifts), max(widths)


def confusion(folder: Path, cases: Sequence[Case], args: argparse.Namespace) -> bool:
    """Puts every case into every bench's capture, and prints what it was called."""
    scales, cases = (
        cases is SCALES,
        [c for c in cases if not args.case or c.name.startswith(tuple(args.case))],
    )
    table: dict[str, Counter[str]] = defaultdict(Counter)
    biased: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for bench in benches(folder, range(1, args.seeds + 1), args.motor):
        runs = Runs(bench)
        good = fit([runs.good])
        for case in cases:
            try:
                code, estimate = named(case.capture(runs), scales)
            except MotoridError as error:  # the rig refuses or trips
                print(f"  {bench.motor} {bench.program} {case.name}: {error}", file=sys.stderr)
                continue
            table[case.name][code] += 1
            if estimate is not None:
                biased[case.name].append(moved(good, estimate))
            if code != case.code:
                print(f"  {bench.motor} {bench.program} seed {bench.seed}: {case.name} -> {code}",
                      file=sys.stderr, flush=True)  # fmt: skip
    good_enough = True
    for case in cases:
        calls = table[case.name]
        total, right = sum(calls.values()), calls[case.code]
        ok = total > 0 and right >= NAMED_GOAL * total
        good_enough &= ok
        others = ", ".join(f"{n} {k}" for k, n in calls.most_common() if k != case.code)
        material = [s >= 0.02 or w >= 1.0 for s, w in biased[case.name]]
        spoiled = f"{sum(material)} of {len(material)}" if material else "-"
        print(
            f"| {case.name} | {case.size} | {spoiled} | {case.code} | {right} of {total} "
            f"| {others or '-'} |{'' if ok else ' MISSED'}",
            flush=True,
        )
    return good_enough


def clean(folder: Path, args: argparse.Namespace) -> bool:
    """Captures without a fault, every second one with cogging and ripple; counts alarms."""
    alarms: Counter[str] = Counter()
    total = 0
    for k, bench in enumerate(benches(folder, range(1, args.seeds + 1), args.motor)):
        rough = ROUGH.format(cogging=0.2 * bench.preset.coulomb_nm)
        for options in ("", rough) if args.both else ((rough,) if k % 2 else ("",)):
            estimate = fit([bench.capture(options)])
            found = [s.code for s in estimate.suspects if s.strength == "named"]
            total += 1
            for code in found[:1]:
                alarms[code] += 1
                print(f"  {bench.motor} {bench.program} seed {bench.seed} {options}: {found}",
                      file=sys.stderr, flush=True)  # fmt: skip
    share = sum(alarms.values()) / total
    ok = share <= ALARM_GOAL
    print(f"{total} captures without a fault: {sum(alarms.values())} alarms ({share:.1%}, at most "
          f"{ALARM_GOAL:.0%}) {dict(alarms) or ''} {'ok' if ok else 'MISSED'}")  # fmt: skip
    return ok


def discs(folder: Path, args: argparse.Namespace) -> bool:
    """Runs without and with a disc as heavy as the rotor, no nameplate: what the pair tells."""
    wrong: dict[str, tuple[str, float, str]] = {
        "counts per turn x 2": (POSITION, 2.0, "speed_scale"),
        "counts per turn x 4": (POSITION, 4.0, "speed_scale"),
        "rpm for rad/s": (POSITION, RPM, "speed_scale"),
        "mA for A": (CURRENT, 1e3, "current_scale"),
        "nothing": (CURRENT, 1.0, NOTHING),
    }
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for bench in benches(folder, range(1, args.seeds + 1), args.motor):
        disc = bench.preset.inertia_kg_m2
        pair = [bench.capture(), bench.capture(f"&load_inertia={disc:g}")]
        for name, (channel, factor, _) in wrong.items():
            bare, loaded = (
                fit([without_nameplate(inject.scaled(c, channel, factor))]).parameters["J"]
                for c in pair
            )
            found = scale_errors.by_disc(bare, loaded, disc, 0.005 * disc)
            table[name][found[0].code if found else NOTHING] += 1
    good = True
    for name, (_, _, code) in wrong.items():
        calls = table[name]
        right = sum(n for k, n in calls.items() if code in k.split(" or "))
        good &= (ok := right >= NAMED_GOAL * sum(calls.values()))
        print(f"| disc: {name} | {dict(calls)} |{'' if ok else ' MISSED'}")
    return good


def cost(folder: Path) -> bool:
    """Seconds that the look takes on captures of about 10,000 samples, beside the fit."""
    good = True
    for motor in ("faulhaber-2338s006s", "pittman-14204s004"):
        runs = Runs(Bench(motor, 1, DUTIES, folder))
        for name, capture in (
            ("clean", runs.good),
            ("current saturated", inject.clip(runs.good, 0.7 * runs.peak_a)),
        ):
            estimate, known, taken = fit([capture]), solved([capture], {}, ()), []
            for _ in range(7):
                begin = timeit.default_timer()
                suspects(*known, estimate.parameters)
                taken.append(timeit.default_timer() - begin)
            whole = min(timeit.repeat(lambda c=capture: fit([c]), number=1, repeat=5))  # type: ignore[misc]
            ok = name != "clean" or min(taken) <= COST_GOAL_S
            good &= ok
            print(f"{motor}, {len(capture)} samples, {name}: fit {1e3 * whole:.0f} ms, "
                  f"look {1e3 * min(taken):.0f} ms {'ok' if ok else 'MISSED'}")  # fmt: skip
    return good


def main() -> int:
    """Runs the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parts = ("chain", "commanded", "scale", "disc", "clean", "cost")
    parser.add_argument("--part", choices=parts, action="append")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--motor", action="append", default=[])
    parser.add_argument(
        "--case", action="append", default=[], help="only cases whose name begins so"
    )
    parser.add_argument("--both", action="store_true", help="clean: each with and without cogging")
    args = parser.parse_args()
    good = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run: dict[str, Callable[[], bool]] = {
            "cost": lambda: cost(folder),
            "clean": lambda: clean(folder, args),
            "chain": lambda: confusion(folder, CHAIN, args),
            "commanded": lambda: confusion(folder, (COMMANDED,), args),
            "scale": lambda: confusion(folder, SCALES, args),
            "disc": lambda: discs(folder, args),
        }
        for part in args.part or parts:
            print(f"\n{part}", flush=True)
            good &= run[part]()
    print(f"\n{'all goals met' if good else 'a goal was missed'}; numpy {np.__version__}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
