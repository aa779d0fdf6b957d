"""What the residuals and the options say about a fit, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Capture
from motorid.estimate.algebra import square
from motorid.estimate.conduction import unclear
from motorid.estimate.identifiability import run_to_add
from motorid.estimate.intervals import Findings, budget_shares
from motorid.estimate.loss import BENT, DROP
from motorid.estimate.readings import EMF, Measured
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.supposed import variances as supposed_of
from motorid.estimate.suspects.where import place
from motorid.estimate.timeline import IRREGULAR
from motorid.estimate.types import Diagnostic, Parameter
from motorid.estimate.uncertainty import autocovariance
from motorid.motor.parameters import Motor, mechanical_time_constant
from motorid.segment import Segment

Floats = NDArray[np.float64]

LACK_OF_FIT = 1.5  # residuals in units of the declared noise
HALF = 0.5  # of a variance, from which one cause is most of it
COLOURED = 1.3  # widening of an interval that is worth saying
INSEPARABLE = 0.98  # correlation
WORTH_SEPARATING = 0.01  # relative statistical uncertainty
IMPROVE = {  # what to do about a cause
    "noise": "take more runs or livelier ones",
    "current gain": "calibrate the current's gain (motorid calibrate)",
    "voltage gain": "calibrate the voltage's gain (motorid calibrate)",
    "encoder or speed gain": "calibrate the encoder's counts or the speed's gain",
    "clock": "calibrate the board's clock (motorid calibrate)",
    "current delay": "measure the delay of the current's channel",
    "voltage delay": "measure the delay of the voltage's channel",
    "voltage resolution": "measure the voltage with a finer converter or a smaller range",
    "wiring resistance": "measure the leads' and the bridge's resistance",
}
WORDS = {EMF: "back-EMF while coasting"}


def declared_noise(m: Measured) -> float:
    """Standard deviation that the channel declares for a reading, quantisation included; 0: none.

    A declared noise is that of a reading as it comes, with the quantisation in it.
    """
    step = m.channel.resolution / np.sqrt(12.0)
    return float(max(m.channel.noise, step)) if m.channel.noise > 0 else 0.0


def chi_square(solution: Solution, records: Sequence[MotorRecord]) -> tuple[float, int]:
    """Squared residuals over the declared noise, or over the noise found where none is declared.

    With it its degrees of freedom: the same readings, each in full, less all unknowns.
    """
    total = count = 0.0
    for record, own in zip(records, solution.own, strict=True):
        left = record.weighed(record.departures(solution.values, own), filtered=False)
        for m, r in zip(record.measured, left, strict=True):
            noise = declared_noise(m)
            total += square(r) / noise**2 if noise else m.block.count
            count += m.block.count
    return total, round(count) - solution.unknown_count


def diagnostics(
    found: Findings,
    records: Sequence[MotorRecord],
    parameters: Mapping[str, Parameter],
    named: Sequence[tuple[Capture, Sequence[Segment]]] = (),
) -> tuple[Diagnostic, ...]:
    """Findings about data and fit, the gravest first. ``named``: the captures' segments."""
    out: list[Diagnostic] = []
    coloured: dict[str, list[float]] = {}
    if not found.solution.converged:
        out.append(
            Diagnostic(
                "not_converged", "error",
                "the search did not settle: the values are not the most likely ones",
            )
        )  # fmt: skip
    for k, (record, own) in enumerate(zip(records, found.solution.own, strict=True)):
        where = f" in run {k + 1}" if len(records) > 1 else ""
        left = record.weighed(record.departures(found.solution.values, own), filtered=False)
        segments = named[k][1] if named else ()
        for m, residual in zip(record.measured, left, strict=True):
            out += _block(record, m, residual, segments, where)
            coloured.setdefault(m.block.name, []).extend(_memory(residual))
        out += _data(record, where)
    out += [_coloured(name, rhos) for name, rhos in coloured.items() if rhos]
    out += _stopping(records)
    out += _standing(records)
    out += _statistics(found)
    out += _budget(found, parameters)
    out += _brushes(found, records)
    pairs = _inseparable(found, parameters)
    out += _told_apart(pairs)
    unknown = [n for n, p in parameters.items() if p.status == "not_identifiable"]
    doubtful = [*unknown, *(n for a, b, _ in pairs for n in (a, b))]
    out += _run_to_add([n for n in parameters if n in doubtful], found.motor(), records)
    order = {"error": 0, "warning": 1, "info": 2}
    return tuple(sorted(out, key=lambda d: order[d.severity]))


