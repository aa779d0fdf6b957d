"""The steady state: speed against voltage, current against speed, and the rows behind them."""

from __future__ import annotations

import numpy as np

from motorid.estimate.results.estimate import Estimate, SteadyRow
from motorid.report.numbers import fixed
from motorid.report.page import figure, paragraph, table
from motorid.report.plot import Axis, Plot, axis, legend

NOTHING = "—"
LEGEND = legend([("dots measured", "measured"), ("fitted", "model")])


def steady_state(estimate: Estimate) -> str:
    """Two plots and a table; nothing where no steady level was found."""
    rows = estimate.steady
    if not rows:
        return ""
    plots = [p for p in (_speed(estimate, rows), _current(estimate, rows)) if p]
    cells = "".join(f"<div>{p}</div>" for p in plots)
    head = (
        "capture",
        "time, s",
        "voltage, V",
        "current, A",
        "model, A",
        "speed, rad/s",
        "model, rad/s",
    )
    body = [
        (
            str(row.capture + 1),
            f"{row.start_s:.3f} to {row.end_s:.3f}",
            _number(row.voltage_v, 3),
            _number(row.current_a, 4),
            _number(row.fitted_current_a, 4),
            _number(row.speed_rad_s, 2),
            _number(row.foretold_speed_rad_s, 2),
        )
        for row in rows
    ]
    words = (
        "Means over each steady stretch. The model's current is what friction takes at that "
        "speed; a motor that still gains a little draws more. The model's speed is that of the "
        "fit over the same stretch."
    )
    return f'<div class="pair">{cells}</div>{table(head, body)}{paragraph(words, "soft")}'


def _number(value: float | None, decimals: int) -> str:
    return NOTHING if value is None or not np.isfinite(value) else fixed(value, decimals)


def _speed(estimate: Estimate, rows: tuple[SteadyRow, ...]) -> str:
    """Speed against voltage, with the model's line where its parameters are known."""
    known = [(r.voltage_v, r.speed_rad_s) for r in rows if None not in (r.voltage_v, r.speed_rad_s)]
    if not known:
        return ""
    points = np.array(known, dtype=np.float64)
    x = _from_zero(points[:, 0], "voltage, V")
    lines = _branches(estimate, points[:, 0])
    plot = Plot(x, _from_zero(points[:, 1], "speed, rad/s"), "speed against voltage", 12.0)
    for volts, speed in lines:
        plot.line(volts, speed, "fitted")
    plot.dots(points[:, 0], points[:, 1], "measured")
    return figure("Speed against voltage", plot.render(), LEGEND)


def _branches(estimate: Estimate, volts: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The model's steady speed on either side of zero: (V K - R T0) / (K² + R B)."""
    values = [estimate.parameters[n].value for n in ("R", "K", "B", "T0")]
    if None in values:
        return []
    resistance, constant, viscous, coulomb = (float(v) for v in values if v is not None)
    out = []
    for sign in (1.0, -1.0):
        side = volts[np.sign(volts) == sign]
        if len(side):
            ends = np.array([sign * resistance * coulomb / constant, sign * np.abs(side).max()])
            speed = (ends * constant - sign * resistance * coulomb) / (
                constant**2 + resistance * viscous
            )
            out.append((ends, speed))
    return out


def _current(estimate: Estimate, rows: tuple[SteadyRow, ...]) -> str:
    """Current against speed: what friction takes, measured and by the model."""
    known = [(r.speed_rad_s, r.current_a) for r in rows if None not in (r.current_a, r.speed_rad_s)]
    if not known:
        return ""
    points = np.array(known, dtype=np.float64)
    model = np.array(
        [(r.speed_rad_s, r.fitted_current_a) for r in rows
         if None not in (r.fitted_current_a, r.speed_rad_s)],
        dtype=np.float64,
    ).reshape(-1, 2)  # fmt: skip
    small = float(np.abs(points[:, 1]).max()) < 0.2
    title, factor = ("current, mA", 1e3) if small else ("current, A", 1.0)
    y = _from_zero(np.append(points[:, 1], model[:, 1]), title, factor)
    plot = Plot(_from_zero(points[:, 0], "speed, rad/s"), y, "current against speed", 12.0)
    for sign in (1.0, -1.0):
        side = model[np.sign(model[:, 0]) == sign]
        side = side[np.argsort(side[:, 0])]
        if len(side) > 1:
            plot.line(side[:, 0], side[:, 1], "fitted")
    plot.dots(points[:, 0], points[:, 1], "measured")
    plot.dots(model[:, 0], model[:, 1], "fitted")
    return figure("Current against speed", plot.render(), LEGEND)


def _from_zero(values: np.ndarray, title: str, factor: float = 1.0) -> Axis:
    """An axis that shows zero as well: steady levels mean little without it."""
    return axis((np.append(values, 0.0),), title, factor, margin=0.06)
