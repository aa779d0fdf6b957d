"""Where a log is sampled too slowly for what it should show, and where its clocks disagree.

And where a board's voltage passes a filter that is too slow for the steps of its program.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.voltage_window import FADED, MOST, Window
from motorid.estimate.uncertainty.intervals import Findings
from motorid.motor.parameters import mechanical_time_constant

FEW = 4.0  # readings in a mechanical time constant, fewer of which show its course poorly
LEAST = 0.01  # of them: no search tells a time constant below that, it ran to an absurd motor
BEYOND = 4.0  # standard deviations of what was expected of a delay
TOLERANCE = 0.05  # of a declared filter's time constant: what capacitors are made to
SHIFT = 2.5  # times a voltage's relative error: what it may do to R, L, K and J
SLOW = 0.1  # of the driven time, in steps that the filter hides


def of_logs(found: Findings, records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Of records without a program."""
    logs = [record for record in records if record.sensed.waveform is not None]
    return [*_few(found, logs), *_late(found, records), *_uneven(logs)] if logs else []


def _uneven(logs: Sequence[MotorRecord]) -> Iterator[Diagnostic]:
    """Rows whose stamps are not when they were read."""
    if any(record.outlying for record in logs):
        yield Diagnostic(
            "uneven_rows", "warning",
            "a few readings, most of them just after steps of the voltage, are off by much more "
            "than the others, and what would explain them makes the others worse: their stamps "
            "may not say when they were read, as where a busy program reads them when it has time. "
            "Log the clock with each reading, or let the hardware time them",
        )  # fmt: skip


def _few(found: Findings, logs: Sequence[MotorRecord]) -> Iterator[Diagnostic]:
    motor = found.motor()
    if not (motor.J > 0.0 and motor.K > 0.0):
        return
    rise_s = mechanical_time_constant(motor)
    period_s = min(record.capture.period_s for record in logs)
    if LEAST * period_s < rise_s < FEW * period_s:
        yield Diagnostic(
            "few_samples", "warning",
            f"the motor follows its voltage within {1e3 * rise_s:.3g} ms, which is "
            f"{rise_s / period_s:.2g} samples: so few readings hardly show how it does, and J, L "
            "and the moments of the steps share what they show. Sample every "
            f"{1e3 * rise_s / 10.0:.2g} ms",
        )  # fmt: skip


def _late(found: Findings, records: Sequence[MotorRecord]) -> Iterator[Diagnostic]:
    """Delays that the data put far beyond what is declared of them, or usual."""
    for k, (record, own) in enumerate(zip(records, found.solution.own, strict=True)):
        where = f" in run {k + 1}" if len(records) > 1 else ""
        for one, unknown, size in zip(record.instances, record.unknowns, own, strict=True):
            off = float(size) - unknown.prior_mean
            if one.quantity.unit != "s" or abs(off) <= BEYOND * unknown.prior_sd:
                continue
            if one in record.found:
                continue  # it is named, with its size
            period_s = record.capture.period_s
            yield Diagnostic(
                "delay_beyond_prior", "warning",
                f"the fit takes {one.quantity.name}{where} to be {1e3 * float(size):.3g} ms "
                f"({abs(float(size)) / period_s:.0f} samples), far beyond the "
                f"{1e3 * unknown.prior_sd:.2g} ms that were expected of it: the channels were "
                "stamped by different clocks, or the column is not what it is mapped to. Declare "
                "the delay (--delay), or check the column",
            )  # fmt: skip


def slow_voltage(
    records: Sequence[MotorRecord], parameters: Mapping[str, Parameter]
) -> Iterator[Diagnostic]:
    """A declared low-pass that remembers for so long that most readings of a step show it.

    What they show beside it rests on the filter's time constant, T: of a reading with the share h
    of the voltage before, an error dT makes h ln(1/h) dT/T. A supply before a step is the same.
    """
    for k, record in enumerate(records):
        window, where = record.sensed.window, f" in run {k + 1}" if len(records) > 1 else ""
        shown = _half_shown(record, window) if window is not None else 0.0
        if window is None or shown <= (MOST if record.sensed.commanded else FADED):
            continue
        error = TOLERANCE * shown * math.log(1.0 / shown) if shown <= MOST else math.inf
        yield Diagnostic(
            "voltage_filter_slow", "warning",
            f"the voltage's declared low-pass of {1e3 * window.filter_s:.3g} ms{where} is too slow "
            f"for the steps: {100 * shown:.0f} % and more of half of a step's readings is the "
            "voltage before it. Take a smaller capacitor on its divider, or longer steps",
            _moves(error, parameters),
        )  # fmt: skip


def _half_shown(record: MotorRecord, window: Window) -> float:
    """The largest share of what was before a step in half of its readings; 0: of few steps."""
    driven = [part.stop - part.start for part in record.timeline.parts if part.level]
    hidden = {count: window.half_shows(count) for count in set(driven)} if window.filter_s else {}
    slow = [count for count in driven if hidden.get(count, 0.0) > FADED]
    return max((hidden[n] for n in slow), default=0.0) if sum(slow) > SLOW * sum(driven) else 0.0


def _moves(error: float, parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """What that relative error of the voltage may do; friction is a small difference of two."""
    sized = {n: SHIFT * error * abs(p.value) for n, p in parameters.items() if p.value is not None}
    return {n: math.inf if n in ("B", "T0") else size for n, size in sized.items()}
