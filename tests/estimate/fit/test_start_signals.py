"""Signals a search begins with: made whole on the grid, without offsets, and refused in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError
from motorid.estimate.fit import lagging_start, start_values
from motorid.estimate.fit.lagging_start import Doubt
from motorid.estimate.fit.start_signals import Signals, signals
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals import log_sections
from motorid.estimate.signals.opened_bridge import Opening
from tests.estimate.fit.read_record import PERIOD_S, record

EVERY = np.arange(200)
OTHER = np.arange(0, 199, 2)  # readings
CURRENT = (OTHER, 0.5 + 0.01 * OTHER)
POSITION = (EVERY, 0.02 * EVERY)
SPEED = (EVERY, 10.0 + 0.5 * EVERY)


def test_readings_are_joined_and_the_offset_at_rest_taken_off() -> None:
    one = record(200, parts=(0, 100), current=CURRENT, position=POSITION, speed=SPEED)
    one.driven[150:] = False
    found = signals(one)
    amperes = np.minimum(0.5 + 0.01 * EVERY, 2.48) - 0.2
    assert found.current == pytest.approx(np.where(EVERY < 150, amperes, 0.0))
    assert found.volts == pytest.approx(np.where(EVERY < 150, 2.0 + 0.1 * EVERY, 0.0))
    assert found.angle == pytest.approx(0.02 * EVERY)
    assert found.speed is None  # an angle tells it
    assert (found.period_s, found.series_ohm) == (PERIOD_S, 0.5)
    assert (found.edges, found.open) == ((0, 100, 200), (False, True))
    assert found.step_rad == pytest.approx(3e-4)  # of the motor's shaft, behind a gear of 3


def test_a_current_without_an_unknown_offset_is_as_it_was_read() -> None:
    one = record(200, current=(EVERY, 0.7 + 0.001 * EVERY), speed=SPEED)
    one.unknowns = ()
    assert signals(one).current == pytest.approx(0.7 + 0.001 * EVERY)


def test_a_speed_is_summed_to_an_angle() -> None:
    found = signals(record(200, current=CURRENT, speed=SPEED))
    assert found.speed == pytest.approx(SPEED[1])
    assert np.diff(found.angle) == pytest.approx(SPEED[1][1:] * PERIOD_S)
    assert found.step_rad == 0.0


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_current_without_a_sign_runs_against_the_motion_in_a_brake(way: float) -> None:
    one = record(200, unsigned=True, current=(EVERY, 0.7 + 0.001 * EVERY), speed=SPEED)
    one.measured[1].values[:] *= way
    one.sensed.volts[:80] = np.random.default_rng(1).normal(0.0, 0.01, 80)
    found = signals(one).current
    assert found[:80] == pytest.approx(-way * (0.5 + 0.001 * EVERY[:80]))
    assert found[80:] == pytest.approx(0.5 + 0.001 * EVERY[80:])


def test_a_current_without_a_sign_has_that_of_its_voltage() -> None:
    one = record(200, unsigned=True, current=(EVERY, 0.7 + 0.001 * EVERY), speed=SPEED)
    one.sensed.volts[:80] *= -1.0
    found = signals(one).current
    assert found[:80] == pytest.approx(-(0.5 + 0.001 * EVERY[:80]))
    assert found[80:] == pytest.approx(0.5 + 0.001 * EVERY[80:])


@pytest.mark.parametrize(
    ("series", "words"),
    [
        ({"speed": SPEED}, r"no channel of the current in run\.h5"),
        ({"current": CURRENT}, r"no channel of the position or speed in run\.h5"),
    ],
)
def test_what_lacks_is_named(series: dict[str, Any], words: str) -> None:
    with pytest.raises(DataError, match=words):
        signals(record(200, **series))


def test_a_channel_whose_readings_are_all_bad_is_no_missing_channel() -> None:
    one = record(200, current=CURRENT, position=POSITION)
    del one.measured[1]
    one.capture.path = ""
    with pytest.raises(DataError, match=r"no usable reading .* of the position or speed: the fit"):
        signals(one)


@pytest.mark.parametrize(("steps", "moves"), [(1.4, False), (1.6, True)])
@pytest.mark.parametrize("name", ["current", "position", "speed"])
def test_a_channel_must_change_by_more_than_a_step(name: str, steps: float, moves: bool) -> None:
    """A step and a half, of 1e-4; of a motion as the motor's shaft sees it before a gear of 3."""
    gear = 1.0 if name == "current" else 3.0
    flat = (EVERY, np.where(EVERY < 100, 1.0, 1.0 + steps * gear * 1e-4))
    moving = {} if name == "position" else {"speed": SPEED}
    one = record(200, **{"current": CURRENT, **moving, name: flat})
    if moves:
        signals(one)
        return
    with pytest.raises(DataError, match=rf"the {name} never changes in run\.h5"):
        signals(one)


