"""Steady points: what declared gains and offsets leave open, against drawing them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.partial import mechanical_fit, steady_state_table

R, K, T0 = 0.09, 0.0188, 0.05
GAINS = {"terminal_voltage": 0.003, "current": 0.01, "speed": 0.002, "torque": 0.02}
OFFSETS = {"terminal_voltage": 0.01, "current": 0.2, "speed": 0.0, "torque": 0.005}
UNITS = {"terminal_voltage": "V", "current": "A", "speed": "rad/s", "torque": "N·m"}


def points(gains: dict[str, float], offsets: dict[str, float], seed: int = 0) -> Capture:
    """A table of a known motor, read by instruments with these errors, and a little noise."""
    rng = np.random.default_rng(seed)
    current = np.linspace(5, 130, 40)
    volts = np.full(40, 12.0)
    true = {
        "terminal_voltage": volts,
        "current": current,
        "speed": (volts - R * current) / K,
        "torque": K * current - T0,
    }
    channels = {
        name: Channel(
            name,
            UNITS[name],
            values * (1 + gains.get(name, 0.0) + 1e-4 * rng.standard_normal(40))
            + offsets.get(name, 0.0),
        )
        for name, values in true.items()
    }
    return Capture(np.arange(40) * 10**9, 1e9, channels, provenance={"static": True})


def declared(capture: Capture) -> Capture:
    channels = {
        name: replace(channel, gain_uncertainty=GAINS[name], offset_uncertainty=OFFSETS[name])
        for name, channel in capture.channels.items()
    }
    return replace(capture, channels=channels)


@pytest.mark.slow
def test_the_instrument_part_is_what_drawn_errors_scatter_by() -> None:
    rng = np.random.default_rng(5)
    found = []
    for _ in range(400):
        gains = {name: u * rng.standard_normal() for name, u in GAINS.items()}
        offsets = {name: u * rng.standard_normal() for name, u in OFFSETS.items()}
        estimate = mechanical_fit.fit([points(gains, offsets)])
        found.append(
            [
                estimate.parameters["R"].value,
                estimate.combinations["Ke"].value,
                estimate.parameters["T0"].value,
            ]
        )
    spread = np.std(np.array(found, dtype=float), axis=0)
    stated = mechanical_fit.fit([declared(points({}, {}))])
    own = [
        stated.parameters["R"].instrument,
        stated.combinations["Ke"].instrument,
        stated.parameters["T0"].instrument,
    ]
    assert own == pytest.approx(spread, rel=0.12)


def test_what_is_not_declared_is_said() -> None:
    bare = mechanical_fit.fit([points({}, {})])
    warming = bare.budget["R"]["winding warming"]
    assert bare.parameters["R"].instrument == pytest.approx(warming)
    assert "gains and offsets" not in bare.budget["R"]
    assert "no_instrument_uncertainty" in [d.code for d in bare.diagnostics]
    stated = mechanical_fit.fit([declared(points({}, {}))])
    assert "no_instrument_uncertainty" not in [d.code for d in stated.diagnostics]
    declared_part = stated.budget["R"]["gains and offsets"]
    assert stated.parameters["R"].instrument == pytest.approx(np.hypot(warming, declared_part))


def test_two_tables_of_one_bench_do_not_average_its_gain_away() -> None:
    one = mechanical_fit.fit([declared(points({}, {}))]).parameters["R"]
    two = mechanical_fit.fit([declared(points({}, {}, k)) for k in (0, 1)]).parameters["R"]
    assert two.instrument == pytest.approx(one.instrument, rel=1e-2)
    assert two.statistical is not None
    assert one.statistical is not None
    assert two.statistical < one.statistical


# values and variances, against the normal equations


def table(**columns: np.ndarray) -> Capture:
    count = len(next(iter(columns.values())))
    channels = {name: Channel(name, UNITS[name], values) for name, values in columns.items()}
    return Capture(np.arange(count) * 10**9, 1e9, channels, provenance={"static": True})


def measured(scatter: float = 1e-3, count: int = 30) -> dict[str, np.ndarray]:
    """Points at several voltages, each reading with scatter of its own."""
    rng = np.random.default_rng(8)
    current = np.tile(np.linspace(5.0, 120.0, count // 3), 3)
    volts = np.repeat([8.0, 10.0, 12.0], count // 3)
    true = {
        "terminal_voltage": volts,
        "current": current,
        "speed": (volts - R * current) / K,
        "torque": K * current - T0,
    }
    return {n: v * (1.0 + scatter * rng.standard_normal(count)) for n, v in true.items()}


def least_squares(design: np.ndarray, left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    values = np.linalg.solve(design.T @ design, design.T @ left)
    rest = left - design @ values
    freedom = len(left) - design.shape[1]
    return values, float(rest @ rest) / freedom * np.linalg.inv(design.T @ design)


def test_volts_current_and_speed_give_resistance_and_constant() -> None:
    c = measured()
    found = steady_state_table.fit([table(**{n: c[n] for n in c if n != "torque"})])
    (g, h), cov = least_squares(np.column_stack([c["terminal_voltage"], -c["speed"]]), c["current"])
    resistance, constant = found.parameters["R"], found.parameters["K"]
    assert resistance.value == pytest.approx(1 / g)
    assert resistance.statistical == pytest.approx(np.sqrt(cov[0, 0]) / g**2)
    assert constant.value == pytest.approx(h / g)
    relative = cov[1, 1] / h**2 + cov[0, 0] / g**2 - 2 * cov[0, 1] / (g * h)
    assert constant.statistical == pytest.approx(h / g * np.sqrt(relative))
    assert resistance.value == pytest.approx(R, rel=0.05)
    assert constant.value == pytest.approx(K, rel=0.01)
    assert found.combinations == {}
    assert found.parameters["T0"].value is None
    assert "steady points show no dynamics" in found.parameters["J"].note
    assert found.degrees_of_freedom == 28


def test_torque_and_current_give_constant_and_friction() -> None:
    c = measured()
    found = steady_state_table.fit([table(current=c["current"], torque=c["torque"])])
    design = np.column_stack([c["current"], -np.ones(30)])
    values, cov = least_squares(design, c["torque"])
    for name, value, variance in zip(("K", "T0"), values, np.diag(cov), strict=True):
        assert found.parameters[name].value == pytest.approx(value)
        assert found.parameters[name].statistical == pytest.approx(np.sqrt(variance))
    assert found.parameters["R"].value is None


def test_two_ways_to_the_constant_doubt_each_other_by_half_their_difference() -> None:
    c = measured()
    both = steady_state_table.fit([table(**c)])
    electrical, torque = both.combinations["Ke"].value, both.parameters["K"].value
    assert electrical is not None
    assert torque is not None
    assert electrical != torque
    assert both.parameters["K"].instrument == pytest.approx(abs(electrical - torque) / 2)
    assert "constants_differ" not in [d.code for d in both.diagnostics]


@pytest.mark.parametrize(("factor", "said"), [(1.04, False), (1.07, True), (0.93, True)])
def test_a_constant_that_differs_is_said(factor: float, said: bool) -> None:
    c = measured(1e-5)
    found = steady_state_table.fit([table(**{**c, "torque": factor * c["torque"]})])
    remarks = {d.code: d for d in found.diagnostics}
    assert ("constants_differ" in remarks) is said
    if said:
        assert remarks["constants_differ"].severity == "warning"
        words = remarks["constants_differ"].message
        assert f"give K = {K:.4g} V·s/rad" in words
        assert f"{factor * K:.4g} N·m/A" in words


@pytest.mark.parametrize(("scatter", "said"), [(0.0, True), (5e-3, False)])
def test_points_on_a_line_to_the_last_digit_were_computed(scatter: float, said: bool) -> None:
    codes = [d.code for d in steady_state_table.fit([table(**measured(scatter))]).diagnostics]
    assert ("computed_table" in codes) is said
    without = {n: v for n, v in measured(scatter).items() if n != "torque"}
    codes = [d.code for d in steady_state_table.fit([table(**without)]).diagnostics]
    assert "computed_table" not in codes


def test_a_row_without_a_reading_is_left_out() -> None:
    c = measured()
    holed = {n: v.copy() for n, v in c.items()}
    holed["speed"][4] = holed["torque"][7] = np.nan
    found = steady_state_table.fit([table(**holed)])
    kept = np.arange(30) != 4
    some = steady_state_table.fit(
        [table(**{n: v[kept] for n, v in c.items() if n != "torque"})]
    ).parameters["R"]
    assert found.parameters["R"].value == pytest.approx(some.value)
    assert found.parameters["K"].value == pytest.approx(K, rel=0.01)


def test_several_tables_are_one() -> None:
    c = measured()
    halves = [table(**{n: v[part] for n, v in c.items()}) for part in (slice(15), slice(15, 30))]
    one, two = steady_state_table.fit([table(**c)]), steady_state_table.fit(halves)
    assert two.parameters["R"].value == pytest.approx(one.parameters["R"].value)
    lacking = replace(
        halves[1], channels={n: v for n, v in halves[1].channels.items() if n != "torque"}
    )
    assert steady_state_table.fit([halves[0], lacking]).parameters["T0"].value is None


def test_what_is_held_is_given_back_as_given() -> None:
    found = steady_state_table.fit([table(**measured())], fix={"J": 2e-4})
    assert found.parameters["J"].value == 2e-4
    assert found.parameters["J"].total == 0.0
    assert found.options == {"fix": {"J": 2e-4}}
    with pytest.raises(UsageError, match="'X' is not a parameter: R, L, K"):
        steady_state_table.fit([table(**measured())], fix={"X": 1.0})


def test_tables_that_tell_nothing_are_refused() -> None:
    c = measured()
    with pytest.raises(DataError, match="at least 8 rows"):
        steady_state_table.fit([table(**{n: v[:7] for n, v in c.items()})])
    assert steady_state_table.fit([table(**{n: v[::4] for n, v in c.items()})])
    with pytest.raises(DataError, match="need voltage and speed for R and K, or torque for K"):
        steady_state_table.fit([table(current=c["current"], speed=c["speed"])])
    with pytest.raises(DataError, match="all alike"):
        steady_state_table.fit([table(current=np.full(9, 2.0), torque=np.full(9, 0.1))])
    holed = np.where(np.arange(9) < 2, 0.1, np.nan)
    with pytest.raises(DataError, match="2 whole steady points are too few"):
        steady_state_table.fit([table(current=np.arange(9.0), torque=holed)])


def test_a_resistance_of_the_wrong_sign_is_none() -> None:
    c = measured()
    turned = {**c, "current": -c["current"], "torque": -c["torque"]}
    found = steady_state_table.fit([table(**{**turned, "terminal_voltage": c["terminal_voltage"]})])
    assert found.parameters["R"].value is None
    assert found.combinations == {}
    assert found.parameters["K"].value == pytest.approx(K, rel=0.01)


def test_a_gain_that_nobody_stated_moves_its_parameters() -> None:
    """Current 1 % too high: R and K of the volts unchanged in ratio to it."""
    c = measured(1e-5)
    capture = table(**{n: v for n, v in c.items() if n != "torque"})
    channels = {
        n: replace(ch, undeclared=("gain",) if n == "current" else ())
        for n, ch in capture.channels.items()
    }
    found = steady_state_table.fit([replace(capture, channels=channels)])
    (moves,) = found.not_stated.values()
    assert moves["R"] == pytest.approx(R * (1 / 0.99 - 1), rel=1e-3)
    assert "K" not in moves


def test_only_tables_suit() -> None:
    assert steady_state_table.suits([table(**measured())])
    assert not steady_state_table.suits([])
    timed = replace(table(**measured()), provenance={"static": False})
    assert not steady_state_table.suits([table(**measured()), timed])


def test_a_note_of_the_import_is_said_once() -> None:
    one = replace(
        table(**measured()), provenance={"static": True, "notes": ["two rows were empty"]}
    )
    said = [d for d in steady_state_table.fit([one, one]).diagnostics if d.code == "import"]
    assert [(d.severity, d.message) for d in said] == [("info", "On import: two rows were empty.")]


@pytest.mark.parametrize("seed", range(4))
def test_a_table_without_a_load_leaves_r_open_by_the_noise_of_every_column(seed: int) -> None:
    """R i is .1 V of up to 24 V: noise of volts and speed draws R to one side, and K with it.
    Nothing warms by such a current, and a rise that no winding survives is none.
    """
    R, K, T0, rng = 1.1, 0.026, 2.5e-3, np.random.default_rng(seed)
    true = np.linspace(4.0, 24.0, 24) * np.tile([1.0, -1.0], 12)
    amps = T0 / K * np.sign(true) + 3e-6 / K * true / K
    speed = (true - R * amps) / K + 1.0 * rng.standard_normal(24)
    volts = true + 0.03 * rng.standard_normal(24)
    columns = {VOLTAGE: (volts, "V"), CURRENT: (amps, "A"), SPEED: (speed, "rad/s")}
    channels = {n: Channel(n, unit, y) for n, (y, unit) in columns.items()}
    table = Capture(np.arange(24), 1.0, channels, provenance={"static": True})
    found = steady_state_table.fit([table])
    assert "winding_warms" not in [d.code for d in found.diagnostics]
    for name, value in (("R", R), ("K", K)):
        p = found.parameters[name]
        assert p.value is not None
        assert p.total is not None
        assert abs(p.value - value) < 3.0 * p.total
    assert found.budget["K"]["noise of every column"] > found.budget["K"]["noise"]
