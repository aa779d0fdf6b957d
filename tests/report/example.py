"""A realistic estimate, built from numbers simulated here: noise, levels, a coast, two parts."""

from __future__ import annotations

import dataclasses
import hashlib
from functools import cache

import numpy as np

from motorid.estimate.results.estimate import (
    Curve,
    Diagnostic,
    Estimate,
    Parameter,
    SegmentRow,
    SteadyRow,
)
from motorid.estimate.results.status import Status
from tests.segment.truth import OPEN, SMALL, Run, drive

RATE_HZ = 10_000.0
LEVELS = (2.0, 4.0, 6.0)
TRUTH = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "B": 2e-7, "J": 3.9e-7, "T0": 2e-4}
UNITS = {"R": "ohm", "L": "H", "K": "N·m/A", "B": "N·m·s/rad", "J": "kg·m²", "T0": "N·m"}
SEGMENTS = (
    ("rest", 0.0, 0.05), ("acceleration", 0.05, 0.13), ("steady", 0.13, 0.35),
    ("acceleration", 0.35, 0.43), ("steady", 0.43, 0.65), ("acceleration", 0.65, 0.73),
    ("steady", 0.73, 0.95), ("coast", 0.95, 1.45),
)  # fmt: skip
FREE = ("R", "L", "K", "B", "J", "T0", "current offset")


def parameter(
    name: str,
    unit: str,
    value: float | None,
    statistical: float = 0.001,
    instrument: float = 0.003,
    **extra: object,
) -> Parameter:
    """An estimated parameter; the two uncertainties are relative."""
    if value is None:
        return Parameter(name, unit, None, None, None, None, None, Status.NOT_IDENTIFIABLE, **extra)
    parts = statistical * abs(value), instrument * abs(value)
    total = float(np.hypot(*parts))
    interval = (value - 1.96 * total, value + 1.96 * total)
    return dataclasses.replace(
        Parameter(name, unit, value, *parts, total, interval, Status.ESTIMATED), **extra
    )


@cache
def simulated(sign: float = 1.0) -> Run:
    steps = [(0.05, 0.0), *((0.3, sign * v) for v in LEVELS), (0.5, OPEN)]
    return drive(SMALL, steps, RATE_HZ)


def curves(seed: int = 3) -> tuple[Curve, ...]:
    rng = np.random.default_rng(seed)
    out = []
    for capture, sign in enumerate((1.0, -1.0)):
        run = simulated(sign)
        time_s = np.arange(len(run.current)) / RATE_HZ
        for channel, unit, truth, sigma in (
            ("current", "A", run.current, 0.004),
            ("position", "rad", run.position, 0.0011),
        ):
            measured = truth + sigma * rng.standard_normal(len(truth))
            out.append(Curve(capture, channel, unit, time_s, measured, truth.copy(), sigma))
    return tuple(out)


def steady() -> tuple[SteadyRow, ...]:
    rows = []
    for capture, sign in enumerate((1.0, -1.0)):
        run = simulated(sign)
        for k, volts in enumerate(LEVELS):
            begin, end = 0.05 + 0.3 * k + 0.2, 0.05 + 0.3 * (k + 1)
            window = slice(int(begin * RATE_HZ), int(end * RATE_HZ))
            current = float(np.mean(run.current[window]))
            rows.append(
                SteadyRow(
                    capture, begin, end, sign * volts, current * 1.004,
                    float(np.mean(run.speed[window])), current,
                )
            )  # fmt: skip
    return tuple(rows)


def estimate(**changes: object) -> Estimate:
    """All six estimated, from two captures; ``changes`` replace fields."""
    shares = {"L": (0.011, 0.004), "B": (0.009, 0.006), "T0": (0.004, 0.005)}
    six = {
        n: parameter(n, UNITS[n], TRUTH[n] * 1.001, *shares.get(n, (0.001, 0.003))) for n in TRUTH
    }
    figures = [
        ("no-load speed", "rad/s", 770.0), ("no-load current", "A", 0.0461),
        ("stall current", "A", 2.308), ("stall torque", "N·m", 0.01772),
        ("mechanical time constant", "s", 0.0172), ("electrical time constant", "s", 69.2e-6),
        ("speed constant Kv", "rad/s/V", 130.2), ("peak efficiency", "1", 0.737),
    ]  # fmt: skip
    rng = np.random.default_rng(5)
    root = rng.standard_normal((len(FREE), 24)) + 1.1 * rng.standard_normal((1, 24))
    base = Estimate(
        model="linear friction",
        method="ml",
        parameters=six,
        combinations={"J/K": parameter("J/K", "kg·m²·A/(N·m)", 5.08e-5, 4e-4, 1e-3)},
        derived={n: parameter(n, u, v) for n, u, v in figures},
        nuisance={
            "current offset": parameter("current offset", "A", 0.0031, 0.02, 0.0),
            "current delay": parameter("current delay", "s", 5.2e-5, 0.01, 0.0),
        },
        free=FREE,
        correlation=np.corrcoef(root),
        chi_square=55_870.0,
        degrees_of_freedom=57_990,
        evaluations=21,
        diagnostics=(
            Diagnostic("residuals_white", "info", "The residuals look like noise everywhere."),
            Diagnostic(
                "correlated_residuals", "warning",
                "The current's residuals are correlated over 1.2 ms while the motor accelerates; "
                "statistical uncertainties were widened by 1.4 for it.",
            ),
        ),
        curves=curves(),
        steady=steady(),
        segments=tuple(SegmentRow(c, *row) for c in (0, 1) for row in SEGMENTS),
        inputs=tuple(
            {
                "path": f"run-{k}.h5",
                "sha256": hashlib.sha256(bytes([k])).hexdigest(),
                "samples": 14_500,
                "serial": "M17",
            }
            for k in (1, 2)
        ),
        options={"fix": {}, "without": [], "method": "ml"},
        versions={"motorid": "0.1.0", "numpy": np.__version__, "wire": "1.0", "file": "1.0"},
    )  # fmt: skip
    return dataclasses.replace(base, **changes)


def partial() -> Estimate:
    """No voltage channel, one run: R, L unknown, K given, and a friction at its bound."""
    whole = estimate()
    needs = "no voltage was measured: capture the terminal voltage too"
    six = dict(whole.parameters)
    six |= {n: parameter(n, UNITS[n], None, note=needs) for n in ("R", "L")}
    six["K"] = Parameter("K", UNITS["K"], 0.0514, None, None, None, None, Status.FIXED)
    six["B"] = Parameter(
        "B", UNITS["B"], 0.0, 1e-8, 0.0, 1e-8, (0.0, 2.3e-8), Status.AT_BOUND,
        "the data ask for none: coast down from a higher speed",
    )  # fmt: skip
    return dataclasses.replace(whole, parameters=six, inputs=whole.inputs[:1], diagnostics=(),
                               curves=whole.curves[:2], steady=(), free=("J", "T0"),
                               correlation=np.array([[1.0, -0.4], [-0.4, 1.0]]))  # fmt: skip