def test_of_two_motions_the_one_that_is_used_must_change() -> None:
    one = record(200, current=CURRENT, speed=SPEED, position=(EVERY, np.ones(200)))
    with pytest.raises(DataError, match="the position never changes"):
        signals(one)
    still = record(200, current=CURRENT, speed=(EVERY, np.ones(200)), position=POSITION)
    signals(still)


# pieces of a log


FLAT = (EVERY, np.ones(200))


def piece(path: str = "log.csv", waveform: Any = "by its readings", **series: Any) -> Any:
    """A moving piece of a log, but for its ``series``."""
    one = record(200, **{"current": CURRENT, "speed": SPEED, **series})
    one.capture.path, one.sensed.waveform = path, waveform
    return one


@pytest.mark.parametrize("name", ["current", "speed"])
def test_of_a_log_one_piece_may_stay_where_another_changes(name: str) -> None:
    """Whichever of them begins, and whatever changes in which."""
    flat, moving = piece(**{name: FLAT}), piece()
    for others in ([flat, moving], [moving, flat], [piece(**{name: FLAT}), flat, moving]):
        found = signals(flat, others)
        assert np.ptp(found.current if name == "current" else found.speed) == 0.0
        signals(moving, others)
    other = "speed" if name == "current" else "current"
    signals(flat, [flat, piece(**{other: FLAT})])
    with pytest.raises(DataError, match=rf"the {name} never changes in log\.csv"):
        signals(flat, [flat, piece(**{name: FLAT})])
    with pytest.raises(DataError, match=rf"the {name} never changes"):
        signals(flat)


def test_a_change_is_one_beyond_a_step_in_other_pieces_too() -> None:
    """A step and a half, of 3e-4 behind the gear."""
    for steps in (1.4, 1.6):
        flickers = piece(speed=(EVERY, 1.0 + steps * 3e-4 * (EVERY % 2)))
        if steps > 1.5:
            signals(piece(speed=FLAT), [flickers])
            continue
        with pytest.raises(DataError, match="the speed never changes"):
            signals(piece(speed=FLAT), [flickers])


def test_a_slow_shaft_s_speed_of_a_count_or_none_changes_by_its_mean() -> None:
    """Of 800 readings a tenth shows a count, and then half of them; of a flicker a fifth does."""
    step, drawn = 3e-4, np.random.default_rng(1).random(800)
    every, odds = np.arange(800), np.where(np.arange(800) < 400, 0.1, 0.5)
    current = (every, 0.5 + 0.01 * every)

    def counted(odds: Any) -> Any:
        return record(800, current=current, speed=(every, step * (drawn < odds)))

    signals(counted(odds))
    with pytest.raises(DataError, match="the speed never changes"):
        signals(counted(0.2))


@pytest.mark.parametrize(
    ("flat", "moving"),
    [
        ({}, {"path": "other.csv"}),  # another log has a sensor of its own
        ({"waveform": None}, {"waveform": None}),  # captures with a program
        ({"waveform": None}, {}),
        ({}, {"waveform": None}),
    ],
)
def test_another_log_or_a_program_must_change_by_itself(
    flat: dict[str, Any], moving: dict[str, Any]
) -> None:
    still, other = piece(speed=FLAT, **flat), piece(**moving)
    with pytest.raises(DataError, match="the speed never changes"):
        signals(still, [still, other])
    signals(other, [still, other])


def test_a_piece_that_lacks_the_channel_does_not_change_for_another() -> None:
    lacking = piece()
    del lacking.measured[1]
    still = piece(speed=FLAT)
    with pytest.raises(DataError, match="the speed never changes"):
        signals(still, [still, lacking])
    with pytest.raises(DataError, match="no usable reading"):
        signals(lacking, [lacking, piece()])


def log(moves: bool) -> list[MotorRecord]:
    """Records of a log that pauses, and whose bridge opens while it coasts at 50 rad/s."""
    at = np.arange(240)
    speed = np.where(at < 120, 50.0 + moves * 0.1 * at, 50.0)
    speed[160:200] -= np.linspace(0.0, 4.0, 40)
    speed[200:] = 46.0
    series = ("terminal_voltage", "V", 6.0 + 0.1 * (at % 7)), ("speed", "rad/s", speed)
    channels = {name: Channel(name, unit, y) for name, unit, y in series}
    channels["current"] = Channel("current", "A", 1.0 + 0.01 * (at % 5))
    ticks = 1000 * (at + 1000 * (at >= 120))
    capture = Capture(ticks, 1e6, channels, path="log.csv")
    *others, last = log_sections.unbroken([capture])
    parts = [*others, *log_sections.driven(last, [Opening(40, 80, 80)])]
    assert [len(one) for one in parts] == [*([120] if moves else []), 40, 40]
    return [MotorRecord(one, PARAMETERS, {}) for one in parts]


