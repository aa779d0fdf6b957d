"""A log of a motor that something else turns: a hand, a drill, another motor; a generator.

The torque from outside is unknown, and with it B, J and T0. What the terminals show holds all the
same, whether the motor is open or works into a load:

    V = K ω + R i + L di/dt + V0

Multiplied by a smooth bump φ and integrated by parts it differentiates no measurement (modulating
functions, as in ``modulating_functions``); a position needs ∫φ' θ in place of the speed. No sign of
a friction forbids a bump here, so that they cover the whole log.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.capture.store import describe
from motorid.estimate.partial.locked_rotor import is_noise
from motorid.estimate.partial.mechanical_results import Judge, Quantity, fixed, unknown
from motorid.estimate.results.estimate import PARAMETERS, UNITS, Diagnostic, Estimate, Parameter
from motorid.estimate.signals.log_sections import unbroken
from motorid.estimate.signals.measurements import motion
from motorid.estimate.uncertainty.budget import INSTRUMENTS, UNSTATED
from motorid.estimate.uncertainty.covariance import NOISE
from motorid.estimate.uncertainty.unstated_gains import PART, gains_of
from motorid.version import __version__

Floats = NDArray[np.float64]

FEWEST = 64  # readings of a log
NARROWEST, HOP = 4, 2  # samples of half a bump; bumps that overlap at a place
BLOCKS = 16  # of bumps, each left out once
LEFT = 0.03  # of the voltage, rms, that the terminals' law may leave
GIVES = 0.05  # of the energy that passes the terminals: so much more leaves a generator
SLOWER = 0.9  # of its first speed: a motor that ends slower may have given its kinetic energy
SURE = 3.0  # standard deviations, by which R or K is below zero
FASTER = 0.2  # of the top speed, by which an open motor gets faster
TOGETHER = 0.98  # correlation of current and speed, beyond which one load was on throughout
PARTS = 24  # of a log, whose means are looked at
ELECTRICAL = ("K", "R", "L")
WHY = "something else turns the motor, and its torque is unknown; let it run by its own current"


@dataclass(frozen=True)
class Law:
    """Coefficients ``values`` and their ``covariance``, in the order of K, R, L and V0, those that
    were asked for; ``left``: share of the voltage, rms, that they leave; ``freedom``: of blocks.
    """

    values: Floats
    covariance: Floats
    left: float
    freedom: int


def suits(captures: Sequence[Capture]) -> bool:
    """Logs of nothing but such motors."""
    return bool(captures) and all(_is_turned(capture) for capture in captures)


def _is_turned(capture: Capture) -> bool:
    """Without a current it gets faster, or with one it gives energy and slows down by none."""
    if capture.program is not None or len(capture) < FEWEST:
        return False
    channels = capture.get(VOLTAGE), capture.get(CURRENT), motion(capture)
    if any(c is None or c.unsigned or not np.isfinite(c.values).all() for c in channels):
        return False
    speed = _mean_speed(capture)
    top = float(np.abs(speed).max())
    volts, amperes = capture.channels[VOLTAGE].values, capture.channels[CURRENT].values
    if not top > 0.0:
        return False
    if is_noise(amperes, origin=True):
        faster = float(np.diff(np.abs(speed)).max(initial=0.0)) * PARTS
        found = law([capture], ("K",)) if faster > FASTER * top else None
        return found is not None and found.left < LEFT and found.values[0] > 0.0
    if abs(speed[-1]) < SLOWER * abs(speed[0]):
        return False
    power = _means(volts * amperes)
    if power.sum() > -GIVES * np.abs(power).sum():
        return False
    found = law([capture], ELECTRICAL)
    if found is None or found.left >= LEFT:
        return False
    if _one_load(capture):
        return True
    least = -SURE * np.sqrt(np.diag(found.covariance))  # a current of the wrong sign has R below it
    return bool((found.values[:2] > least[:2]).all())


def _one_load(capture: Capture) -> bool:
    """The current goes with the speed throughout: K and R are one."""
    means = _means(capture.channels[CURRENT].values), _mean_speed(capture)
    return bool(abs(np.corrcoef(*means)[0, 1]) > TOGETHER)


def _means(values: Floats) -> Floats:
    """Of PARTS stretches of readings (n,)."""
    width = len(values) // PARTS
    return np.asarray(values[: width * PARTS].reshape(PARTS, width).mean(axis=1))


def _mean_speed(capture: Capture) -> Floats:
    """rad/s of the motor, of PARTS stretches."""
    channel = motion(capture)
    assert channel is not None
    values = _at_motor(capture, channel)
    if channel.name == SPEED:
        return _means(values)
    edges = np.linspace(0, len(capture) - 1, PARTS + 1).astype(np.intp)
    return np.asarray(np.diff(values[edges]) / np.diff(capture.time_s[edges]))


def _at_motor(capture: Capture, channel: Channel) -> Floats:
    """Readings (n,) of a motion that a gear may have made slower."""
    return channel.values * (capture.wiring.gear_ratio or 1.0)


def law(captures: Sequence[Capture], names: Sequence[str]) -> Law | None:
    """The terminals' law with these coefficients and an offset, at the bumps' width that knows
    them best; None: no width has bumps enough.
    """
    longest = min(len(capture) for capture in captures) // (2 * BLOCKS)
    widths = [NARROWEST * 2**k for k in range(32) if NARROWEST * 2**k <= max(longest, NARROWEST)]
    found = [one for half in widths if (one := _at_width(captures, names, half)) is not None]
    if not found:
        return None
    count = len(names)
    spread = [float(np.log(np.diag(one.covariance)[:count] + 1e-300).sum()) for one in found]
    best = int(np.argmin(spread))
    beside = [found[k].values for k in (best - 1, best + 1) if 0 <= k < len(found)]
    moves = [found[best].values - other for other in beside]
    more = sum((np.outer(m, m) for m in moves), np.zeros((count + 1, count + 1)))
    one = found[best]
    return Law(one.values, one.covariance + more / max(len(moves), 1), one.left, one.freedom)


def _at_width(captures: Sequence[Capture], names: Sequence[str], half: int) -> Law | None:
    rows = np.vstack([row for capture in captures for row in _rows(capture, half)])
    columns = [1 + ("K", "R", "L").index(name) for name in names] + [4]
    if len(rows) < 2 * BLOCKS or len(rows) < 4 * len(columns):
        return None
    matrix, volts = rows[:, columns], rows[:, 0]
    scale = np.sqrt((matrix**2).sum(axis=0)) + 1e-300
    part = matrix / scale
    values = np.linalg.lstsq(part, volts, rcond=1e-10)[0]
    left = float(np.linalg.norm(volts - part @ values) / (np.linalg.norm(volts) + 1e-300))
    labels = np.arange(len(rows)) * BLOCKS // len(rows)
    others = np.array([
        np.linalg.lstsq(part[labels != k], volts[labels != k], rcond=1e-10)[0]
        for k in range(BLOCKS)
    ])  # fmt: skip
    spread = (others - others.mean(axis=0)) / scale
    return Law(values / scale, (BLOCKS - 1) / BLOCKS * spread.T @ spread, left, BLOCKS - 1)


def _rows(capture: Capture, half: int) -> Iterator[Floats]:
    """(m, 5): of every bump the integrals of V, ω, i, di/dt and 1."""
    for piece in unbroken([capture]):
        time, moved = piece.time_s, motion(piece)
        if moved is None or len(time) <= 2 * half:
            continue
        starts = np.arange(0, len(time) - 2 * half, max(half // HOP, 1))
        places = starts[:, None] + np.arange(2 * half + 1)
        at, weight = time[places], np.gradient(time)[places]
        middle = 0.5 * (at[:, :1] + at[:, -1:])
        angle = 2.0 * np.pi * (at - middle) / (at[:, -1:] - at[:, :1])
        bump = 0.5 * (1.0 + np.cos(angle)) * weight
        slope = -np.pi * np.sin(angle) / (at[:, -1:] - at[:, :1]) * weight
        volts, amperes = (piece.channels[n].values[places] for n in (VOLTAGE, CURRENT))
        turns = _at_motor(piece, moved)[places]
        turned = bump * turns if moved.name == SPEED else -slope * (turns - turns[:, :1])
        each = bump * volts, turned, bump * amperes, -slope * amperes, bump
        yield np.stack([one.sum(axis=1) for one in each], axis=1)


def fit(captures: Sequence[Capture], fix: Mapping[str, float]) -> Estimate:
    """K, and of a motor that works into a load R and L as well; ``fix`` stays as it is given."""
    open_ = all(is_noise(c.channels[CURRENT].values, origin=True) for c in captures)
    names = ELECTRICAL[:1] if open_ else ELECTRICAL
    found = law(captures, names)
    assert found is not None  # it was the same law that suited
    judge = Judge(found.freedom)
    quantities, lines = {}, {}
    for k, name in enumerate(names):
        causes = _lines(captures, name, found, open_)
        quantities[name] = Quantity(
            float(found.values[k]), float(found.covariance[k, k]), math.hypot(*causes.values())
        )
        noise = math.sqrt(found.covariance[k, k])
        lines[name] = {cause: u for cause, u in {NOISE: noise, **causes}.items() if u > 0.0}
    parameters: dict[str, Parameter] = {n: unknown(n, UNITS[n], WHY) for n in PARAMETERS}
    if open_ or not all(_one_load(capture) for capture in captures):
        parameters |= {n: judge.parameter(n, UNITS[n], q) for n, q in quantities.items()}
    if open_:
        flows = "no current flows; let it work into a resistor, or drive it"
        parameters |= {n: unknown(n, UNITS[n], flows) for n in ("R", "L")}
    parameters |= {name: fixed(name, UNITS[name], value) for name, value in fix.items()}
    return Estimate(
        model="V = K ω + R i + L di/dt + V0, turned from outside",
        method="modulating functions, least squares",
        parameters={name: parameters[name] for name in PARAMETERS},
        combinations={},
        derived={},
        nuisance={},
        free=(),
        correlation=np.zeros((0, 0)),
        chi_square=0.0,
        degrees_of_freedom=found.freedom,
        evaluations=1,
        diagnostics=(_said(open_, [n for n in names if parameters[n].value is not None]),),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": []},
        versions={"motorid": __version__, "numpy": np.__version__},
        budget={name: line for name, line in lines.items() if name not in fix},
        not_stated=_not_stated(captures, quantities, fix),
    )


POWERS = {"K": (1.0, 0.0, -1.0), "R": (1.0, -1.0, 0.0), "L": (1.0, -1.0, 0.0)}
"""How each goes with the gains of voltage, current and motion."""


def _read(capture: Capture) -> tuple[str, str, str]:
    moved = motion(capture)
    return VOLTAGE, CURRENT, moved.name if moved is not None else SPEED


def _lines(
    captures: Sequence[Capture], name: str, found: Law, open_: bool
) -> dict[str, float]:  # fmt: skip
    """Standard uncertainties (SI) by declared gains, and by lags of channels that nobody stated: of
    half a sample between them, which turn K dω/dt and R di/dt into di/dt.
    """
    value = float(found.values[ELECTRICAL.index(name)])
    declared = [
        power * capture.channels[read].gain_uncertainty
        for capture in captures[:1]
        for power, read in zip(POWERS[name], _read(capture), strict=True)
    ]
    lines = {INSTRUMENTS: abs(value) * math.hypot(*declared)}
    if name == "L" and not open_:
        ohms = max(float(_share(capture) + found.values[1]) for capture in captures)
        lines[UNSTATED] = 0.5 * max(capture.period_s for capture in captures) * ohms
    return lines


def _share(capture: Capture) -> float:
    """Ohms by which the back-EMF goes with the current: of what the generator works into."""
    volts, amperes = (np.diff(_means(capture.channels[n].values)) for n in (VOLTAGE, CURRENT))
    return float(np.linalg.norm(volts) / (np.linalg.norm(amperes) + 1e-300))


def _not_stated(
    captures: Sequence[Capture], quantities: Mapping[str, Quantity], fix: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Changes (SI) if a channel of an unstated gain reads 1 % too much."""
    columns = dict.fromkeys(_read(captures[0]))
    moves = {}
    for gain, channel in gains_of(captures, columns).items():
        place = _read(captures[0]).index(channel)
        each = {n: -PART * POWERS[n][place] * q.value for n, q in quantities.items()}
        moves[gain] = {n: move for n, move in each.items() if move and n not in fix}
    return {gain: each for gain, each in moves.items() if each}


def _said(open_: bool, told: Sequence[str]) -> Diagnostic:
    """``told``: parameters that the captures determine."""
    shown = (
        "it gets faster while no current flows" if open_
        else "it gives more electrical energy than it takes, and does not get slower"
    )  # fmt: skip
    which = " and ".join([", ".join(told[:-1]), told[-1]] if len(told) > 1 else told)
    which = f"determines only {which}" if told else (
        "determines nothing: under one constant load K and R i go together, so change the load, "
        "or open it for a while"
    )  # fmt: skip
    return Diagnostic(
        "turned_from_outside", "warning",
        f"something else turns the motor: {shown}. Such a run {which}. If the motor was to run by "
        "itself, look at the current's sensor and its sign",
    )  # fmt: skip
