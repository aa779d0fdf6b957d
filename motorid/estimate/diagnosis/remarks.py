"""What a fit gives to remark on, in sentences: its data, its residuals, what it could not tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.diagnosis import (
    data_remarks,
    input_noise,
    misfit,
    repeating_remarks,
    residual_remarks,
    sampling_remarks,
)
from motorid.estimate.diagnosis.identifiability import run_to_add
from motorid.estimate.effects.brush_and_heating import BENT, DROP
from motorid.estimate.effects.iron.eddies_in_pulses import WITHIN
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.fit import lagging_start
from motorid.estimate.fit.subsample_inductance import PULSES
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.budget import FRICTION, SEARCH, remedy
from motorid.estimate.uncertainty.intervals import Findings, budget_shares
from motorid.motor.parameters import Motor, mechanical_time_constant
from motorid.segment import Segment

Floats = NDArray[np.float64]

HALF = 0.5  # of a variance, from which one cause is most of it
COLOURED = 1.3  # widening of an interval that is worth saying
SHOWN_DESPITE_DROP = 4.0  # sample periods of L/R: longer than what bends within a reading
DROP_IN_R = (
    0.25  # of the drop over the largest current: the most that bench/bench_kit.py's rigs show
)
INSEPARABLE = 0.98  # correlation
EXCLUDED = 9.0  # of chi-square, by which a rival is out of the question
WORTH_SEPARATING = 0.01  # relative statistical uncertainty


def diagnostics(
    found: Findings,
    records: Sequence[MotorRecord],
    parameters: Mapping[str, Parameter],
    named: Sequence[tuple[Capture, Sequence[Segment]]] = (),
) -> tuple[Diagnostic, ...]:
    """Findings about data and fit, the gravest first. ``named``: the captures' segments."""
    out: list[Diagnostic] = []
    coloured: dict[str, list[float]] = {}
    out += _unsettled(found.solution)
    misfits, first = list(out), len(out)
    left = misfit.residuals(records, found.solution)
    driven = input_noise.where_lacking(records, found.solution, left)
    for k, record in enumerate(records):
        where = f" in run {k + 1}" if len(records) > 1 else ""
        segments = named[k][1] if named else ()
        for m, residual, more in zip(record.measured, left[k], driven[k], strict=True):
            lacks = residual_remarks.lack_of_fit(record, m, residual, segments, where, more)
            misfits += lacks
            out += lacks
            coloured.setdefault(m.block.name, []).extend(
                residual_remarks.neighbour_correlation(residual)
            )
        out += data_remarks.of_capture(record, where)
    out[first:first] = _bounded(records, misfits)
    out += lagging_start.remarks([record.capture for record in records])
    out += sampling_remarks.of_logs(found, records)
    out += sampling_remarks.slow_voltage(records, parameters)
    out += [residual_remarks.coloured(name, rhos) for name, rhos in coloured.items() if rhos]
    out += repeating_remarks.allowed_for(records, found.solution)
    out += data_remarks.stopping(records)
    out += data_remarks.standing(records)
    out += _statistics(found)
    out += _budget(found, parameters)
    out += _shared_friction(records)
    out += _brushes(found, records)
    out += _by_ripple(found, records)
    out += _dropping(found, records)
    pairs = _inseparable(found, parameters)
    out += _told_apart(pairs)
    unknown = [n for n, p in parameters.items() if p.status.unknown]
    doubtful = [*unknown, *(n for a, b, _ in pairs for n in (a, b))]
    out += _run_to_add([n for n in parameters if n in doubtful], found.motor(), records)
    order = {"error": 0, "warning": 1, "info": 2}
    return tuple(sorted(out, key=lambda d: order[d.severity]))


def _unsettled(solution: Solution) -> Iterator[Diagnostic]:
    """A search that stopped short of the most likely values: by much, or by what the budget has."""
    if solution.unfinished:
        yield Diagnostic(
            "not_converged", "error",
            "the search did not settle: the values are not the most likely ones",
        )  # fmt: skip
    elif not solution.converged:
        yield Diagnostic(
            "search_unfinished", "info",
            f"the search ended where its quadratic model still promised {solution.promised:.2g} of "
            f'chi-square; the step that is left is the line "{SEARCH}" of the budget',
        )  # fmt: skip