def test_a_log_is_refused_where_its_motion_changes_in_no_piece(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And not where it stays in some: two of three here, before and after a coast."""
    seen = given(monkeypatch, real=True)
    start_values.begun(log(moves=True), {})
    ((data, _),) = seen
    assert [np.ptp(one.speed) > 0.0 for one in data] == [True, False, False]
    with pytest.raises(DataError, match=r"the speed never changes in log\.csv"):
        start_values.begun(log(moves=False), {})


# which records have a say


def given(monkeypatch: pytest.MonkeyPatch, real: bool = False) -> list[Any]:
    """What the electrical part of a start is asked with; ``real``: signals, and not records."""
    seen: list[Any] = []
    if not real:
        monkeypatch.setattr(start_values, "signals", lambda one, _told: one)
    monkeypatch.setattr(
        start_values,
        "_electrical",
        lambda data, fixed: seen.append((data, fixed)) or (2.0, 3.0, 5.0),
    )
    monkeypatch.setattr(start_values, "mechanical", lambda data, K, fixed: (K, 7.0, len(data)))
    return seen


def test_records_without_a_motion_have_no_say_where_others_have_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = given(monkeypatch)
    by_angle = record(200, current=CURRENT, position=POSITION)
    by_speed, still = record(200, current=CURRENT, speed=SPEED), record(200, current=CURRENT)
    found, doubt = start_values.begun([by_angle, still, by_speed], {"J": 9.0})
    assert found == {"R": 2.0, "L": 3.0, "K": 5.0, "B": 5.0, "J": 9.0, "T0": 2}
    assert doubt is None
    start_values.begun([still], {})
    assert [data for data, _ in seen] == [[by_angle, by_speed], [still]]
    assert [start_values.shows_motion(one) for one in (by_angle, by_speed, still)] == [
        True, True, False,
    ]  # fmt: skip


def test_a_start_that_fails_is_that_of_another_lag_with_its_doubt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given(monkeypatch)
    reason = DataError("no inertia")

    def fails(*_: Any) -> Any:
        raise reason

    def mechanics(*asked: Any) -> Any:
        data, ohms, constant, fixed, solve, why = asked
        assert (len(data), ohms, constant, fixed) == (1, 2.0, 5.0, {"T0": 0.5})
        assert (solve, why) == (start_values.balanced, reason)
        return (11.0, 12.0, 13.0), Doubt(why, 0.25)

    monkeypatch.setattr(start_values, "mechanical", fails)
    monkeypatch.setattr(lagging_start, "mechanics", mechanics)
    moving = record(200, current=CURRENT, speed=SPEED)
    found, doubt = start_values.begun([moving], {"T0": 0.5})
    assert found == {"R": 2.0, "L": 3.0, "K": 5.0, "B": 11.0, "J": 12.0, "T0": 0.5}
    assert doubt == Doubt(reason, 0.25)
    assert start_values.start_values([moving], {"T0": 0.5}) == found


# a winding by what is left of it


def step(volts: float, ohms: float, count: int = 60) -> Signals:
    """A motor that stands: a constant current through its resistance alone, and a tiny turn."""
    flat = np.full(count, volts)
    turned = 1e-6 * np.arange(float(count)) ** 2 * np.sign(volts)
    return Signals(1e-3, flat, flat / ohms, turned, None, (0, count), (False,), 0.0)


def test_a_winding_that_no_window_tells_begins_by_the_peaks() -> None:
    """Half of the highest voltage over the highest current, and L/R of .3 of the least period."""
    one, other = step(6.0, -3.0), step(-12.0, -4.0)
    R, L, K = start_values._electrical([one, other], {"K": 0.05, "L": -1.0})
    assert pytest.approx(0.5 * 12.0 / 3.0) == R
    assert pytest.approx(0.3 * 2.0 * 1e-3) == L
    assert K == 0.05


def test_a_hidden_constant_is_the_share_of_the_voltage_that_goes_with_the_motion() -> None:
    rows = np.array([[3.0, 9.0, 9.0, 2.0], [4.0, 9.0, 9.0, -1.0]])
    assert start_values._unseen_constant(rows) == pytest.approx(0.02 * 25.0 / 2.0)
    with pytest.raises(DataError, match="against its voltage"):
        start_values._unseen_constant(rows * [1.0, 1.0, 1.0, -1.0])
    still = rows * [1.0, 1.0, 1.0, 0.0]
    with pytest.raises(DataError, match="against its voltage"):
        start_values._unseen_constant(still)


@pytest.mark.parametrize(
    ("samples", "step_rad", "width"),
    [
        (100, 0.0, 6), (240, 0.0, 10), (24 * 7, 0.0, 7),
        (240, 0.02, 40), (240, 1.0, 60), (60, 1.0, 15),  # 100 steps at 50 rad/s: 40 ms; a quarter
    ],
)  # fmt: skip
def test_a_window_has_six_samples_a_part_of_them_or_a_hundred_counts(
    samples: int, step_rad: float, width: int
) -> None:
    flat = np.zeros(samples)
    s = Signals(1e-3, flat, flat, flat, None, (0, samples), (False,), 0.0, step_rad)
    assert start_values._width(s, samples, 50.0) == width
