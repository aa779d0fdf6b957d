"""A current that runs out, or up, with nothing else measured: L/R, and where the current ends.

    i(t) = i0 + (i1 − i0)(1 − exp(−(t − t0) R/L))

A freewheeling current and a locked rotor show this. No voltage says how large R and L are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.partial import exponential_fit
from motorid.estimate.partial.mechanical_results import Judge, Quantity, fixed, unknown
from motorid.estimate.partial.mechanical_signals import noise
from motorid.estimate.results.estimate import PARAMETERS, UNITS, Curve, Diagnostic, Estimate
from motorid.version import __version__

Floats = NDArray[np.float64]

NOTHING_V = 4.0  # standard deviations of a voltage's readings, within which it is none
FEWEST = 12  # readings
CHANGES = 8.0  # standard deviations, or quanta, by which the current must change
BENDS = 4.0  # lengths of a record, beyond which a time constant is none
MISFIT = 4.0  # variance of slow residuals over that of noise, beyond which a remark is due
WHY = "only the current's course is known; add the voltage at the motor's terminals"


def suits(captures: Sequence[Capture]) -> bool:
    """Logs of a current that changes, without a motion, and without a voltage that drives."""
    return bool(captures) and all(_suits(capture) for capture in captures)


def _suits(capture: Capture) -> bool:
    current = capture.get(CURRENT)
    if capture.program is not None or current is None or len(capture) < FEWEST:
        return False
    if capture.provenance.get("static") is True or TORQUE in capture.channels:
        return False
    moves = [capture.channels[n] for n in (SPEED, POSITION) if n in capture.channels]
    if any(np.nanmax(np.abs(np.diff(m.values)), initial=0.0) > 0.0 for m in moves):
        return False
    volts = [capture.channels[n].values for n in (VOLTAGE, SUPPLY) if n in capture.channels]
    return all(_is_none(v) for v in volts)


def _is_none(volts: Floats) -> bool:
    """A voltage (n,) that reads nothing but noise about zero."""
    known = volts[np.isfinite(volts)]
    return not len(known) or float(np.abs(known).max()) <= NOTHING_V * noise(known)


def fit(captures: Sequence[Capture], fix: Mapping[str, float]) -> Estimate:
    """L/R of the captures together; L, or R, where ``fix`` holds the other.

    Raises DataError where the current does not change as one exponential would.
    """
    records = [_record(capture) for capture in captures]
    rise = exponential_fit.rise(records)
    longest = max(record.length_s for record in records)
    tau = float(rise.lags.max())
    deviation = float(np.sqrt(rise.lag_variance))
    if not deviation < tau < BENDS * longest:
        raise DataError(
            "the current shows no exponential in these captures: record a decay or a rise until "
            "it settles, or the voltage as well"
        )
    judge = Judge(rise.freedom)
    clock = max(capture.clock_uncertainty for capture in captures)
    constant = Quantity(tau, rise.lag_variance, tau * clock)
    known = judge.parameter("L/R", "s", constant, "electrical time constant")
    found = {name: unknown(name, UNITS[name], WHY) for name in PARAMETERS}
    for name, value in (("L", tau * fix.get("R", 0.0)), ("R", fix.get("L", 0.0) / tau)):
        if value:
            share = value / tau
            scaled = Quantity(value, rise.lag_variance * share**2, value * clock)
            found[name] = judge.parameter(name, UNITS[name], scaled)
    found |= {name: fixed(name, UNITS[name], value) for name, value in fix.items()}
    combinations = {"L/R": known}
    for k in range(len(captures)):
        label = f"steady current of run {k + 1}" if len(captures) > 1 else "steady current"
        end = Quantity(float(rise.after[k]), float(rise.covariance[rise.place(k), rise.place(k)]))
        combinations[label] = judge.parameter(label, "A", end, signed=True)
    return Estimate(
        model="i = i0 + (i1 − i0)(1 − exp(−(t − t0) R/L))",
        method="output-error least squares, rounding counted once a quantum",
        parameters={name: found[name] for name in PARAMETERS},
        combinations=combinations,
        derived={},
        nuisance={},
        free=("L/R",),
        correlation=np.ones((1, 1)),
        chi_square=float(rise.freedom),
        degrees_of_freedom=rise.freedom,
        evaluations=rise.evaluations,
        diagnostics=_said(rise),
        curves=tuple(
            Curve(k, CURRENT, "A", r.time_s, r.values, y, float(rise.deviations[k]))
            for k, (r, y) in enumerate(zip(records, rise.fitted, strict=True))
        ),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": []},
        versions={"motorid": __version__, "numpy": np.__version__},
    )


def _record(capture: Capture) -> exponential_fit.Record:
    """The current up to where it has run out. Raises DataError where it never changes."""
    channel = capture.channels[CURRENT]
    good = np.isfinite(channel.values) & ~channel.saturated
    time, amperes = capture.time_s[good] - channel.delay_s, channel.values[good]
    least = max(noise(amperes), channel.resolution)
    if len(amperes) < FEWEST or float(np.ptp(amperes)) <= CHANGES * least:
        raise DataError(
            "the current never changes, and nothing else is measured of the motor: record its "
            "voltage and its speed as well"
        )
    return exponential_fit.Record(
        time, amperes, aperture_s=channel.window_s, quantum=channel.resolution
    )


def _said(rise: exponential_fit.Rise) -> tuple[Diagnostic, ...]:
    out = [
        Diagnostic(
            "current_alone", "info",
            "only a current was measured: its course determines L/R. If the rotor turned, its "
            "back-EMF is in that; if diodes carried it, their drop is in where it ends",
        )
    ]  # fmt: skip
    if len(rise.lags) > 1 or rise.wander > MISFIT:
        out.insert(
            0,
            Diagnostic(
                "lack_of_fit", "warning",
                "the current is no single exponential: the rotor turned, diodes cut it off, or "
                "the voltage changed. Cut the import to the decay by --start and --stop",
            ),
        )  # fmt: skip
    return tuple(out)
