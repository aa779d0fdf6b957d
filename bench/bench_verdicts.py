"""Verdicts on speed against the simulated motor driven for long.

    python bench/bench_verdicts.py [MOTORS=200] [FIRST=0] [--jobs 1] [--out FILE] [--table FILE ...]

Draws motors with brush drop, stiction, cogging, windage, a K that falls with current and weak
magnets or high friction, most of them near the lower limit of the speed. The oracle is the same
motor without errors of the measuring chain, after a second at the product's voltage. Two rules are
judged: the product's own, and its limits on speed alone, so that no other limit rejects what the
speed should.

``--out`` keeps a line a motor: the same call goes on where it was stopped, and a larger count adds.
``--table`` only prints what such files hold.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from motorid.acquire.record import capture
from motorid.capture import store
from motorid.errors import MotoridError
from motorid.identify import fit
from motorid.program import Decay, Program, Step, StepKind
from motorid.quality.agreement import Share
from motorid.quality.judge import judge
from motorid.quality.product import Product, load_product, parse
from motorid.quality.verdict import Outcome
from motorid.rig import Rig, load_rig

SPEEDS = ("no_load_speed", "measured_speed")
RULES = ("product", "speed alone")
NO_ERRORS = {
    "heating": 0, "noise": 0, "gain_error": 0, "voltage_gain_error": 0, "offset_error": 0,
    "clock_ppm": 0,
}  # fmt: skip
EDGES = (-8.0, -4.0, -2.0, 0.0, 2.0, 4.0, 8.0)  # in U of the measured speed, beyond the limit
Row = dict[str, Any]


def drawn(number: int) -> dict[str, Any]:
    """One motor: its simulated options."""
    rng = np.random.default_rng([2026, number])
    options: dict[str, Any] = {
        "copper": rng.normal(1.0, 0.02),
        "magnet": rng.normal(1.0, 0.01),
        "friction": float(np.exp(rng.normal(0.0, 0.15))),
        "stiction": rng.uniform(1.0, 2.0),
    }
    if rng.random() < 0.6:
        options["brush_drop"] = rng.uniform(0.1, 1.0)
    if rng.random() < 0.5:
        options["cogging"] = rng.uniform(0.0, 4e-4)
    if rng.random() < 0.4:
        options["quadratic"] = rng.uniform(0.0, 4e-10)
    if rng.random() < 0.4:
        options["reaction"] = rng.uniform(0.0, 0.1)
    return {name: f"{value:.6g}" for name, value in options.items()}


def specimen(rig: Rig, options: dict[str, Any], **more: Any) -> Rig:
    """The rig with that motor in it."""
    return replace(rig, port=f"{rig.port}&speed=max&{urlencode({**options, **more})}")


def in_the_end(rig: Rig, product: Product, options: dict[str, Any], folder: Path) -> float:
    """rad/s at the product's voltage, per volt as measured without errors."""
    steps = (
        Step(StepKind.COAST, 0.01),
        Step(StepKind.DRIVE_VOLTS, 1.0, product.voltage_v, Decay.SYNCHRONOUS_SLOW),
    )
    exact = specimen(rig, options, **NO_ERRORS)
    run = store.load(
        capture(exact, Program(steps), folder / "long.h5", force=True, serial="D000000")
    )
    position, volts = run.get("position"), run.get("terminal_voltage")
    assert position is not None
    assert volts is not None
    late = run.time_s > 0.6
    speed = float(np.polyfit(run.time_s[late], position.values[late], 1)[0])
    return speed * product.voltage_v / float(volts.values[late].mean())


def products() -> dict[str, Product]:
    """The product, and the same with its limits on speed alone."""
    own = load_product("sim-disc")
    head = own.text[: own.text.index("[limits.")]
    limit = own.limits["measured_speed"]
    table = f"low = {limit.low}\nhigh = {limit.high}\n"
    alone = head + "".join(f"[limits.{n}]\n{table}" for n in SPEEDS)
    return dict(zip(RULES, (own, parse(alone)), strict=True))