def _shared_friction(records: Sequence[MotorRecord]) -> Iterator[Diagnostic]:
    """Another answer that noise does not exclude, with friction of the other kind."""
    if any(one.friction and one.behind < EXCLUDED for r in records for one in r.rivals):
        yield Diagnostic(
            "friction_shared", "info",
            "these readings hardly separate friction that grows with speed (B) from friction that "
            "does not (T0); the intervals cover answers that share it otherwise, which is the "
            f'line "{FRICTION}" of the budget: {remedy(FRICTION)}',
        )  # fmt: skip


def _bounded(records: Sequence[MotorRecord], misfits: Sequence[Diagnostic]) -> Iterator[Diagnostic]:
    """Starts that were left out, where something is left that another might explain."""
    untried = max(record.untried for record in records)
    if untried and misfits:
        yield Diagnostic(
            "search_bounded", "warning",
            f"the model misfits from every start that was tried; {untried} other "
            f"start{'s were' if untried > 1 else ' was'} left out to bound the work, so a "
            "better fit may exist: check the wiring, the units and what --fix holds",
        )  # fmt: skip


def _brushes(found: Findings, records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where R is as uncertain as it is because nobody said what the brushes drop."""
    shares = budget_shares(found).get("R", {})
    supposed = sum(shares.get(cause, 0.0) ** 2 for cause in (DROP, BENT))
    if supposed <= HALF * sum(u**2 for u in shares.values()):
        return []
    declared = all(record.capture.wiring.brush_drop_v is not None for record in records)
    mend = "add a level" if declared else BRUSH_DROP.remedy
    return [
        Diagnostic(
            "drop_or_resistance", "info",
            "most of R's uncertainty is the unknown brush drop: at one level these data do not "
            f"separate the two; {mend}",
        )
    ]  # fmt: skip


def _by_ripple(found: Findings, records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """An inductance that no reading shows: where its value comes from, and at which frequency."""
    told, motor = records[0].foretold, found.motor()
    if not motor.L or not motor.R:
        return []
    periods = motor.L / motor.R / min(record.timeline.period_s for record in records)
    pulsed = any(part.discontinuous for record in records for part in record.shown_parts)
    if told is None and not (pulsed and periods < WITHIN):
        return []
    by = PULSES if told is None else told.by
    known = "" if told is None else f", to {100 * told.shift['L']:.0f} %"
    return [
        Diagnostic(
            "inductance_by_ripple", "info",
            f"no reading shows how the current rises: L/R is {periods:.2g} sample periods. L is "
            f"known from the current's {by} within the PWM periods{known}: it is that at the PWM "
            "frequency, and eddy currents in iron make it larger for slow changes; for a better "
            f"one {HELD_INDUCTANCE.remedy}",
        )
    ]  # fmt: skip


def _dropping(found: Findings, records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """What a bipolar bridge does to the start of each step: its drop bends where the current turns,
    so that the voltage between the readings is no source behind a resistance.
    """
    motor = found.motor()
    drop = max(record.capture.wiring.bridge_drop_v for record in records)
    periods = motor.L / motor.R / min(record.timeline.period_s for record in records)
    amperes = max(_largest_current(record.capture) for record in records)
    if not drop or not amperes or periods > SHOWN_DESPITE_DROP:
        return []
    moves = {"L": motor.L, "R": DROP_IN_R * drop / amperes}
    return [
        Diagnostic(
            "bridge_drop", "warning",
            f"L/R is {periods:.2g} sample periods, and the bridge drops {drop:g} V that bend in "
            f"a reading: it can move L by its own size and R by {moves['R'] / motor.R:.1%}; use "
            "a bridge of MOSFETs, or a higher sample rate",
            moves=moves,
        )
    ]  # fmt: skip


def _largest_current(capture: Capture) -> float:
    channel = capture.get(CURRENT)
    return 0.0 if channel is None else float(np.nanmax(np.abs(channel.values), initial=0.0))


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
    message = f"These data hardly separate, by their correlation: {said}."
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
    """Of every parameter that came out."""
    shares = budget_shares(found)
    return budget({n: s for n, s in shares.items() if parameters[n].value is not None})


def budget(shares_of: Mapping[str, Mapping[str, float]]) -> list[Diagnostic]:
    """Which cause gives most of each one's uncertainty, and what to improve first.

    ``shares_of`` each name: standard uncertainties by cause.
    """
    by_cause: dict[str, list[tuple[str, float]]] = {}
    for name, shares in shares_of.items():
        total = sum(share**2 for share in shares.values())
        if total <= 0.0:
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
    message = f"Largest part of each variance: {said}. To narrow most, {remedy(first)}."
    return [Diagnostic("budget", "info", message)]
