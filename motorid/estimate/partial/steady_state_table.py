"""The fit of steady points without an order in time: a maker's table of speed, torque and current.

    V = R i + K ω        T_load = K i − B ω − T0

Both are fitted as straight lines by least squares. The first bends where the winding warms
(``table_warming``). Each of its three columns is noisy, and nobody says how much: the elementary
regressions, with each column in turn as the only noisy one, bound the answer (R. Frisch,
Statistical confluence analysis by means of complete regression systems, Oslo 1934). At one supply
voltage current and speed lie on a line of their own, and B cannot be told from K and T0: it is
taken as 0 in the torque's slope with the current, which is K.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.errors import DataError, UsageError
from motorid.estimate.effects.brush_and_heating import WARMING
from motorid.estimate.partial.mechanical_results import Judge, Quantity, fixed, unknown
from motorid.estimate.partial.table_warming import Warming, line, of_slopes, warming
from motorid.estimate.results.estimate import PARAMETERS, UNITS, Diagnostic, Estimate, Parameter
from motorid.estimate.uncertainty.budget import COLUMNS, INSTRUMENTS
from motorid.estimate.uncertainty.covariance import NOISE
from motorid.estimate.uncertainty.unstated_gains import PART, gains_of, moved
from motorid.version import __version__

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]

FEWEST_POINTS = 8
APART = 0.05  # relative difference of the two K's that is worth saying
STRAIGHT = 1e-3  # scatter of the torque about a line, relative to its range
WHY = "steady points show no dynamics and no friction of their own; a run from rest with voltage, "
WHY += "current and speed, and a coast-down, would determine it"


def suits(captures: Sequence[Capture]) -> bool:
    """Whether all captures are tables of steady points."""
    return bool(captures) and all(c.provenance.get("static") is True for c in captures)


def fit(captures: Sequence[Capture], *, fix: Mapping[str, float] | None = None) -> Estimate:
    """R and K, as far as the volts, current, speed and torque of steady points tell them.

    Raises DataError where there are too few points, or neither volts nor torque; UsageError on an
    unknown name.
    """
    for name in fix or {}:
        if name not in PARAMETERS:
            raise UsageError(f"{name!r} is not a parameter: {', '.join(PARAMETERS)}")
    columns = {name: _joined(captures, name) for name in (CURRENT, SPEED, VOLTAGE, TORQUE)}
    points = len(columns[CURRENT])
    if points < FEWEST_POINTS:
        raise DataError(
            f"steady points need at least {FEWEST_POINTS} rows with a current: map more of the "
            "table, or map time if its rows follow each other"
        )
    judge = Judge(points - 2)
    shifted = list(_shifted(captures, columns))
    warmed = warming(columns, [len(capture) for capture in captures])
    electrical, open_of = _electrical_with(warmed, columns, shifted)
    torque = _with_instrument(_torque, columns, shifted)
    if electrical and torque:  # two ways to K: their difference is a systematic uncertainty
        apart = abs(electrical["K"].value - torque["K"].value) / 2
        both = float(np.hypot(torque["K"].instrument, apart))
        torque["K"] = replace(torque["K"], instrument=both)
    if not electrical and not torque:
        raise DataError("steady points need voltage and speed for R and K, or torque for K")
    found = {name: unknown(name, UNITS[name], WHY) for name in PARAMETERS}
    found |= _judged(judge, {**electrical, **torque})
    combinations = {}
    if torque and electrical:
        combinations["Ke"] = judge.parameter(
            "Ke", "V·s/rad", electrical["K"], "back-EMF constant, from volts and speed"
        )
    found |= {name: fixed(name, UNITS[name], value) for name, value in (fix or {}).items()}
    return Estimate(
        model="V = R i + K ω; T = K i − T0 (steady points, B neglected)",
        method="least squares",
        parameters=found,
        combinations=combinations,
        derived={},
        nuisance={},
        free=(),
        correlation=np.zeros((0, 0)),
        chi_square=0.0,
        degrees_of_freedom=points - 2,
        evaluations=1,
        diagnostics=(
            *_of_warming(warmed, open_of, electrical),
            *_apart(electrical, torque),
            *_too_straight(columns),
            *_undeclared(shifted),
            *_notes(captures),
        ),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix or {})},
        versions={"motorid": __version__, "numpy": np.__version__},
        budget=_budget(electrical, torque, open_of),
        not_stated={
            gain: moved(found, _judged(judge, _solved(columns, name, warmed)))
            for gain, name in gains_of(captures, columns).items()
        },
    )


def _electrical_with(
    warmed: Warming | None, columns: Columns, shifted: Sequence[Columns]
) -> tuple[dict[str, Quantity], dict[str, dict[str, float]]]:
    """R and K with what warming does to them, and what that and the columns' noise leave open of
    each (SI), by cause.
    """
    cold = (lambda other: other) if warmed is None else warmed.cold
    found = _with_instrument(lambda other: _electrical(cold(other)), columns, shifted)
    if not found:
        return {}, {}
    noisy = _by_columns(cold(columns))
    lines = {name: {COLUMNS: noisy[name]} for name in found}
    if warmed is not None:
        warm, found = warmed.lines(columns, _electrical), _told(warmed, found)
        lines = {name: {WARMING: warm[name], **own} for name, own in lines.items()}
    return {
        name: replace(q, instrument=float(np.hypot(q.instrument, _total(lines[name]))))
        for name, q in found.items()
    }, lines


def _told(warmed: Warming, found: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """As uncertain as the rows leave them beside a rise; instruments move them as they did."""
    told = warmed.quantities(found)
    return {name: replace(told[name], instrument=q.instrument) for name, q in found.items()}


def _of_warming(
    warmed: Warming | None,
    open_of: Mapping[str, Mapping[str, float]],
    electrical: Mapping[str, Quantity],
) -> tuple[Diagnostic, ...]:
    if warmed is None or not open_of:
        return ()
    return tuple(warmed.remarks(open_of["R"][WARMING], electrical["R"].value))


def _by_columns(columns: Columns) -> dict[str, float]:
    """What is open of R and K (SI), as nobody says which column is noisy: the answers of the three
    regressions lie as far apart as a uniform distribution is wide.
    """
    current, speed, volts = columns[CURRENT], columns[SPEED], columns[VOLTAGE]
    (by_volts, by_speed), _ = line(current, volts, -speed)
    (R, K), _ = line(volts, current, speed)
    (upon_volts, upon_current), _ = line(speed, volts, -current)
    each = {
        "R": (1.0 / by_volts, R, upon_current / upon_volts),
        "K": (by_speed / by_volts, K, 1.0 / upon_volts),
    }
    return {name: float(np.ptp(values)) / math.sqrt(3.0) for name, values in each.items()}


def _total(lines: Mapping[str, float]) -> float:
    return math.sqrt(sum(u**2 for u in lines.values()))


def _budget(
    electrical: Mapping[str, Quantity],
    torque: Mapping[str, Quantity],
    lines: Mapping[str, Mapping[str, float]],
) -> dict[str, dict[str, float]]:
    """Standard uncertainties (SI) by cause; of K, those of the way that gives it."""
    out = {}
    for name, q in {**electrical, **torque}.items():
        own = lines.get(name, {}) if name not in torque else {}
        declared = float(np.sqrt(max(q.instrument**2 - _total(own) ** 2, 0.0)))
        each = {NOISE: float(np.sqrt(q.variance)), **own, INSTRUMENTS: declared}
        out[name] = {cause: u for cause, u in each.items() if u > 0.0}
    return out


def _solved(columns: Columns, name: str, warmed: Warming | None) -> dict[str, Quantity]:
    """R, K and T0 if a column reads 1 % too much."""
    true = {**columns, name: columns[name] * (1.0 - PART)}
    return _electrical(true if warmed is None else warmed.cold(true)) | _torque(true)


def _joined(captures: Sequence[Capture], name: str) -> Floats:
    """A quantity's points of all captures, or none where one lacks it."""
    channels = [capture.get(name) for capture in captures]
    if any(channel is None for channel in channels):
        return np.zeros(0)
    return np.concatenate([channel.values for channel in channels if channel is not None])


