"""A channel's and a run's own figures, by hand."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import SUPPLY, Capture, Channel, Gap, Stated, Wiring
from motorid.errors import DataError


def of(ticks: list[int], **facts: Any) -> Capture:
    raw = np.arange(len(ticks), dtype=float)
    channels = facts.pop("channels", {"current": Channel("current", "A", raw, scale=2.0)})
    return Capture(np.array(ticks, np.int64), 1e6, channels, **facts)


def test_a_reading_in_its_unit_and_at_the_ends_of_its_converter() -> None:
    raw = np.array([0, 1, 7, 8, 9], np.uint16)
    channel = Channel("current", "A", raw, scale=0.5, offset=3.0, raw_min=1.0, raw_max=8.0)
    assert channel.values.tolist() == [-1.5, -1.0, 2.0, 2.5, 3.0]
    assert channel.saturated.tolist() == [True, True, False, True, True]


@pytest.mark.parametrize(("kind", "window_s"), [("mean", 0.25), ("instant", 0.0)])
def test_only_a_mean_has_a_window(kind: Any, window_s: float) -> None:
    assert Channel("current", "A", np.zeros(1), kind=kind, aperture_s=0.25).window_s == window_s


@pytest.mark.parametrize(
    ("order", "damping", "delay_s"), [(1, 0.7, 0.01), (2, 0.7, 0.014), (2, 1.0, 0.02)]
)
def test_how_late_a_filter_makes_a_steady_change(
    order: int, damping: float, delay_s: float
) -> None:
    facts: Any = {"filter_s": 0.01, "filter_order": order, "filter_damping": damping}
    assert Channel("current", "A", np.zeros(1), **facts).filter_delay_s == pytest.approx(delay_s)


def test_two_samples_have_a_period() -> None:
    capture = of([100, 350])
    assert capture.period_s == pytest.approx(250e-6)
    assert capture.time_s.tolist() == pytest.approx([0.0, 250e-6])
    assert len(capture) == 2


def test_a_channel_of_another_length_is_refused() -> None:
    with pytest.raises(DataError, match="channel current has 2 readings for 3 ticks"):
        of([0, 1, 2], channels={"current": Channel("current", "A", np.zeros(2))})


def test_some_rows_of_a_capture() -> None:
    gaps = (Gap(1, 2, "lost"),)
    part = of([0, 10, 20, 30, 40], gaps=(Gap(4, 9, "other"),)).rows(slice(1, 4), gaps)
    assert part.ticks.tolist() == [10, 20, 30]
    assert part.channels["current"].values.tolist() == [2.0, 4.0, 6.0]
    assert part.gaps == gaps


@pytest.mark.parametrize("value", [inf, nan, "0.4", None])
def test_what_is_stated_of_a_motor_is_finite(value: Any) -> None:
    for table in ({"nameplate": {"resistance_ohm": value}}, {"thermal": {"resistance_ohm": value}}):
        with pytest.raises(DataError, match=r"resistance_ohm of the motor is .*: give a finite"):
            Stated(**table)


def test_another_rig_states_what_it_states_and_the_rest_stays() -> None:
    mine = Stated({"a": 1.0, "b": 2.0}, {"c": 3.0, "d": 4.0}, "mine")
    found = mine.under(Stated({"b": 5.0}, {"d": 6.0, "e": 7}, "the rig's"))
    assert found == Stated({"a": 1.0, "b": 5.0}, {"c": 3.0, "d": 6.0, "e": 7}, "mine")


READ = {"descriptors": {SUPPLY: {}}}


@pytest.mark.parametrize(
    ("provenance", "measured_v"),
    [
        ({}, None),
        ({"supply_before_v": 11.5}, 11.5),
        ({"supply_before_v": 7}, 7.0),
        ({"supply_before_v": 0.0}, None),
        ({"supply_before_v": "11"}, None),
        ({"check": {"duty": -0.25, "volts": -3.0}}, None),  # of no board that reads its supply
        ({"check": {"duty": -0.25, "volts": 3.0}} | READ, 12.0),
        ({"check": {"duty": 0.25, "volts": None}} | READ, None),
        ({"check": {"duty": None, "volts": 3.0}} | READ, None),
        ({"check": None} | READ, None),
        ({"supply_before_v": 11.5, "check": {"duty": 0.25, "volts": 3.0}} | READ, 11.5),
    ],
)
def test_the_supply_that_was_measured(provenance: Any, measured_v: float | None) -> None:
    assert of([0, 1], provenance=provenance).supply_measured_v == measured_v


def test_a_run_s_own_supply_channel_goes_before_what_was_read_before_the_run() -> None:
    def read(*volts: float) -> Capture:
        channels = {SUPPLY: Channel(SUPPLY, "V", np.array(volts), scale=2.0)}
        known = {"supply_before_v": 11.0}
        wiring = Wiring(supply_voltage_v=9.0)
        return of(list(range(len(volts))), channels=channels, provenance=known, wiring=wiring)

    assert read(4.0, 4.5, 6.0).supply_measured_v == 9.0  # the middle one
    assert read(nan, 4.0, 4.1).supply_measured_v == pytest.approx(8.1)
    assert read(4.45, 4.45).supply_v == pytest.approx(8.9)  # though near the rig's figure
    assert read(nan, nan).supply_measured_v == 11.0


@pytest.mark.parametrize(
    ("stated_v", "before_v", "found_v"),
    [
        (10.4, 10.0, 10.4),  # within 5 % of the reading: the rig's figure
        (10.6, 10.0, 10.0),
        (9.6, 10.0, 9.6),
        (9.4, 10.0, 10.0),
        (0.0, 10.0, 10.0),
        (10.4, None, 10.4),
        (0.5, None, 0.5),
        (0.0, None, 12.0),  # by the check's weak pulse
    ],
)
def test_a_rig_s_supply_counts_unless_a_reading_contradicts_it(
    stated_v: float, before_v: float | None, found_v: float
) -> None:
    provenance: dict[str, Any] = {"check": {"duty": 0.25, "volts": 3.0}}
    if before_v is not None:
        provenance["supply_before_v"] = before_v
    capture = of([0, 1], provenance=provenance, wiring=Wiring(supply_voltage_v=stated_v))
    assert capture.supply_v == pytest.approx(found_v)
