"""What a momentum balance is written in, what is free in it, and which rows a magnitude keeps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.partial import mechanical_fit, modulating_functions
from motorid.estimate.partial.mechanical_signals import COASTING, Motion, of_capture

Floats = NDArray[np.float64]
UNITS = {CURRENT: "A", SPEED: "rad/s", VOLTAGE: "V", TORQUE: "N·m"}
A, B, C = 1e-3, 5e-3, 0.04
H = 1e-3


def capture(**channels: Floats) -> Capture:
    n = len(next(iter(channels.values())))
    made = {name: Channel(name, UNITS[name], y) for name, y in channels.items()}
    return Capture(np.arange(n) * 1000, 1e6, made)


def swinging(n: int = 3000, one_way: bool = False) -> tuple[Floats, Floats]:
    """Speed and the drive that the balance asks for."""
    time = H * np.arange(n)
    w = 60.0 * np.sin(2 * np.pi * time) + (100.0 if one_way else 0.0)
    slope = 120.0 * np.pi * np.cos(2 * np.pi * time)
    return w, A * slope + B * w + C * np.sign(w)


def motion(one_way: bool = False) -> Motion:
    w, drive = swinging(one_way=one_way)
    return of_capture(capture(speed=w, current=drive), CURRENT)


def test_a_balance_is_for_what_lacks_a_voltage_or_a_current() -> None:
    x = np.ones(20)
    both = capture(current=x, terminal_voltage=x, speed=x)
    assert not mechanical_fit.suits([both])
    assert mechanical_fit.suits([both, capture(current=x, speed=x)])
    assert mechanical_fit.suits([capture(terminal_voltage=x, speed=x)])


@pytest.mark.parametrize(
    ("fix", "without", "words"),
    [
        ({"Q": 1.0}, (), "'Q' is not a parameter"), ({}, ("Q",), "'Q' is not a parameter"),
        ({"K": 0.0}, (), "--fix K=0: give a positive value"), ({"J": 0.0}, (), "--fix J=0"),
        ({"R": 0.0}, (), "--fix R=0"), ({"B": -1.0}, (), "--fix B=-1"),
        ({"T0": float("nan")}, (), "--fix T0=nan"), ({}, ("J",), "cannot do without it"),
        ({}, ("K",), "--without K"), ({}, ("R",), "--without R"),
    ],
)  # fmt: skip
def test_what_cannot_be_held_or_left_out_is_refused(
    fix: dict[str, float], without: tuple[str, ...], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        mechanical_fit.fit([motion_capture()], fix=fix, without=without)


def motion_capture() -> Capture:
    w, drive = swinging()
    return capture(speed=w, current=drive)


def test_no_friction_may_be_given_and_left_out() -> None:
    mechanical_fit._check({"B": 0.0, "T0": 0.0}, ("B", "T0", "L", "offset"))


def test_captures_share_one_drive() -> None:
    w, drive = swinging()
    current, torque = capture(speed=w, current=drive), capture(speed=w, torque=drive)
    assert mechanical_fit._common_drive([current, current]) == CURRENT
    assert mechanical_fit._common_drive([capture(speed=w)]) == COASTING
    with pytest.raises(DataError, match=r"different drives \(current, torque\)"):
        mechanical_fit._common_drive([current, torque])
    with pytest.raises(DataError, match="no capture was given"):
        mechanical_fit.fit([])


def wanted(drive: str, fix: dict[str, float] | None = None, without: Any = (),
           one_way: bool = False) -> tuple[list[bool], list[float]]:  # fmt: skip
    free, values = mechanical_fit._wanted([motion(one_way)], drive, fix or {}, without)
    return free.tolist(), values.tolist()


def test_all_is_free_but_what_is_held_or_left_out() -> None:
    assert wanted(CURRENT) == ([True] * 4, [0.0] * 4)
    assert wanted(CURRENT, without=("B", "offset", "L"))[0] == [True, False, True, False]
    assert wanted(TORQUE, {"J": 2e-4, "T0": 0.1}) == (
        [False, True, False, True], [2e-4, 0.0, 0.1, 0.0],
    )  # fmt: skip
    assert wanted(CURRENT, {"J": 2e-4, "K": 0.5}) == (
        [False, True, True, True], [4e-4, 0.0, 0.0, 0.0],
    )  # fmt: skip
    assert wanted(CURRENT, {"J": 2e-4})[0] == [True] * 4  # its ratio to K is not known
    assert wanted(VOLTAGE, {"J": 2e-4})[0] == [True] * 4


def test_in_one_direction_a_constant_load_is_friction() -> None:
    assert wanted(CURRENT, one_way=True)[0] == [True, True, True, False]
    assert wanted(CURRENT, without=("T0",), one_way=True)[0] == [True, True, False, True]


def test_a_coast_is_told_by_its_own_slowing() -> None:
    w = 200.0 * np.exp(-H * np.arange(2000.0))
    coast = of_capture(capture(speed=w), COASTING)
    free, values = mechanical_fit._wanted([coast], COASTING, {}, ())
    assert (free.tolist(), values.tolist()) == ([False, True, True, False], [1.0, 0, 0, 0])


@pytest.mark.parametrize(("rise", "coasts"), [(19.0, True), (21.0, False)])
def test_what_gets_faster_is_no_coast(rise: float, coasts: bool) -> None:
    """By a tenth of its top speed, for more than a twentieth of the time."""
    w = np.r_[np.linspace(200.0, 100.0, 1000), np.full(1000, 100.0 + rise)]
    found = of_capture(capture(speed=w), COASTING)
    if coasts:
        mechanical_fit._check_coasting([found])
        return
    with pytest.raises(DataError, match="the motor gets faster"):
        mechanical_fit._check_coasting([found])


def test_a_position_that_coasts_is_looked_at_without_its_noise() -> None:
    angle = np.cumsum(200.0 * np.exp(-H * np.arange(2000.0))) * H
    rough = angle + 2e-3 * np.random.default_rng(1).standard_normal(2000)
    made = Channel("position", "rad", rough)
    one = Capture(np.arange(2000) * 1000, 1e6, {"position": made})
    mechanical_fit._check_coasting([of_capture(one, COASTING)])


def test_widths_are_octaves_from_a_few_samples_to_a_quarter_of_a_run() -> None:
    widths = mechanical_fit._widths([motion()])
    assert widths[0] == pytest.approx(4 * H)
    assert np.diff(np.log2(widths)) == pytest.approx(1.0)
    assert widths[-1] <= 2.999 / 4 < 2 * widths[-1]
    w, drive = swinging()
    mean = Channel(CURRENT, "A", drive, kind="mean", aperture_s=0.02)
    one = Capture(np.arange(3000) * 1000, 1e6, {CURRENT: mean, SPEED: Channel(SPEED, "rad/s", w)})
    assert mechanical_fit._widths([of_capture(one, CURRENT)])[0] == pytest.approx(0.02)
    brief = of_capture(capture(speed=w[:20], current=drive[:20]), CURRENT)
    assert mechanical_fit._widths([brief]) == pytest.approx([4 * H])


def test_too_few_rows_are_no_regression() -> None:
    w, drive = swinging()
    brief = of_capture(capture(speed=w[:60], current=drive[:60]), CURRENT)
    free, values = np.ones(4, dtype=bool), np.zeros(4)
    rows = modulating_functions.build([brief], 4 * H)
    assert len(rows) > mechanical_fit.FEWEST_ROWS
    assert mechanical_fit._at_width([brief], free, values, 4 * H) is not None
    assert mechanical_fit._at_width([brief], free, values, 8 * H) is None
    with pytest.raises(DataError, match=r"at least 10 bumps of 4 samples"):
        mechanical_fit.fit([capture(speed=w[:40], current=drive[:40])])


def unsigned(noise: float = 0.0) -> Motion:
    w, drive = swinging()
    size = np.abs(drive) + noise * np.random.default_rng(3).standard_normal(len(w))
    channel = Channel(CURRENT, "A", size, unsigned=True)
    one = Capture(
        np.arange(len(w)) * 1000, 1e6, {CURRENT: channel, SPEED: Channel(SPEED, "rad/s", w)}
    )
    return of_capture(one, CURRENT)


def test_a_magnitude_gets_the_sign_of_the_speed() -> None:
    found = mechanical_fit._with_sign(unsigned())
    w, drive = swinging()
    assert found.drive == pytest.approx(np.abs(drive) * np.sign(w))
    signed = motion()
    assert mechanical_fit._with_sign(signed) is signed


def test_rows_in_which_the_drive_may_have_been_reversed_are_left_out() -> None:
    """While it brakes a magnitude has the wrong sign: those rows would spoil the answer."""
    free, values = np.array([True, True, True, False]), np.zeros(4)
    signed = mechanical_fit._with_sign(unsigned(2e-3))
    best = mechanical_fit._with_sure_signs([signed], free, values, 0.032)
    assert best is not None
    assert best.coefficients[:3] == pytest.approx([A, B, C], rel=0.05)
    naive = mechanical_fit._at_width([signed], free, values, 0.032)
    assert naive is not None
    assert abs(naive.coefficients[0] / A - 1.0) > 0.3
    drive = (
        best.rows.matrix @ best.coefficients / best.rows.weight * np.sign(best.rows.matrix[:, 2])
    )
    assert drive.min() > 0.0
    assert len(best.rows) < len(naive.rows)


def test_a_magnitude_that_is_lost_in_its_noise_tells_nothing() -> None:
    free, values = np.array([True, True, True, False]), np.zeros(4)
    assert mechanical_fit._with_sure_signs([unsigned(50.0)], free, values, 0.02) is None


def test_noise_is_that_of_the_motion_and_not_of_the_rest() -> None:
    w = np.r_[np.zeros(500), np.full(500, 50.0)]
    found = of_capture(capture(speed=w, current=np.ones(1000)), CURRENT)
    turning = mechanical_fit._turning(found)
    assert np.flatnonzero(turning).tolist() == list(range(500, 1000))
    still = of_capture(capture(speed=np.r_[np.zeros(999), 1e-9], current=np.ones(1000)), CURRENT)
    assert mechanical_fit._turning(still).all()


def test_a_coast_by_its_voltage_needs_the_constant_for_an_inertia() -> None:
    volts = Channel(VOLTAGE, "V", 5.0 * np.exp(-H * np.arange(2000.0)))
    one = Capture(np.arange(2000) * 1000, 1e6, {VOLTAGE: volts})
    with pytest.raises(UsageError, match="needs --fix K=VALUE beside --fix J"):
        mechanical_fit.fit([one], fix={"J": 1e-5})


@pytest.mark.parametrize("unsigned", [(False, False), (True, False), (False, True), (True, True)])
def test_one_magnitude_among_the_drives_restores_the_signs_of_all_that_need_it(
    unsigned: tuple[bool, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    ways: list[Any] = []
    motions: Any = [replace(motion(), unsigned=one) for one in unsigned]
    monkeypatch.setattr(mechanical_fit, "choose_width", lambda _, at, __: at(0.1))
    monkeypatch.setattr(mechanical_fit, "_at_width", lambda given, *_: ways.append(given))
    monkeypatch.setattr(
        mechanical_fit, "_with_sure_signs", lambda given, *_: ways.append(["signed", *given])
    )
    mechanical_fit._regress(motions, np.ones(4, bool), np.zeros(4))
    if not any(unsigned):
        assert ways == [motions]
        return
    ((mark, *given),) = ways
    assert mark == "signed"
    for before, after in zip(motions, given, strict=True):
        assert (after is before) is not before.unsigned
        assert after.unsigned is before.unsigned or not after.unsigned
