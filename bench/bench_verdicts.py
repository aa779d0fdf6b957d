"""Verdicts on speed against the simulated motor driven for long.

    python bench/bench_verdicts.py [MOTORS=200] [FIRST=0]

Draws motors with brush drop, stiction, cogging, windage and weak magnets or high friction, most of
them near the lower limit of the speed. The oracle is the same motor without errors of the measuring
chain, after a second at the product's voltage. Two rules are judged: the product's own, and its
limits on speed alone, so that no other limit rejects what the speed should.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np

import motorid
from motorid.acquire.record import capture
from motorid.capture import store
from motorid.errors import MotoridError
from motorid.program import Decay, Program, Step, StepKind
from motorid.quality.judge import judge
from motorid.quality.product import Product, load_product, parse
from motorid.quality.verdict import Outcome
from motorid.rig import Rig, load_rig

SPEEDS = ("no_load_speed", "measured_speed")
NO_ERRORS = {
    "heating": 0, "noise": 0, "gain_error": 0, "voltage_gain_error": 0, "offset_error": 0,
    "clock_ppm": 0,
}  # fmt: skip
EDGES = (-8.0, -4.0, -2.0, 0.0, 2.0, 4.0, 8.0)  # in U of the measured speed, beyond the limit


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


def one(number: int, rig: Rig, products: dict[str, Product], folder: Path) -> dict[str, Any]:
    """What was said of one motor, and its true speed."""
    options = drawn(number)
    true = in_the_end(rig, products["product"], options, folder)
    program = products["product"].program
    path = capture(
        specimen(rig, options, seed=number + 1, board=11), program, folder / "run.h5", force=True,
        serial=f"D{number:06d}",
    )  # fmt: skip
    try:
        estimate = motorid.fit(path, model="six")
    except MotoridError as error:
        return {"true": true, "failure": str(error)}
    verdicts = {name: judge(estimate, p) for name, p in products.items()}
    return {"true": true, "options": options, **verdicts}


def main(arguments: list[str]) -> int:
    """Prints the table; exit code 1 where a motor beyond a limit by more than 2 U passes."""
    count = int(arguments[0]) if arguments else 200
    first = int(arguments[1]) if len(arguments) > 1 else 0
    rig, own = load_rig("sim-line"), load_product("sim-disc")
    head = own.text[: own.text.index("[limits.")]
    alone = head + "".join(f"[limits.{n}]\nlow = 700\nhigh = 850\n" for n in SPEEDS)
    products = {"product": own, "speed alone": parse(alone)}
    with tempfile.TemporaryDirectory() as name:
        rows = [one(k, rig, products, Path(name)) for k in range(first, first + count)]
    return max(report(rows, title, own.limits["measured_speed"].low) for title in products)


def report(rows: list[dict[str, Any]], title: str, limit: float) -> int:
    """Outcomes by how far beyond the limit the true speed is, in U (2 u) of the measured one."""
    print(f"\n{title}: outcomes by how far the true speed is below {limit:g} rad/s")
    escaped = 0
    found: dict[int, dict[str, int]] = {}
    for row in rows:
        if "failure" in row:
            print(f"  not fitted: {row['failure']}")
            continue
        verdict = row[title]
        readings = [verdict[n].reading for n in SPEEDS]
        widths = [2.0 * r.uncertainty for r in readings if r.uncertainty]
        beyond = (limit - row["true"]) / (max(widths) if widths else 2.0)
        place = int(np.searchsorted(EDGES, beyond))
        counts = found.setdefault(place, dict.fromkeys(Outcome, 0))
        counts[verdict.outcome] += 1
        if verdict.outcome is Outcome.PASS and beyond > 1.0:
            escaped += 1
            print(f"  escaped by {beyond:.1f} U: {row['true']:.1f} rad/s, {row['options']}")
    for place in sorted(found):
        low = f"{EDGES[place - 1]:g}" if place else "-inf"
        high = f"{EDGES[place]:g}" if place < len(EDGES) else "inf"
        counts = ", ".join(f"{n} {o}" for o, n in found[place].items())
        print(f"  {low:>4} to {high:>4} U   {counts}")
    print(f"  passed beyond the limit by more than U: {escaped} of {len(rows)}")
    return int(escaped > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