def one(number: int) -> Row:
    """What was said of one motor, and its true speed."""
    rig, judged_by = load_rig("sim-line"), products()
    own = judged_by["product"]
    options = drawn(number)
    row: Row = {"motor": number, "options": options}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        row["true"] = in_the_end(rig, own, options, folder)
        try:
            path = capture(
                specimen(rig, options, seed=number + 1, board=11), own.program, folder / "run.h5",
                serial=f"D{number:06d}",
            )  # fmt: skip
            estimate = fit([store.load(path)], model="six")
        except MotoridError as error:
            return row | {"failure": str(error)}
    verdicts = {rule: judge(estimate, product) for rule, product in judged_by.items()}
    u = [verdicts["speed alone"][n].reading.uncertainty for n in SPEEDS]
    outcomes: Row = {rule: str(verdict.outcome) for rule, verdict in verdicts.items()}
    outcomes["invalid"] = [
        m.quantity for m in verdicts["speed alone"].measurements if m.outcome is Outcome.INVALID
    ]
    return row | outcomes | {"u": max((x for x in u if x), default=None)}


def kept(path: Path | None) -> dict[int, Row]:
    """The rows of a file that was begun, by motor; a line that was cut short is left out."""
    found: dict[int, Row] = {}
    if path is None or not path.exists():
        return found
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            row = json.loads(line)
        except json.JSONDecodeError:
            continue
        found[row["motor"]] = row
    return found


def made(numbers: Sequence[int], jobs: int) -> Iterator[Row]:
    """A row a motor, as they finish."""
    if jobs == 1:
        yield from map(one, numbers)
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=jobs, return_as="generator_unordered")
    yield from pool(delayed(one)(number) for number in numbers)


def main(arguments: list[str]) -> int:
    """Prints the table; exit code 1 where a motor beyond a limit by more than 2 U passes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("motors", type=int, nargs="?", default=200)
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, help="a line a motor; goes on where it was stopped")
    parser.add_argument("--table", type=Path, nargs="*", help="only print what these files hold")
    asked = parser.parse_args(arguments)
    if asked.table is not None:
        rows = [row for path in asked.table for row in kept(path).values()]
    else:
        rows = _run(range(asked.first, asked.first + asked.motors), asked.out, asked.jobs)
    limit = load_product("sim-disc").limits["measured_speed"].low
    return max(report(rows, rule, limit) for rule in RULES)


def _run(numbers: Sequence[int], out: Path | None, jobs: int) -> list[Row]:
    rows = kept(out)
    missing = [number for number in numbers if number not in rows]
    for row in made(missing, jobs):
        rows[row["motor"]] = row
        if out is not None:
            with open(out, "a", encoding="utf-8") as file:
                file.write("\n" * _cut(out) + json.dumps(row) + "\n")
    return [rows[number] for number in numbers]


def _cut(path: Path) -> bool:
    """The last line was cut short."""
    return path.read_bytes()[-1:] not in (b"", b"\n")


def report(rows: Sequence[Row], rule: str, limit: float) -> int:
    """Outcomes by how far beyond the limit the true speed is, in U (2 u) of the measured one."""
    print(f"\n{rule}: outcomes by how far the true speed is below {limit:g} rad/s")
    found: dict[int, dict[str, int]] = {}
    escaped = {1.0: 0, 2.0: 0}
    bad = caught = failures = 0
    for row in rows:
        if "failure" in row:
            failures += 1
            print(f"  not fitted: motor {row['motor']}: {row['failure']}")
            continue
        beyond = (limit - row["true"]) / (2.0 * (row["u"] or 1.0))
        counts = found.setdefault(
            int(np.searchsorted(EDGES, beyond)), dict.fromkeys(map(str, Outcome), 0)
        )
        counts[row[rule]] += 1
        passed = row[rule] == str(Outcome.PASS)
        bad, caught = bad + (beyond > 0.0), caught + (beyond > 0.0 and not passed)
        for far in escaped:
            escaped[far] += passed and beyond > far
        if passed and beyond > 1.0:
            print(f"  escaped by {beyond:.1f} U: {row['true']:.1f} rad/s, {row['options']}")
    for place in sorted(found):
        low = f"{EDGES[place - 1]:g}" if place else "-inf"
        high = f"{EDGES[place]:g}" if place < len(EDGES) else "inf"
        counts = ", ".join(f"{n} {o}" for o, n in found[place].items())
        print(f"  {low:>4} to {high:>4} U   {counts}")
    named = Counter(name for row in rows for name in row.get("invalid", ()))
    if named:
        print("  INVALID by " + ", ".join(f"{name} {n}" for name, n in named.most_common()))
    power = Share(caught, bad)
    low_, high_ = (100.0 * x for x in power.interval_95)
    print(f"  {len(rows)} motors, {failures} not fitted")
    print(
        f"  below the limit: {bad}, not passed {caught} (95 % interval {low_:.1f} to {high_:.1f} %)"
    )
    print(f"  passed beyond the limit by more than U: {escaped[1.0]}, 2 U: {escaped[2.0]}")
    return int(escaped[2.0] > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