def _shifted(captures: Sequence[Capture], columns: Mapping[str, Floats]) -> Iterator[Columns]:
    """The columns as each declared cause would move them by its standard uncertainty.

    Captures share their instruments: one cause moves all of them together.
    """
    for name, values in columns.items():
        if not len(values):
            continue
        for key, sizes in (("gain_uncertainty", values), ("offset_uncertainty", None)):
            declared = [
                np.full(len(capture), getattr(capture.channels[name], key)) for capture in captures
            ]
            shift = np.concatenate(declared) * (1.0 if sizes is None else sizes)
            if shift.any():
                yield {**columns, name: values + shift}


def _with_instrument(
    solve: Callable[[Columns], dict[str, Quantity]], columns: Columns, shifted: Sequence[Columns]
) -> dict[str, Quantity]:
    """The quantities with what each cause does to them, causes independent of each other."""
    found = solve(columns)
    moved = [solve(other) for other in shifted]
    return {
        name: replace(
            q, instrument=float(np.sqrt(sum((m[name].value - q.value) ** 2 for m in moved if m)))
        )
        for name, q in found.items()
    }


def _undeclared(shifted: Sequence[Columns]) -> tuple[Diagnostic, ...]:
    """Without a declared uncertainty the intervals say less than they seem to."""
    if shifted:
        return ()
    return (
        Diagnostic(
            "no_instrument_uncertainty",
            "info",
            "No uncertainty of gain or offset is declared for these points, so the intervals hold "
            "their scatter and the winding's warming only; import them with --gain-uncertainty, "
            "such as current=0.005.",
        ),
    )


