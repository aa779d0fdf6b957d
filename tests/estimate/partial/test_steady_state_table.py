"""Steady points: what declared gains and offsets leave open, against drawing them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.estimate.partial import mechanical_fit

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
    assert bare.parameters["R"].instrument == 0
    assert "no_instrument_uncertainty" in [d.code for d in bare.diagnostics]
    stated = mechanical_fit.fit([declared(points({}, {}))])
    assert "no_instrument_uncertainty" not in [d.code for d in stated.diagnostics]


def test_two_tables_of_one_bench_do_not_average_its_gain_away() -> None:
    one = mechanical_fit.fit([declared(points({}, {}))]).parameters["R"]
    two = mechanical_fit.fit([declared(points({}, {}, k)) for k in (0, 1)]).parameters["R"]
    assert two.instrument == pytest.approx(one.instrument, rel=1e-2)
    assert two.statistical is not None
    assert one.statistical is not None
    assert two.statistical < one.statistical