def _brushes(found: Findings, records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where R is as uncertain as it is because nobody said what the brushes drop."""
    if "R" not in found.names:
        return []
    k = found.names.index("R")
    supposed = sum(float(supposed_of(found.solution, records, n)[k]) for n in (DROP, BENT))
    instrument = sum(float(shift[k]) ** 2 for shift in found.causes.values())
    if supposed <= HALF * (float(found.statistical.covariance[k, k]) + instrument):
        return []
    declared = all(record.capture.wiring.brush_drop_v is not None for record in records)
    remedy = "add a level" if declared else "declare it (brush_drop_v of the rig), or add a level"
    return [
        Diagnostic(
            "drop_or_resistance", "info",
            "most of R's uncertainty is what its brushes may drop: at one level these data do not "
            f"tell the two apart; {remedy}",
        )
    ]  # fmt: skip


def _block(
    record: MotorRecord, m: Measured, residual: Floats, segments: Sequence[Segment], where: str
) -> list[Diagnostic]:
    out = []
    name = WORDS.get(m.block.name, m.block.name)
    sigma = float(np.sqrt(square(residual) / m.block.count))
    noise, unit = declared_noise(m), m.channel.unit
    if noise and sigma > LACK_OF_FIT * noise:
        mostly = place(record, m, residual, segments)
        out.append(
            Diagnostic(
                "lack_of_fit", "warning",
                f"the {name} departs from the model by {sigma:.3g} {unit} rms{where}, "
                f"{sigma / noise:.1f} times its declared noise"
                f"{f', {mostly}' if mostly else ''}: the model lacks something",
            )
        )  # fmt: skip
    return out


def _memory(residual: Floats) -> list[float]:
    """The correlation of neighbours, where it stands out."""
    lags = autocovariance(residual, 1)
    rho = float(lags[1] / lags[0]) if lags[0] > 0 else 0.0
    return [rho] if abs(rho) > max(0.1, 4.0 / np.sqrt(len(residual))) else []


def _coloured(name: str, rhos: Sequence[float]) -> Diagnostic:
    """One sentence for all runs."""
    size = f"{rhos[0]:+.2f}" if len(rhos) == 1 else f"{min(rhos):+.2f} to {max(rhos):+.2f}"
    runs = f" in {len(rhos)} runs" if len(rhos) > 1 else ""
    return Diagnostic(
        "coloured_residuals", "info",
        f"neighbouring residuals of the {WORDS.get(name, name)} are correlated ({size}){runs}; "
        "the intervals allow for it",
    )  # fmt: skip


def _data(record: MotorRecord, where: str) -> list[Diagnostic]:
    out = []
    lost = record.timeline.lost
    if lost:
        out.append(
            Diagnostic(
                "lost_samples", "warning",
                f"{lost} of {len(record.capture) + lost} samples are missing{where}; the fit "
                "passes over them, with the voltage taken from their neighbours",
            )
        )  # fmt: skip
    if record.timeline.past is not None and record.timeline.jitter > IRREGULAR:
        out.append(
            Diagnostic(
                "irregular_stamps", "info",
                f"the time stamps are irregular{where}: every reading is compared with the model "
                "at its own stamp",
            )
        )  # fmt: skip
    elif record.timeline.jitter > IRREGULAR:
        out.append(
            Diagnostic(
                "jitter", "warning",
                f"time stamps miss a uniform grid by up to {record.timeline.jitter:.2f} "
                f"periods{where}",
            )
        )  # fmt: skip
    for name in (CURRENT, VOLTAGE):
        channel = record.capture.get(name)
        clipped = int(channel.saturated.sum()) if channel is not None else 0
        if clipped:
            out.append(
                Diagnostic(
                    "saturated", "warning",
                    f"{clipped} readings of the {name.replace('_', ' ')} are at the end of its "
                    f"converter's range{where} and are left out",
                )
            )  # fmt: skip
    raw = [
        p for p, s in zip(record.timeline.parts, record.sources, strict=True)
        if (s is None or s.as_read) and not p.open
    ]  # fmt: skip
    if raw and record.sensed.resolution:
        out.append(
            Diagnostic(
                "voltage_readings", "info",
                f"the measured voltage is used reading by reading in {len(raw)} of the driven "
                f"parts{where}: there it does not follow a source behind a resistance",
            )
        )  # fmt: skip
    return out


def _stopping(records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where a diode's current stops, what that hides, and what to do about it."""
    driven = sum(int(record.driven.sum()) for record in records)
    stopped = sum(int(record.timeline.stopped.sum()) for record in records)
    if not stopped:
        return []
    parts = [part for record in records for part in record.timeline.parts]
    levels = sorted({part.level for part in parts if part.discontinuous})
    hidden = sum(
        int(unclear(channel, record.timeline, record.capture.wiring.pwm_hz).sum())
        for record in records
        if (channel := record.capture.get(CURRENT)) is not None
    )
    left_out = (
        f", and the {hidden} readings of a part of the PWM period that nobody knows are left out"
        if hidden
        else ""
    )
    return [
        Diagnostic(
            "discontinuous_current", "info",
            f"the diodes' current stops within the PWM period in {100 * stopped / driven:.0f} % of "
            f"the driven time (levels {', '.join(f'{level:.3g}' for level in levels)}): there its "
            f"mean tells nothing of L{left_out}. A level at full duty, synchronous decay or a "
            "faster PWM would tell more of L",
        )
    ]  # fmt: skip


def _standing(records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where the motor was driven and did not move."""
    parts = [part for record in records for part in record.timeline.parts if part.still]
    if not parts:
        return []
    levels = ", ".join(f"{level:.3g}" for level in sorted({part.level for part in parts}))
    return [
        Diagnostic(
            "standstill", "info",
            f"the motor stands still at levels {levels}, and the fit lets it: breakaway or cogging "
            "may hold it against more than T0. Such a part tells nothing of K, B, J and T0",
        )
    ]  # fmt: skip


def _statistics(found: Findings) -> list[Diagnostic]:
    out = []
    if found.statistical.coloured > COLOURED:
        out.append(
            Diagnostic(
                "widened", "info",
                "correlated residuals widened the intervals by up to "
                f"{found.statistical.coloured:.1f} times",
            )
        )  # fmt: skip
    if not found.statistical.between_runs:
        runs = len(found.solution.records)
        said = "this run only: one run shows" if runs == 1 else "these two runs only: they show"
        out.append(
            Diagnostic(
                "few_runs", "info",
                f"{said} no spread between runs; three or more would enter it in the intervals",
            )
        )  # fmt: skip
    return out


def _inseparable(
    found: Findings, parameters: Mapping[str, Parameter]
) -> list[tuple[str, str, float]]:
    """Pairs that share what is not known of them, where that is worth telling apart."""
    names, covariance = found.names, found.statistical.covariance
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    table = covariance / np.outer(scale, scale)
    loose = [
        p.value is not None and (p.statistical or 0.0) > WORTH_SEPARATING * p.value
        for p in (parameters[n] for n in names)
    ]
    return [
        (names[a], names[b], float(table[a, b]))
        for a in range(len(names))
        for b in range(a + 1, len(names))
        if loose[a] and loose[b] and abs(table[a, b]) > INSEPARABLE
    ]


def _told_apart(pairs: Sequence[tuple[str, str, float]]) -> list[Diagnostic]:
    if not pairs:
        return []
    said = ", ".join(f"{a} and {b} ({correlation:+.3f})" for a, b, correlation in pairs)
    message = f"These data hardly tell apart, by their correlation: {said}."
    return [Diagnostic("inseparable", "info", message)]


def _run_to_add(
    names: Sequence[str], motor: Motor, records: Sequence[MotorRecord]
) -> list[Diagnostic]:
    """The run that would tell what these did not, in the motor's own voltage and time."""
    if not names:
        return []
    volts = max(float(np.abs(record.volts).max()) for record in records)
    periods = [record.timeline.period_s for record in records]
    longest = max(record.timeline.count for record in records) * max(periods)
    tau_s = float(np.clip(mechanical_time_constant(motor), 20 * min(periods), longest))
    return [Diagnostic("run_to_add", "info", run_to_add(names, volts, tau_s))]


def _budget(found: Findings, parameters: Mapping[str, Parameter]) -> list[Diagnostic]:
    """Which cause gives most of each parameter's uncertainty, and what to improve first."""
    by_cause: dict[str, list[tuple[str, float]]] = {}
    for name, shares in budget_shares(found).items():
        total = sum(share**2 for share in shares.values())
        if parameters[name].value is None or total <= 0.0:
            continue
        cause = max(shares, key=lambda c: shares[c])
        by_cause.setdefault(cause, []).append((name, shares[cause] ** 2 / total))
    if not by_cause:
        return []
    first = max(by_cause, key=lambda c: len(by_cause[c]))
    said = "; ".join(
        f"{cause} for {', '.join(f'{n} ({100 * share:.0f} %)' for n, share in names)}"
        for cause, names in sorted(by_cause.items(), key=lambda item: -len(item[1]))
    )
    remedy = IMPROVE.get(first, f"reduce what is unknown of the {first}")
    message = f"Largest part of each variance: {said}. To narrow most, {remedy}."
    return [Diagnostic("budget", "info", message)]
