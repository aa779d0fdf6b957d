"""The fit of captures whose electrical side is unknown: what drives the motor against how it turns.

    drive = a dω/dt + b ω + c sign(ω) + d

With a measured torque (or force) a, b, c are J, B, T0; with a measured current and no voltage they
are J/K, B/K, T0/K; with volts, or a command, and no current they are (L neglected) JR/K,
(K² + RB)/K and T0 R/K. With no drive at all the motor must coast: then a is 1, and b and c are B/J
and T0/J. d is a constant load or an offset of the sensor. See docs/import.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, TORQUE, VOLTAGE, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.partial import (
    mechanical_remarks,
    mechanical_results,
    modulating_functions,
    open_circuit_coastdown,
    square_of_speed,
    steady_state_table,
    step_response,
    unstated_lag,
)
from motorid.estimate.partial.block_bootstrap_regression import (
    OFFSET,
    Regression,
    choose_width,
    solve,
)
from motorid.estimate.partial.levels import one_level, steady_speeds
from motorid.estimate.partial.mechanical_signals import (
    COASTING,
    FEWEST_SAMPLES,
    Motion,
    drive_of,
    noise,
    of_capture,
    stands_still,
)
from motorid.estimate.results.estimate import PARAMETERS, Estimate

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

COLUMN_OF = {"J": 0, "B": 1, "T0": 2}
NARROWEST = 4  # half-width of the narrowest bump, in sample periods
FEWEST_ROWS = 10
SURE_SIGN = 1.0  # a magnitude's sign is taken where the model exceeds so many sigma of a reading
SIGN_PASSES = 4
RISE = 0.1  # of the top speed: more is not a coast-down


def suits(captures: Sequence[Capture]) -> bool:
    """Whether these captures lack what the whole model needs: a voltage, a current, or time."""
    return steady_state_table.suits(captures) or any(not _is_electrical(c) for c in captures)


def _is_electrical(capture: Capture) -> bool:
    names = set(capture.channels)
    volts = {VOLTAGE} if capture.program is None else {VOLTAGE, SUPPLY}  # whose duty is known
    return CURRENT in names and bool(names & volts)


def fit(
    captures: Sequence[Capture],
    *,
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
) -> Estimate:
    """The mechanical parameters, or their ratios, that ``captures`` of one motor know together.

    ``fix`` holds parameters at values (K turns ratios into parameters; so does any one of J, B
    and T0); ``without`` leaves B or T0 out, or the offset ("offset"). Raises DataError where the
    captures hold no motion, no drive, or drives of different kinds; UsageError on unknown names.
    """
    known = dict(fix or {})
    _check(known, without)
    if not captures:
        raise DataError("no capture was given: nothing to fit")
    if steady_state_table.suits(captures):
        if steady_speeds.suits(captures):
            return steady_speeds.fit(captures, known)
        return steady_state_table.fit(captures, fix=known)
    if all(open_circuit_coastdown.is_tachometer(capture) for capture in captures):
        return _by_voltage(captures, known, without)
    drive = _common_drive(captures)
    moving = [capture for capture in captures if not stands_still(capture)] or captures[:1]
    single = step_response.steps(moving)
    if single is not None:
        found = step_response.fit(single, known, without)
        return (
            found if len(moving) == len(captures) else _beside(found, len(captures) - len(moving))
        )
    motions = [of_capture(capture, drive) for capture in moving]
    one_level.refuse(motions)
    wanted, values = _wanted(motions, drive, known, without)
    best = _regress(motions, wanted, values)
    if best is None:
        raise DataError(
            "the motor does not turn steadily one way for long enough in these captures: "
            f"at least {FEWEST_ROWS} bumps of {NARROWEST} samples are needed; capture a longer run"
        )
    timing = unstated_lag.looked_for(
        moving, drive, motions, best, lambda others, terms: _regress(others, wanted, values, terms)
    )
    motions = list(timing.motions)

    def beside(terms: Sequence[str]) -> Regression | None:
        return _regress(motions, wanted, values, (*terms, *timing.terms), settled=True)

    best = timing.of((beside(()) if timing.terms else None) or best)
    square = square_of_speed.looked_for(drive, best, beside)
    best = best.widened(*square.moves)
    findings = mechanical_remarks.find(moving, motions, best, timing.said)
    if len(moving) < len(captures):
        findings = (mechanical_remarks.standing_still(len(captures) - len(moving)), *findings)

    def told(found: Regression) -> Estimate:
        estimate = mechanical_results.estimate
        balance = estimate(moving, motions, found, drive, known, without, findings)
        return one_level.settled(balance, drive)

    if square.wider is None:
        return told(best)
    return square_of_speed.named(told(best), told(timing.of(square.wider)), drive)


def _beside(found: Estimate, still: int) -> Estimate:
    """With a word on captures in which the motor does not move."""
    said = mechanical_remarks.standing_still(still)
    return replace(found, diagnostics=(said, *found.diagnostics))


def _by_voltage(
    captures: Sequence[Capture], known: Mapping[str, float], without: Sequence[str]
) -> Estimate:
    """A coast-down by the voltage of the open motor. T0 and J need K."""
    constant = known.get("K")
    if constant is None and "J" in known:
        raise UsageError("a coast-down by its voltage alone needs --fix K=VALUE beside --fix J")
    turning = [open_circuit_coastdown.speed_from_voltage(capture, constant) for capture in captures]
    found = fit(turning, fix=known, without=without)
    moves = zip(
        (VOLTAGE_GAIN.name,), found.not_stated.values(), strict=False
    )  # one channel or none
    found = replace(found, not_stated=dict(moves))
    return found if constant is not None else open_circuit_coastdown.in_volts(found)


def _check(fix: Mapping[str, float], without: Sequence[str]) -> None:
    for name in (*fix, *without):
        if name not in (*PARAMETERS, "offset"):
            raise UsageError(f"{name!r} is not a parameter: {', '.join(PARAMETERS)}")
    for name, value in fix.items():
        if not (np.isfinite(value) and value >= 0) or (name in ("K", "R", "J") and value == 0):
            raise UsageError(f"--fix {name}={value:g}: give a positive value in SI units")
    for name in without:
        if name in ("K", "J", "R"):
            raise UsageError(f"--without {name}: the model cannot do without it")


def _common_drive(captures: Sequence[Capture]) -> str:
    drives = {drive_of(capture.channels) or COASTING for capture in captures}
    if len(drives) > 1:
        kinds = ", ".join(sorted(drives))
        raise DataError(f"the captures hold different drives ({kinds}): fit them apart")
    return drives.pop()


def _wanted(
    motions: Sequence[Motion], drive: str, fix: Mapping[str, float], without: Sequence[str]
) -> tuple[Bools, Floats]:
    """Which coefficients are free, and what the others are."""
    wanted, values = np.ones(4, dtype=np.bool_), np.zeros(4)
    if drive == COASTING:  # 0 = dω/dt + B/J ω + T0/J sign(ω)
        _check_coasting(motions)
        wanted[[0, OFFSET]], values[0] = False, 1.0
    for name in without:
        if name in ("B", "T0", "offset"):
            wanted[{**COLUMN_OF, "offset": OFFSET}[name]] = False
    scale = {TORQUE: 1.0, CURRENT: fix.get("K")}.get(drive)
    for name, column in COLUMN_OF.items():
        if name in fix and scale is not None:
            wanted[column], values[column] = False, fix[name] / scale
    signs = {
        stretch.sign for motion in motions for stretch in motion.stretches(_widths(motions)[0])
    }
    if len(signs) < 2 and wanted[2]:
        wanted[OFFSET] = False  # one direction: a constant load and Coulomb friction are one
    return wanted, values


def _check_coasting(motions: Sequence[Motion]) -> None:
    """Raises DataError where a motor that nothing drives gets faster."""
    for motion in motions:
        speed = np.abs(motion.speed(motion.period_s * 16))
        lowest = np.minimum.accumulate(speed)
        if np.percentile(speed - lowest, 95) > RISE * motion.top_speed:
            raise DataError(
                "neither torque, current, voltage nor command is measured, and the motor gets "
                "faster: map what drives it, or cut the import to a coast-down by --start, --stop"
            )


def _widths(motions: Sequence[Motion]) -> list[float]:
    """Half-widths to try, in octaves: from a few samples or an aperture to a quarter of a run."""
    narrow = max(max(NARROWEST * motion.period_s, motion.aperture_s) for motion in motions)
    longest = max(float(motion.time_s[-1] - motion.time_s[0]) for motion in motions)
    octaves = max(int(np.log2(longest / narrow / 4)), 0) if longest > 0 else 0
    return [narrow * 2.0**octave for octave in range(octaves + 1)]


def _regress(
    motions: Sequence[Motion],
    wanted: Bools,
    values: Floats,
    terms: Sequence[str] = (),
    settled: bool = False,
) -> Regression | None:
    """The regression at the best width; where the drive is a magnitude, with its sign restored.

    ``terms``: further ones, which are free. ``settled``: as of ``choose_width``.
    """
    if terms:
        wanted = np.r_[wanted, np.ones(len(terms), dtype=np.bool_)]
        values = np.r_[values, np.zeros(len(terms))]
    at_width = _at_width
    if any(motion.unsigned for motion in motions):
        motions, at_width = [_with_sign(motion) for motion in motions], _with_sure_signs
    return choose_width(
        _widths(motions), lambda h: at_width(motions, wanted, values, h, terms), settled
    )


def _at_width(
    motions: Sequence[Motion],
    wanted: Bools,
    values: Floats,
    half_width_s: float,
    terms: Sequence[str] = (),
) -> Regression | None:
    rows = modulating_functions.build(motions, half_width_s)
    if len(rows) < FEWEST_ROWS:
        return None
    return solve(rows.beside(*terms), wanted, values, half_width_s)


def _with_sign(motion: Motion) -> Motion:
    """A magnitude with the sign of the speed: true while the drive works against friction."""
    if not motion.unsigned:
        return motion
    return replace(motion, drive=np.abs(motion.drive) * np.sign(motion.speed(motion.period_s)))


def _with_sure_signs(
    motions: Sequence[Motion],
    wanted: Bools,
    values: Floats,
    half_width_s: float,
    terms: Sequence[str] = (),
) -> Regression | None:
    """Keeps the rows where the model itself says that the drive had the sign of the speed.

    Elsewhere (braking, or a drive lost in its noise) a magnitude says too little to be used.
    """
    rows = modulating_functions.build(motions, half_width_s)
    if len(rows) < FEWEST_ROWS:
        return None
    rows = rows.beside(*terms)
    least = SURE_SIGN * max(noise(motion.drive[_turning(motion)]) for motion in motions)
    sign = np.sign(rows.matrix[:, 2])
    keep = sign * rows.matrix[:, 0] >= -np.abs(rows.matrix[:, 0]).max() * 0.1  # first: no braking
    for _ in range(SIGN_PASSES):
        if keep.sum() < FEWEST_ROWS:
            return None
        found = solve(rows.only(keep), wanted, values, half_width_s)
        predicted = sign * (rows.matrix @ found.coefficients) / rows.weight
        sure = predicted > least
        if np.array_equal(sure, keep):
            break
        keep = sure
    return found


def _turning(motion: Motion) -> Bools:
    """Samples of the stretches of motion."""
    turning = np.zeros(len(motion.time_s), dtype=np.bool_)
    for stretch in motion.stretches(FEWEST_SAMPLES * motion.period_s):
        turning[stretch.slice] = True
    return turning if turning.any() else ~turning
