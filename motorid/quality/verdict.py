"""Verdicts: measurement, limits and outcome travel together; the whole follows from its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from motorid.errors import EXIT_DATA, EXIT_DONE, EXIT_FAIL_VERDICT
from motorid.quality.guard_band import accepts, conformance, guard_band
from motorid.quality.limits import Limit


class Outcome(StrEnum):
    """INVALID: could not be judged."""

    PASS = "PASS"  # noqa: S105 - a verdict
    FAIL = "FAIL"
    INVALID = "INVALID"


EXIT_OF = {
    Outcome.PASS: EXIT_DONE,
    Outcome.FAIL: EXIT_FAIL_VERDICT,
    Outcome.INVALID: EXIT_DATA,
}


@dataclass(frozen=True)
class Reading:
    """A quantity as measured: value and standard uncertainty in ``unit``.

    ``value`` None: it could not be measured, and ``problem`` says why and what to do.
    """

    unit: str
    value: float | None = None
    uncertainty: float | None = None
    problem: str = ""
    note: str = ""


@dataclass(frozen=True)
class Measurement:
    """One quantity with its limits and its outcome.

    ``guard_band`` is the width kept from each limit; ``conformance`` the probability that the true
    value lies within the limits. ``marginal``: within the limits, but not by the guard band.
    """

    quantity: str
    meaning: str
    limit: Limit
    reading: Reading
    outcome: Outcome
    marginal: bool = False
    guard_band: float = 0.0
    conformance: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Verdict:
    """The judgement of one motor. ``outcome`` follows from ``measurements`` and nothing else."""

    product: str
    serial: str
    measurements: tuple[Measurement, ...]
    inputs: tuple[Mapping[str, Any], ...] = ()  # what the estimate cites of its captures
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def outcome(self) -> Outcome:
        """A bad condition first: it takes the ground from under the rest. Then what failed."""
        return whole(self.measurements)

    @property
    def marginal(self) -> bool:
        """FAIL, and everything that failed did so only by its guard band."""
        failed = [m for m in self.measurements if m.outcome is Outcome.FAIL]
        return self.outcome is Outcome.FAIL and all(m.marginal for m in failed)

    @property
    def exit_code(self) -> int:
        """Of a command that ends with this verdict."""
        return EXIT_OF[self.outcome]

    @property
    def reasons(self) -> tuple[str, ...]:
        """Of every measurement that did not pass and has the whole's outcome; conditions first."""
        decisive = [m for m in self.measurements if m.outcome is self.outcome and m.reason]
        decisive.sort(key=lambda m: not m.limit.condition)
        return tuple(m.reason for m in decisive) if self.outcome is not Outcome.PASS else ()

    def __getitem__(self, quantity: str) -> Measurement:
        for measurement in self.measurements:
            if measurement.quantity == quantity:
                return measurement
        raise KeyError(quantity)


def whole(measurements: Sequence[Measurement]) -> Outcome:
    """PASS when every measurement passes; nothing measured is nothing judged."""
    if not measurements:
        return Outcome.INVALID
    if any(m.limit.condition and m.outcome is not Outcome.PASS for m in measurements):
        return Outcome.INVALID
    outcomes = {m.outcome for m in measurements}
    for outcome in (Outcome.FAIL, Outcome.INVALID):
        if outcome in outcomes:
            return outcome
    return Outcome.PASS


def decide(limit: Limit, reading: Reading, meaning: str) -> Measurement:
    """The measurement judged by its limit's rule."""
    name, value, u = limit.quantity, reading.value, reading.uncertainty
    if value is None or u is None or not u >= 0:
        problem = reading.problem or "it was not measured"
        return Measurement(
            name, meaning, limit, reading, Outcome.INVALID, reason=f"{meaning}: {problem}"
        )
    band = guard_band(u, limit.low, limit.high, limit.rule)
    likely = conformance(value, u, limit.low, limit.high)
    inside = limit.low <= value <= limit.high
    if accepts(value, u, limit.low, limit.high, limit.rule):
        return Measurement(name, meaning, limit, reading, Outcome.PASS, False, band, likely)
    outcome = Outcome.INVALID if limit.condition else Outcome.FAIL
    reason = _reason(limit, value, meaning, inside, reading)
    return Measurement(name, meaning, limit, reading, outcome, inside, band, likely, reason)


def _reason(limit: Limit, value: float, meaning: str, inside: bool, reading: Reading) -> str:
    below = value < limit.low if not inside else value - limit.low < limit.high - value
    side, bound = ("low", limit.low) if below else ("high", limit.high)
    unit = "" if limit.unit == "1" else f" {limit.unit}"
    means = limit.low_means if below else limit.high_means
    said = f"{meaning} {value:.4g}{unit} is too {side} (limit {bound:.4g}{unit})"
    if inside:
        said = f"{meaning} {value:.4g}{unit} is too near its limit {bound:.4g}{unit} (MARGINAL)"
    parts = [said, means, reading.note]
    return ": ".join(part for part in parts if part)
