"""What is said of a run of instruments, on both sides of each bound; by readings made by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.acquire.scpi.notes import Told, notes_of
from motorid.capture.model import CURRENT, VOLTAGE, Channel
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
BARE = replace(
    RIG,
    wiring=replace(RIG.wiring, lead_resistance_ohm=0.0, lead_resistance_uncertainty_ohm=0.0),
)
LEADS = replace(BARE, wiring=replace(BARE.wiring, lead_resistance_uncertainty_ohm=0.01))
UP = np.r_[np.zeros(5), np.full(95, 6.0)]  # V, at 100 Hz
TIMES = np.arange(100) / 100


def told(**facts: Any) -> Told:
    commanded = [{"volts": None}, {"volts": 6.0}]
    made = Told("completed", "", "", "", {}, {"current_limit": 2.0}, commanded, (), 1.0, "")
    return replace(made, **facts)


def notes(
    volts: Any = UP, amperes: Any = 0.5, sense: Any = "terminals", rig: Any = LEADS,
    polled: bool = False, **facts: Any,
) -> list[str]:  # fmt: skip
    current = np.broadcast_to(np.asarray(amperes, dtype=float), (100,))
    channels = {
        VOLTAGE: Channel(VOLTAGE, "V", np.asarray(volts, dtype=float), sense=sense),
        CURRENT: Channel(CURRENT, "A", current),
    }
    return list(notes_of(rig, polled, channels, TIMES, told(**facts)))


def test_a_right_run_has_nothing_said_of_it() -> None:
    assert notes() == []
    assert notes(commanded=[]) == []
    assert notes(commanded=[{"volts": 0.0}, {}]) == []


def test_what_the_supply_says_of_its_limit_goes_before_the_readings() -> None:
    (said,) = notes(np.full(100, 1.0), 2.0, limited=(3, 5))
    assert "limited the current in step 3, 5 of the program" in said


@pytest.mark.parametrize(
    ("amperes", "volts", "limited"),
    [(1.95, 5.6, True), (1.93, 5.6, False), (1.95, 5.8, False), (-1.95, -5.6, True)],
)
def test_readings_at_the_limit_below_the_level_were_limited(
    amperes: float, volts: float, limited: bool
) -> None:
    level = UP.copy()
    level[40:52] = volts
    current = np.where((TIMES >= 0.4) & (TIMES < 0.52), amperes, 0.5)
    found = notes(level, current)
    assert bool(found) is limited
    if limited:
        assert found[0].startswith("12 readings, from 0.400 s on, are at the current limit of 2 A")
    assert notes(level, current, protection={}) == []


def test_the_lowest_level_may_have_been_reached() -> None:
    """4 V at the limit are short of the level of 6 V, and no less than that of 4 V."""
    level = UP.copy()
    level[40:52] = 4.0
    current = np.where((TIMES >= 0.4) & (TIMES < 0.52), 2.0, 0.5)
    both = [{"volts": 4.0}, {"volts": 6.0}]
    assert notes(level, current, commanded=both) == []
    level[40:52] = 3.7
    assert len(notes(level, current, commanded=both)) == 1


@pytest.mark.parametrize(("rise", "said"), [(3, False), (4, True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_level_that_takes_more_than_three_samples_is_a_ramp(
    rise: int, said: bool, sign: float
) -> None:
    volts = UP.copy()
    volts[5 : 5 + rise] = 3.0
    found = notes(sign * volts, 0.5 * sign, commanded=[{"volts": sign * 6.0}])
    assert bool(found) is said
    if said:
        assert found[0].startswith("the supply took 0.04 s from 10 to 90 % of its first level")


@pytest.mark.parametrize(("share", "high"), [(0.09, False), (0.11, True)])
def test_a_rise_is_from_a_tenth_to_nine_tenths(share: float, high: bool) -> None:
    volts = UP.copy()
    volts[5:15] = 6.0 * share
    assert bool(notes(volts)) is high
    volts[5:15] = 6.0 * (1.0 - share)  # reached, or not yet
    assert bool(notes(volts)) is high


@pytest.mark.parametrize(("planned_s", "said"), [(1.04, False), (1.05, True)])
def test_a_recorder_that_lacks_more_than_a_twentieth_is_said(planned_s: float, said: bool) -> None:
    found = notes(planned_s=planned_s)
    assert bool(found) is said
    assert all("kept 0.99 s of a run of 1.05 s" in one for one in found)
    assert notes(planned_s=planned_s, end_reason="interrupted") == []


@pytest.mark.parametrize(
    ("volts", "said"),
    [(6.0 / 1.26, True), (6.0 / 1.24, False), (6.0 * 1.24, False), (6.0 * 1.26, True)],
)
def test_a_voltage_far_from_what_was_set_has_a_wrong_factor(volts: float, said: bool) -> None:
    found = notes(UP * volts / 6.0)
    factor = [one for one in found if "where 6 V was set: is the probe's factor" in one]
    assert bool(factor) is said
    assert notes(np.full(100, volts), end_reason="stopped") == []


def test_a_limited_level_was_not_reached() -> None:
    assert len(notes(UP / 2, limited=(1,))) == 1
    assert len(notes(UP * 2, limited=(1,))) == 2


def test_few_readings_above_the_level_are_no_factor() -> None:
    volts = UP.copy()
    volts[50:90:2] = 9.0
    assert notes(volts) == []


def test_a_current_against_the_voltage_is_a_turned_probe() -> None:
    (said,) = notes(amperes=-0.5)
    assert said.startswith("the current flows against the voltage on the whole")
    mixed = np.where(TIMES < 0.6, 0.5, -0.5)
    assert notes(amperes=mixed) == []
    mixed[:25] = np.nan  # what is missing has no power
    assert len(notes(amperes=mixed)) == 1


def test_readings_one_by_one_are_said_to_be_and_have_no_ramp() -> None:
    volts = UP.copy()
    volts[5:15] = 3.0
    (said,) = notes(volts, polled=True, planned_s=9.0)
    assert said.startswith("readings were asked for one by one, about every 0.01 s")


def test_leads_that_nobody_stated_are_said_of_a_voltage_at_the_supply() -> None:
    (said,) = notes(sense="bridge", rig=BARE)
    assert said.endswith("R holds the leads")
    assert notes(sense="bridge") == notes(rig=BARE) == []