def _judged(judge: Judge, quantities: Mapping[str, Quantity]) -> dict[str, Parameter]:
    return {name: judge.parameter(name, UNITS[name], q) for name, q in quantities.items()}


def _electrical(columns: Mapping[str, Floats]) -> dict[str, Quantity]:
    """R and K from i = V/R − (K/R) ω."""
    current, speed, volts = columns[CURRENT], columns[SPEED], columns[VOLTAGE]
    if not len(volts) or not len(speed):
        return {}
    return of_slopes(*line(current, volts, -speed))


def _torque(columns: Mapping[str, Floats]) -> dict[str, Quantity]:
    """K and T0 from T = K i − T0."""
    current, torque = columns[CURRENT], columns[TORQUE]
    if not len(torque):
        return {}
    (K, T0), cov = line(torque, current, -np.ones(len(torque)))
    return {"K": Quantity(float(K), float(cov[0, 0])), "T0": Quantity(float(T0), float(cov[1, 1]))}


def _apart(
    electrical: Mapping[str, Quantity], torque: Mapping[str, Quantity]
) -> tuple[Diagnostic, ...]:
    if not electrical or not torque:
        return ()
    emf, constant = electrical["K"].value, torque["K"].value
    if abs(emf / constant - 1) <= APART:
        return ()
    return (
        Diagnostic(
            "constants_differ",
            "warning",
            f"Volts and speed give K = {emf:.4g} V·s/rad, torque and current {constant:.4g} N·m/A; "
            "in one motor these are equal. Suspect volts that sag under load, or torque that was "
            "not measured at the shaft. K is the latter here.",
        ),
    )


def _too_straight(columns: Mapping[str, Floats]) -> tuple[Diagnostic, ...]:
    """A table whose points lie on a line as well as its digits allow was hardly measured."""
    current, torque = columns[CURRENT], columns[TORQUE]
    if not len(torque):
        return ()
    whole = np.isfinite(current) & np.isfinite(torque)
    current, torque = current[whole], torque[whole]
    scatter = np.std(torque - np.polyval(np.polyfit(current, torque, 1), current))
    if scatter > STRAIGHT * np.ptp(torque):
        return ()
    return (
        Diagnostic(
            "computed_table",
            "warning",
            "Torque and current lie on one straight line to the last digits: these points were "
            "computed or smoothed, so their scatter says nothing of how well the motor is known.",
        ),
    )


def _notes(captures: Sequence[Capture]) -> list[Diagnostic]:
    notes = dict.fromkeys(note for c in captures for note in c.provenance.get("notes", ()))
    return [Diagnostic("import", "info", f"On import: {note}.") for note in notes]
