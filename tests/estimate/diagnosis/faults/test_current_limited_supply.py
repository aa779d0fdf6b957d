"""A supply that gives no more than some current: each bound of what shows it, on drawn courses."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY
from motorid.estimate.diagnosis.faults import current_limited_supply as module
from motorid.estimate.diagnosis.faults.current_limited_supply import Sag, sag, suspects
from motorid.estimate.signals.time_grid import Part
from motorid.program import StepKind

Floats = NDArray[np.float64]
COUNT, PERIOD_S = 400, 1e-3
LIMIT, LEVEL, LOW = 2.0, 6.0, 4.0  # A; V of the part, and where it has fallen to
FALLEN = 40  # ticks at the lowest voltage


def record(
    rise: int = 140, low: float = LOW, end: float = 0.25, tilt: float = 0.0, first: float = 1.0,
    count: int = COUNT, fallen: int = FALLEN, **part: Any,
) -> Any:  # fmt: skip
    """A plateau of the current while the voltage rises for so many ticks; then it falls.

    In shares of the limit: ``end`` of the current; ``tilt``, by which it falls from the first third
    of the plateau to the last; ``first``, before the voltage is on its way.
    """
    at = np.arange(count)
    volts = np.interp(at, [fallen, fallen + rise], [low, LEVEL])
    through = np.clip((at - fallen - 0.2 * rise) / (0.7 * rise), 0.0, 1.0)
    current = LIMIT * (1.0 - 1.5 * tilt * (through - 0.5))
    current = np.where(at < fallen + 0.1 * rise, LIMIT * first, current)
    current = np.where(at > fallen + rise, LIMIT * end, current)
    whole = {"kind": StepKind.DRIVE_VOLTS, "level": LEVEL, **part}
    return SimpleNamespace(
        measured=[
            SimpleNamespace(block=SimpleNamespace(name=CURRENT), keep=at[1:], values=-current[1:])
        ],
        sensed=SimpleNamespace(shows_emf=True, volts=-volts),
        timeline=SimpleNamespace(count=count, parts=(Part(0, count, **whole),), period_s=PERIOD_S),
        capture={},
    )


def test_a_plateau_under_a_voltage_that_recovers_is_told_with_its_figures() -> None:
    found = sag(record())
    assert found is not None
    assert found.current_a == pytest.approx(LIMIT)
    assert found.low_v == pytest.approx(LOW + 0.2 * (LEVEL - LOW), abs=0.02)
    assert found.high_v == pytest.approx(LOW + 0.9 * (LEVEL - LOW), abs=0.02)
    begins = FALLEN + 0.2 * 140 - module.SMOOTH / 2  # of the first window that shows it
    assert found.start_s == pytest.approx(begins * PERIOD_S, abs=1.5e-3)


@pytest.mark.parametrize(("low", "shown"), [(5.68, True), (5.72, False)])
def test_the_voltage_falls_by_a_twentieth(low: float, shown: bool) -> None:
    assert (sag(record(low=low)) is not None) is shown


@pytest.mark.parametrize(("rise", "shown"), [(38, True), (31, False)])
def test_the_recovery_takes_a_while(rise: int, shown: bool) -> None:
    """Seven tenths of it, 24 ticks or more."""
    assert (sag(record(rise=rise)) is not None) is shown


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("tilt", "shown"), [(0.09, True), (0.115, False)])
def test_the_current_stays_on_its_plateau(tilt: float, way: float, shown: bool) -> None:
    assert (sag(record(tilt=way * tilt)) is not None) is shown


@pytest.mark.parametrize(("first", "shown"), [(1.2, True), (1.4, False)])
def test_a_capacitor_gives_some_more_before(first: float, shown: bool) -> None:
    assert (sag(record(first=first)) is not None) is shown


@pytest.mark.parametrize(("end", "shown"), [(0.69, True), (0.71, False)])
def test_the_current_falls_once_the_voltage_is_back(end: float, shown: bool) -> None:
    assert (sag(record(end=end)) is not None) is shown


@pytest.mark.parametrize(("count", "shown"), [(86, True), (63, False)])
def test_a_part_is_as_long_as_a_recovery_and_what_is_around_it(count: int, shown: bool) -> None:
    assert (sag(record(rise=36, count=count, fallen=24)) is not None) is shown


@pytest.mark.parametrize(
    ("part", "shown"),
    [
        ({}, True), ({"kind": StepKind.DRIVE_DUTY, "level": 0.5}, True), ({"level": 0.0}, False),
        ({"kind": StepKind.BRAKE}, False), ({"kind": None}, False),
        ({"discontinuous": True}, False),
    ],
)  # fmt: skip
def test_parts_that_drive_with_a_steady_current_are_looked_at(
    part: dict[str, Any], shown: bool
) -> None:
    assert (sag(record(**part)) is not None) is shown


def test_the_supplys_own_voltage_shows_it_where_the_motors_was_not_read() -> None:
    one = record()
    volts = -one.sensed.volts
    volts[[50, 70]] = np.nan
    one.sensed = SimpleNamespace(shows_emf=False, volts=np.zeros(COUNT))
    one.timeline.spread = lambda values: values
    assert sag(one) is None  # nobody read either
    one.capture = {SUPPLY: SimpleNamespace(values=volts)}
    assert sag(one) is not None
    one.capture = {SUPPLY: SimpleNamespace(values=np.full(COUNT, np.nan))}
    assert sag(one) is None
    one = record()
    one.measured = []
    assert sag(one) is None


def test_what_is_found_is_said_in_volts_amperes_and_seconds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "sag", lambda _: Sag(2.0, 4.4, 5.8, 0.0645))
    one: Any = None
    (said,) = suspects(one)
    assert (said.code, said.where, said.strength) == ("supply_limited", "supply", "named")
    assert said.evidence == (
        "the voltage rose from 4.4 to 5.8 V at 0.0645 s while the current stood at 2 A"
    )


# a voltage that was commanded only

R, K = 2.0, 0.05


def seen(
    monkeypatch: pytest.MonkeyPatch, lacks: list[float], level: float = 6.0,
    settled: bool = True, emf: tuple[bool, ...] = (False, False), motor: Any = (R, K),
) -> Any:  # fmt: skip
    """Ten blocks at a level, of which the first ones lack shares of it; one at the highest."""
    speed = np.full(11, 40.0)
    volts = np.array([6.0, *[level] * 10])
    short = np.zeros(11)
    short[1 : 1 + len(lacks)] = lacks
    current = (volts * (1.0 - short) - K * speed) / R
    table = SimpleNamespace(volts=volts, current=current, speed=speed, settled=np.full(11, settled))
    monkeypatch.setattr(module, "blocks", lambda _: table)
    monkeypatch.setattr(module, "usual", lambda _: motor)
    monkeypatch.setattr(module, "mechanical", lambda b, constant, whole: {"J": len(whole)})
    monkeypatch.setattr(module, "_hypothesis", lambda _, limit: limit)
    records: Any = [SimpleNamespace(sensed=SimpleNamespace(shows_emf=one)) for one in emf]
    return module.seen(records)


@pytest.mark.parametrize("level", [6.0, -6.0, 0.5])
def test_blocks_that_lack_voltage_tell_the_limit(
    level: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = seen(monkeypatch, [0.2, 0.3, 0.4, 0.04], level)
    assert found is not None
    limit, begin = found
    assert limit == pytest.approx(abs((0.7 * level - K * 40.0) / R))  # the median of the three
    assert begin.size == (limit,)
    assert begin.motor == {"R": R, "K": K, "J": 11}


@pytest.mark.parametrize(
    ("facts", "shown"),
    [
        ({"lacks": [0.06, 0.06, 0.06]}, True),
        ({"lacks": [0.06, 0.06, 0.04]}, False),
        ({"lacks": [-0.2, -0.2, -0.2]}, False),
        ({"lacks": [0.2] * 3, "level": 0.29}, False),  # hardly driven
        ({"lacks": [0.2] * 3, "level": 0.31}, True),
        ({"lacks": [0.2] * 3, "settled": False}, False),
        ({"lacks": [0.2] * 3, "emf": (False, True)}, False),
        ({"lacks": [0.2] * 3, "motor": None}, False),
    ],
)
def test_three_settled_blocks_under_drive_must_lack_a_twentieth(
    facts: dict[str, Any], shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert (seen(monkeypatch, **facts) is not None) is shown


def test_the_source_gives_what_its_current_needs_and_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    speed, volts = np.array([0.0, 40.0, 40.0, -40.0, -10.0]), np.array([6.0, 6, 3, -6, 6.0])
    one: Any = SimpleNamespace(
        volts=volts, sensed=SimpleNamespace(series_ohm=0.5), motor=lambda _: (R, 1e-3, K)
    )
    monkeypatch.setattr(module, "measured_speed", lambda _: speed)
    monkeypatch.setattr(module, "changed_voltage", lambda *given: given)
    hypothesis = module._hypothesis([one], 1.2)
    none = np.zeros(0)
    record_, _, _, given = hypothesis.effect(one, none, none, np.array([1.0]))  # type: ignore[misc]
    assert record_ is one
    # 2.5 V for an ampere and K ω beside it; a motor that turns back needs none of it
    assert given == pytest.approx([2.5, 4.5, 3.0, -4.5, 2.5])


def test_a_limit_is_searched_about_the_one_that_was_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "measured_speed", lambda _: None)
    one: Any = object()
    found = module._hypothesis([one], 1.5)
    assert (found.code, found.sizes) == ("supply_limited", ((1.5,),))
    assert found.lower[0] == pytest.approx(0.3)
    assert found.upper[0] == pytest.approx(4.5)
    assert found.scale[0] == pytest.approx(0.03)
    said = found.words(np.array([1.234]))
    assert said.where == "supply"
    assert "no more than 1.23 A" in said.evidence
    assert said.action.endswith("measure the voltage")
