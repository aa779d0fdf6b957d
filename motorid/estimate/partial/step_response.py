"""The fit of single steps: how a motor runs up under one constant drive.

    JR/(K² + RB) dω/dt = −ω + (K V − T0 R)/(K² + RB)

One level shows the time constant, and how fast the motor is in the end. Friction and gain are one
there: a second level would separate them. Where nobody logged the drive, the speed alone is fitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import HELD, POSITION, SPEED, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.partial import exponential_fit, mechanical_remarks
from motorid.estimate.partial.levels import single_level, stray_readings
from motorid.estimate.partial.levels.single_level import FEWEST
from motorid.estimate.partial.mechanical_results import (
    CONSTANT,
    FRICTION,
    GAIN,
    Judge,
    Quantity,
    fixed,
    unknown,
)
from motorid.estimate.partial.mechanical_signals import (
    COASTING,
    COMMAND,
    drive_of,
    fresh,
    noise,
    output_of,
)
from motorid.estimate.results.estimate import (
    PARAMETERS,
    UNITS,
    Curve,
    Diagnostic,
    Estimate,
    Parameter,
)
from motorid.version import __version__

Floats = NDArray[np.float64]

ALIKE = 0.02  # relative difference of levels that count as one
MOVES = 4.0  # quanta, of which fewer are no motion
FASTER = 0.5  # of the highest speed, by which a motor without a drive gets faster
SEPARATE = "gain and friction are one at a single level: add a step to another level"
BENDS = 4.0  # lengths of a record, beyond which a time constant is none
FEW = 8  # readings while the speed rises, fewer of which show its course poorly
LEAST = 2  # such readings, of which fewer show no time constant at all
BEGIN, STEADY = 3, 0.1  # first readings, and the part of the steady speed that they may lack
OFTEN = 5.0  # times as often, where they do not say how fast the motor is
BETWEEN = "the speed rose between two readings: a log that is sampled faster would determine it"
RISING = 3.0  # time constants of a rise
LATE = 3.0  # samples of a dead time that is worth a word
MISFIT = 2.0  # residual variance over that of noise and rounding


@dataclass(frozen=True)
class Step:
    """A capture with one level of its drive; ``onset_s``: (when, to within ±), None: it is not in
    the record. ``level`` None: no drive was logged. ``after``: readings behind the level's end,
    which are not in the record. ``strays``: speeds at its start that are not in the record either.
    """

    capture: Capture
    level: float | None
    onset_s: tuple[float, float] | None
    record: exponential_fit.Record
    after: int = 0
    strays: tuple[float, ...] = ()


def steps(captures: Sequence[Capture]) -> list[Step] | None:
    """The captures as single steps to one level; None where they are anything else."""
    found = []
    for capture in captures:
        step = _step(capture)
        if step is None:
            return None
        found.append(step)
    levels = [abs(step.level) for step in found if step.level is not None]
    if len(levels) not in (0, len(found)) or not found:
        return None
    if levels and max(levels) - min(levels) > ALIKE * max(levels):
        return None
    return found


def _step(capture: Capture) -> Step | None:
    output = output_of(capture)
    drive = drive_of(capture.channels) or COASTING
    if output is None or drive not in (VOLTAGE, COMMAND, COASTING) or capture.program is not None:
        return None
    good = np.isfinite(output.values) & ~output.saturated
    time = capture.time_s - output.delay_s
    level, onset, after = None, None, 0
    if drive != COASTING:
        known = single_level.level_of(capture.time_s, capture.channels[drive].values)
        if known is None:
            return None
        level, onset, until_s = known
        after = int((capture.time_s >= until_s).sum())
        good &= capture.time_s < until_s
    gear = capture.wiring.gear_ratio or 1.0
    values = gear * output.values
    kept = fresh(np.flatnonzero(good), output, capture.provenance.get(HELD, {}))
    if len(kept) < FEWEST or not float(np.ptp(values[kept])) > MOVES * gear * output.resolution:
        return None
    if drive == COASTING and not _gets_faster(time[kept], values[kept], output.name):
        return None
    stray = np.zeros(len(kept), dtype=np.bool_)
    if onset is not None and output.name == SPEED:
        quantum = gear * output.resolution
        stray = stray_readings.at_start(capture.time_s[kept], values[kept], onset[0], quantum)
    strays = tuple(map(float, values[kept[stray]]))
    kept = kept[~stray]
    record = exponential_fit.Record(
        time[kept],
        values[kept],
        output.name == POSITION,
        output.window_s if output.name == SPEED else 0.0,
        gear * output.resolution,
        None if onset is None else onset[0],
    )
    return Step(capture, level, onset, record, after, strays)


def _gets_faster(time: Floats, values: Floats, name: str) -> bool:
    """A motor whose drive nobody logged is not coasting."""
    speed = values if name == SPEED else np.gradient(values, time)
    part = max(len(speed) // 8, 2)
    head, tail = np.nanmean(speed[:2]), np.nanmean(speed[-part:])
    return bool(abs(float(tail)) - abs(float(head)) > FASTER * float(np.nanmax(np.abs(speed))))


def fit(found: Sequence[Step], fix: Mapping[str, float], without: Sequence[str]) -> Estimate:
    """Time constant, steady speed, and that speed for the drive, from single ``found`` steps."""
    records = [step.record for step in found]
    rise = exponential_fit.rise(records)
    within = rise.constant_s < max(record.period_s for record in records)  # two readings
    if not within and not (
        np.sqrt(rise.constant_variance)
        < rise.constant_s
        < BENDS * max(record.length_s for record in records)
    ):
        raise DataError(
            "the motor gets faster in these captures and does not settle, so that a step shows no "
            "time constant: record until it runs steadily, and map what drives it"
        )
    judge = Judge(rise.freedom)
    linear = _speed_unit(found) == "m/s"
    parameters = {
        name: unknown(name, UNITS[name], "a single step without a current does not determine it")
        for name in PARAMETERS
    }
    parameters |= {name: fixed(name, UNITS[name], value) for name, value in fix.items()}
    left = [r.values - y for r, y in zip(records, rise.fitted, strict=True)]
    return Estimate(
        model="ω = ω0 + (ω1 − ω0)(1 − exp(−(t − t0)/τ))"
        + (", with a second lag" if len(rise.lags) > 1 else ""),
        method="output-error least squares, rounding counted once a quantum",
        parameters={name: parameters[name] for name in PARAMETERS},
        combinations=_combinations(judge, found, rise, linear, "T0" in without),
        derived={},
        nuisance=_dead_times(judge, found, rise),
        free=(CONSTANT,),
        correlation=np.ones((1, 1)),
        chi_square=float(
            sum(((y / s) ** 2).sum() for y, s in zip(left, rise.deviations, strict=True) if s)
        ),
        degrees_of_freedom=rise.freedom,
        evaluations=rise.evaluations,
        diagnostics=tuple(_findings(found, rise, left)),
        curves=_curves(found, rise),
        inputs=tuple(describe(step.capture) for step in found),
        options={"fix": dict(fix), "without": list(without)},
        versions={"motorid": __version__, "numpy": np.__version__},
    )


def _combinations(
    judge: Judge,
    found: Sequence[Step],
    rise: exponential_fit.Rise,
    linear: bool,
    frictionless: bool,
) -> dict[str, Parameter]:
    tau = rise.constant_s
    clock = max(step.capture.clock_uncertainty for step in found)
    constant = Quantity(tau, rise.constant_variance, tau * clock)
    note = "mechanical time constant"
    out = {}
    if len(rise.lags) > 1:
        second = float(rise.lags.min())
        out["second lag"] = judge.parameter(
            "second lag", "s", Quantity(second, rise.lag_variance), "of the winding, or of a filter"
        )
        either = float(np.hypot(constant.instrument, second / np.sqrt(12.0)))
        constant = Quantity(tau - second / 2.0, rise.constant_variance, either)
        note += "; the second lag counts in it if it is the winding's, not if it is a filter's"
    if max(_while_rising(step, rise, k) for k, step in enumerate(found)) < LEAST:
        out = {CONSTANT: unknown(CONSTANT, "s", BETWEEN)}
    else:
        out = {CONSTANT: judge.parameter(CONSTANT, "s", constant, note), **out}
    unit = "m/s" if linear else "rad/s"
    for k, step in enumerate(found):
        label = f" of run {k + 1}" if len(found) > 1 else ""
        speed = abs(float(rise.after[k]))
        gain = _gain(step.capture, (SPEED, POSITION))
        known = Quantity(speed, float(rise.covariance[rise.place(k), rise.place(k)]), speed * gain)
        out[f"steady speed{label}"] = judge.parameter(f"steady speed{label}", unit, known)
    out |= _by_drive(judge, found, rise, unit, frictionless)
    return out


def _by_drive(
    judge: Judge,
    found: Sequence[Step],
    rise: exponential_fit.Rise,
    unit: str,
    frictionless: bool,
) -> dict[str, Parameter]:
    """Steady speed for a unit of the drive: the mean over the steps, by their variances."""
    levels = np.array([step.level for step in found if step.level is not None])
    if not len(levels):
        return {}
    command = drive_of(found[0].capture.channels) == COMMAND
    volt = "1" if command else "V"
    places = [rise.place(k) for k in range(len(found))]
    variances = np.diag(rise.covariance)[places] / levels**2
    weights = 1.0 / variances / (1.0 / variances).sum()
    value = abs(float(weights @ (rise.after / levels)))
    scatter = float(np.ptp(np.abs(rise.after / levels))) if len(levels) > 1 else 0.0
    variance = float(weights @ (variances * weights)) + (scatter / 2.0) ** 2
    name = drive_of(found[0].capture.channels) or COMMAND
    gain = np.hypot(
        _gain(found[0].capture, (SPEED, POSITION)), found[0].capture.channels[name].gain_uncertainty
    )
    known = Quantity(value, variance, value * float(gain))
    if frictionless:
        return {GAIN: judge.parameter(GAIN, f"{unit}/{volt}", known, "gain")}
    whole = "(K−T0·R/V)/(K²+RB)"
    return {
        whole: judge.parameter(whole, f"{unit}/{volt}", known, "steady speed for the drive"),
        GAIN: unknown(GAIN, f"{unit}/{volt}", SEPARATE),
        FRICTION: unknown(FRICTION, volt, SEPARATE),
    }


def _gain(capture: Capture, names: Sequence[str]) -> float:
    return max(capture.channels[n].gain_uncertainty for n in names if n in capture.channels)


def _dead_times(
    judge: Judge, found: Sequence[Step], rise: exponential_fit.Rise
) -> dict[str, Parameter]:
    """From the change of the command to the rise of the speed, where a record shows both."""
    out = {}
    for k, (step, onset) in enumerate(zip(found, rise.onsets, strict=True)):
        if step.onset_s is None or onset is None:
            continue
        output = step.capture.get(SPEED) or step.capture.channels[POSITION]
        stamps = float(np.hypot(step.onset_s[1] / np.sqrt(3.0), output.delay_uncertainty_s))
        late = Quantity(onset - step.onset_s[0], rise.onset_variance(k), stamps)
        name = f"dead time of run {k + 1}" if len(found) > 1 else "dead time"
        note = "from the command to the rise of the speed"
        out[name] = judge.parameter(name, "s", late, note, signed=True)
    return out


def _findings(
    found: Sequence[Step], rise: exponential_fit.Rise, left: Sequence[Floats]
) -> Iterator[Diagnostic]:
    """The gravest first."""
    for k, (step, residual) in enumerate(zip(found, left, strict=True)):
        where = f" in run {k + 1}" if len(found) > 1 else ""
        expected = noise(step.record.values) ** 2 + step.record.quantum**2 / 12.0
        if expected and rise.wander > 1.0 and float(np.mean(residual**2)) > MISFIT * expected:
            yield Diagnostic(
                "lack_of_fit", "warning",
                f"the speed departs from an exponential{where}, by {np.std(residual):.3g} rad/s "
                "rms, more than noise: suspect a drive that was not constant, a load, or friction "
                "that depends on speed. The intervals are widened for it",
            )  # fmt: skip
        onset = rise.onsets[k]
        since = _since(step, onset)
        few = _while_rising(step, rise, k)
        if few < LEAST and _begins_steady(step, float(rise.after[k])):
            yield Diagnostic(
                "no_rise", "warning",
                f"the motor turns steadily{where} before the record begins, which shows no time "
                "constant: record a start from rest",
            )  # fmt: skip
        elif few < FEW:
            told = "they hardly show its course" if few >= LEAST else (
                "they show no time constant, but that it is below "
                f"{1e3 * step.record.period_s:.3g} ms"
            )  # fmt: skip
            often = max(rise.constant_s / FEW, step.record.period_s / OFTEN)
            yield Diagnostic(
                "few_samples", "warning",
                f"only {few} readings were taken while the speed rose{where}, so that {told}: "
                f"sample every {often:.2g} s or faster",
            )  # fmt: skip
        if since[-1] < RISING * rise.constant_s:
            yield Diagnostic(
                "not_settled", "warning",
                f"the record ends {since[-1] / rise.constant_s:.1f} time constants after the rise "
                f"begins{where}, so that the steady speed is extrapolated: record longer",
            )  # fmt: skip
        yield from _late(step, onset, where)
        if step.strays:
            shown = ", ".join(f"{speed:.4g}" for speed in step.strays)
            yield Diagnostic(
                "stray_readings", "warning",
                f"no motor that starts from rest has the first speeds{where} after the drive "
                f"begins ({shown} {_speed_unit(found)}): suspect an encoder's count from before "
                "the start, or an interval of another length. They are not used",
            )  # fmt: skip
        if step.after:
            yield Diagnostic(
                "after_the_step", "info",
                f"{_readings(step.after)} not used: the drive had left its level at the end{where}",
            )  # fmt: skip
    yield from mechanical_remarks.of_captures([step.capture for step in found])


def _readings(count: int) -> str:
    return "one reading is" if count == 1 else f"{count} readings are"


def _speed_unit(found: Sequence[Step]) -> str:
    motion = found[0].capture.get(SPEED) or found[0].capture.channels[POSITION]
    return "m/s" if motion.unit in ("m", "m/s") else "rad/s"


def _since(step: Step, onset: float | None) -> Floats:
    """Seconds since the rise began, (n,)."""
    return step.record.time_s - (step.record.time_s[0] if onset is None else onset)


def _begins_steady(step: Step, steady: float) -> bool:
    """Whether a speed has its steady value from the first readings on."""
    if step.record.is_position or step.onset_s is not None:
        return False
    return abs(float(np.mean(step.record.values[:BEGIN])) - steady) < STEADY * abs(steady)


def _while_rising(step: Step, rise: exponential_fit.Rise, k: int) -> int:
    """Readings of the k-th record that were taken while its speed rose."""
    since = _since(step, rise.onsets[k])
    return int(((since > 0.0) & (since < RISING * rise.constant_s)).sum())


def _late(step: Step, onset: float | None, where: str) -> Iterator[Diagnostic]:
    if step.onset_s is None or onset is None:
        return
    late = onset - step.onset_s[0]
    samples = late / step.record.period_s
    if abs(samples) > LATE:
        yield Diagnostic(
            "dead_time", "info",
            f"the speed begins to rise {1e3 * late:.3g} ms ({samples:.0f} samples) after the "
            f"command{where}: a delay of the drive or of the speed's channel, or breakaway",
        )  # fmt: skip


def _curves(found: Sequence[Step], rise: exponential_fit.Rise) -> tuple[Curve, ...]:
    out = []
    for k, (step, fitted) in enumerate(zip(found, rise.fitted, strict=True)):
        output = step.capture.get(SPEED) or step.capture.channels[POSITION]
        out.append(
            Curve(
                k, output.name, output.unit, step.record.time_s, step.record.values, fitted,
                float(rise.deviations[k]),
            )
        )  # fmt: skip
    return tuple(out)
