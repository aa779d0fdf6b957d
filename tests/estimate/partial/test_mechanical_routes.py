"""Which way a mechanical fit goes, by the captures; what each part of it is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.partial import mechanical_fit as module
from motorid.estimate.partial import open_circuit_coastdown
from motorid.estimate.partial.mechanical_fit import NARROWEST
from motorid.estimate.partial.mechanical_signals import of_capture
from motorid.estimate.results.estimate import Diagnostic, Estimate
from tests.report.example import estimate, parameter

Floats = NDArray[np.float64]
UNITS = {CURRENT: "A", SPEED: "rad/s", VOLTAGE: "V"}
H = 1e-3


def capture(**channels: Floats) -> Capture:
    n = len(next(iter(channels.values())))
    made = {name: Channel(name, UNITS[name], y) for name, y in channels.items()}
    return Capture(np.arange(n) * 1000, 1e6, made)


def running(current: float = 1.0) -> Capture:
    wave = np.sin(np.arange(400) / 20.0)
    return capture(speed=wave, current=current * wave)


STILL = capture(speed=np.zeros(400), current=np.ones(400))
LAG = Diagnostic("unstated_lag", "info", "late")


class Routes:
    """Notes what each part is given, and answers with its name."""

    def __init__(
        self, patch: pytest.MonkeyPatch, steps: bool = False, lag: bool = False, fan: bool = False
    ) -> None:
        self.asked: dict[str, tuple[Any, ...]] = {}
        self.widened = SimpleNamespace(name="widened")
        self.wider = SimpleNamespace(name="wider", widened=lambda *_: self.widened)
        best = SimpleNamespace(name="best", widened=lambda *_: self.widened)
        known = estimate()

        def notes(name: str, answer: Any) -> Any:
            def part(*given: Any, **more: Any) -> Any:
                self.asked[name] = (*given, *more.values())
                return answer

            return part

        self.best, self.found = best, known
        patch.setattr(module.step_response, "steps", notes("steps", ["a step"] if steps else None))
        patch.setattr(module.step_response, "fit", notes("step fit", known))
        patch.setattr(module, "_regress", notes("regress", best))
        later = SimpleNamespace(
            motions=["later"], terms=("late",) if lag else (), said=LAG if lag else None,
            of=notes("timing", self.wider if lag else best),
        )  # fmt: skip
        patch.setattr(module.unstated_lag, "looked_for", notes("lag", later))
        square = SimpleNamespace(wider="with a fan" if fan else None, moves=("a move",))
        patch.setattr(module.square_of_speed, "looked_for", notes("square", square))
        patch.setattr(module.square_of_speed, "named", notes("named", known))
        patch.setattr(module.mechanical_remarks, "find", notes("find", ("a remark",)))
        patch.setattr(module.mechanical_results, "estimate", notes("estimate", known))


def test_a_balance_is_of_the_captures_that_move_and_says_so_of_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes = Routes(monkeypatch)
    captures = [STILL, running(1.0), STILL, running(2.0), STILL]
    assert module.fit(captures, fix={"K": 0.5}, without=("B",)) is routes.found
    moving = [captures[1], captures[3]]
    assert routes.asked["steps"] == (moving,)
    given = routes.asked["estimate"]
    assert given[0] == moving
    assert given[1] == ["later"]
    assert [m.drive_name for m in routes.asked["lag"][2]] == [CURRENT, CURRENT]
    assert given[2] is routes.widened
    assert "named" not in routes.asked
    assert given[3:6] == (CURRENT, {"K": 0.5}, ("B",))
    assert [getattr(one, "code", one) for one in given[6]] == ["standing_still", "a remark"]
    assert given[6][0].message.startswith("3 captures were left out")
    assert routes.asked["find"][:3] == (moving, ["later"], routes.widened)
    assert routes.asked["find"][3] is None


def test_where_all_move_nothing_is_said_and_a_lag_is_solved_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes = Routes(monkeypatch, lag=True)
    module.fit([running()])
    assert routes.asked["estimate"][2] is routes.widened
    assert routes.asked["estimate"][6] == ("a remark",)
    assert routes.asked["find"][2:] == (routes.widened, LAG)
    captures, drive, motions, best, regress = routes.asked["lag"]
    assert (len(captures), drive, best, len(motions)) == (1, CURRENT, routes.best, 1)
    given, wanted, values, terms, settled = routes.asked["regress"]
    assert (given, terms, settled) == (["later"], ("late",), True)
    assert routes.asked["timing"] == (routes.best,)
    assert regress(["other"], ("late",)) is routes.best
    again = routes.asked["regress"]
    assert again[0] == ["other"]
    assert again[1] is wanted
    assert again[2] is values
    assert again[3] == ("late",)


def test_a_fan_is_looked_for_beside_a_lag_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    routes = Routes(monkeypatch, lag=True, fan=True)
    assert module.fit([running()]) is routes.found
    drive, best, regress = routes.asked["square"]
    assert (drive, best) == (CURRENT, routes.wider)
    assert regress(("square",)) is routes.best
    assert routes.asked["regress"][3] == ("square", "late")
    assert routes.asked["timing"] == ("with a fan",)
    assert routes.asked["estimate"][2] is routes.wider  # the last: with the fan
    assert routes.asked["named"] == (routes.found, routes.found, CURRENT)


def test_single_steps_are_fitted_as_such_beside_captures_that_stand(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes = Routes(monkeypatch, steps=True)
    assert module.fit([running()], fix={"K": 0.5}, without=("T0",)) is routes.found
    assert routes.asked["step fit"] == (["a step"], {"K": 0.5}, ("T0",))
    beside = module.fit([STILL, running()])
    first, *others = beside.diagnostics
    assert (first.code, others) == ("standing_still", list(routes.found.diagnostics))
    assert first.message.startswith("One capture was left out")
    assert "regress" not in routes.asked


def test_where_none_moves_the_first_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    Routes(monkeypatch)
    with pytest.raises(DataError, match="never changes"):
        module.fit([STILL, STILL])
    routes = Routes(monkeypatch, steps=True)
    module.fit([STILL, STILL])
    assert routes.asked["steps"] == ([STILL],)


def test_too_few_rows_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    Routes(monkeypatch)
    monkeypatch.setattr(module, "_regress", lambda *_: None)
    with pytest.raises(DataError, match="at least 10 bumps of 4 samples"):
        module.fit([running()])


# a coast-down by its voltage

FALLING = 6.0 * np.exp(-np.arange(400) / 100.0)


def by_voltage(patch: pytest.MonkeyPatch, fix: dict[str, float]) -> tuple[Estimate, list[Any]]:
    """What is made of an answer to T0/J = 300, and what was asked."""
    asked: list[Any] = []
    moves = {"T0/J": 0.7, "B/J": 0.2}
    answer = replace(
        estimate(), combinations={"T0/J": parameter("T0/J", "rad/s²", 300.0)},
        not_stated={"gain of the speed": moves, "another": moves},
    )  # fmt: skip

    def fitted(captures: Sequence[Capture], **how: Any) -> Estimate:
        asked.append((captures, how))
        return answer

    one = capture(terminal_voltage=FALLING)
    assert open_circuit_coastdown.is_tachometer(one)
    patch.setattr(module, "fit", fitted)
    return module._by_voltage([one, one], fix, ("B",)), asked


def test_an_open_motors_voltage_is_its_speed_by_its_constant(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, asked = by_voltage(monkeypatch, {"K": 0.05, "J": 1e-5})
    ((turning, how),) = asked
    assert how == {"fix": {"K": 0.05, "J": 1e-5}, "without": ("B",)}
    assert len(turning) == 2
    for one in turning:
        assert set(one.channels) == {SPEED}
        assert one.channels[SPEED].values == pytest.approx(FALLING / 0.05)
    assert found.combinations["T0/J"].value == 300.0
    assert found.not_stated == {VOLTAGE_GAIN.name: {"T0/J": 0.7, "B/J": 0.2}}


def test_without_a_constant_the_friction_is_told_in_volts(monkeypatch: pytest.MonkeyPatch) -> None:
    found, asked = by_voltage(monkeypatch, {})
    assert asked[0][0][0].channels[SPEED].values == pytest.approx(FALLING)
    told = found.combinations["K·T0/J"]
    assert (told.name, told.unit, told.value) == ("K·T0/J", "V/s", 300.0)
    assert "T0/J" not in found.combinations
    assert found.not_stated == {VOLTAGE_GAIN.name: {"K·T0/J": 0.7, "B/J": 0.2}}
    with pytest.raises(UsageError, match="beside --fix J"):
        module._by_voltage([capture(terminal_voltage=FALLING)], {"J": 1e-5}, ())


def test_a_voltage_as_a_speed_keeps_its_doubts_by_the_constant() -> None:
    read = Channel(VOLTAGE, "V", np.arange(9.0), scale=2.0, offset=1.0, resolution=0.3, noise=0.2,
                   offset_uncertainty=0.1, gain_uncertainty=0.01, sense="terminals")  # fmt: skip
    one = Capture(1000 * np.arange(9), 1e6, {VOLTAGE: read})
    speed = open_circuit_coastdown.speed_from_voltage(one, 0.05).channels[SPEED]
    assert speed.values == pytest.approx((np.arange(9.0) - 1.0) * 2.0 / 0.05)
    assert (speed.resolution, speed.noise, speed.offset_uncertainty) == pytest.approx(
        (6.0, 4.0, 2.0)
    )
    assert (speed.name, speed.unit, speed.sense, speed.gain_uncertainty) == (
        SPEED, "rad/s", None, 0.01,
    )  # fmt: skip
    moving = running()
    assert open_circuit_coastdown.speed_from_voltage(moving, 0.05) is moving


def test_all_captures_are_of_a_voltage_alone_or_it_is_the_drive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes = Routes(monkeypatch)
    wave = np.sin(np.arange(400) / 20.0)
    with pytest.raises(DataError, match="lacks speed and position"):
        module.fit([capture(terminal_voltage=wave, speed=wave), capture(terminal_voltage=FALLING)])
    assert "estimate" not in routes.asked


# widths and coasting


def motion(count: int, aperture_s: float = 0.0, begin_s: float = 0.0) -> Any:
    wave = np.sin(np.arange(count) / 20.0)
    one = of_capture(capture(speed=wave, current=wave), CURRENT)
    return replace(one, time_s=one.time_s + begin_s, aperture_s=aperture_s)


@pytest.mark.parametrize(
    ("motions", "narrow", "octaves"),
    [
        ([motion(1030)], 4 * H, 6),  # 1.024 s: 4 ms times 2⁶ is a quarter
        ([motion(1020)], 4 * H, 5),
        ([motion(1030, begin_s=3.0)], 4 * H, 6),
        ([motion(300), motion(1030)], 4 * H, 6),  # the longest
        ([motion(1030, 16 * H), motion(300)], 16 * H, 4),  # the widest aperture
        ([motion(20)], 4 * H, 0),
    ],
)
def test_widths_are_octaves_from_a_few_samples_to_a_quarter_of_the_longest_run(
    motions: list[Any], narrow: float, octaves: int
) -> None:
    assert NARROWEST == 4
    assert module._widths(motions) == pytest.approx([narrow * 2**k for k in range(octaves + 1)])


@pytest.mark.parametrize(("rise", "refused"), [(0.08, False), (0.12, True)])
def test_a_motor_that_coasts_gets_no_faster_by_a_tenth(rise: float, refused: bool) -> None:
    """Of its highest speed, for more than a twentieth of the time."""
    speed = np.linspace(100.0, 50.0, 1000)
    speed[900:] = 55.0 + 100.0 * rise
    still = np.zeros(1000)
    one = of_capture(capture(speed=speed, current=still), CURRENT)
    if refused:
        with pytest.raises(DataError, match="gets faster"):
            module._check_coasting([one])
        with pytest.raises(DataError, match="gets faster"):
            module._wanted([one], module.COASTING, {}, ())
    else:
        module._check_coasting([one])
    backwards = replace(one, measured_speed=-speed)
    if refused:
        with pytest.raises(DataError, match="gets faster"):
            module._check_coasting([backwards])


def test_a_log_with_a_supply_and_a_duty_is_fitted_by_its_current() -> None:
    """It was refused: 'the capture holds no voltage'. The report says how to make one."""
    time = np.arange(0.0, 6.0, 0.01)
    speed = 100.0 + 60.0 * np.sin(2.0 * time) + 20.0 * np.sin(5.3 * time)
    slope = 120.0 * np.cos(2.0 * time) + 106.0 * np.cos(5.3 * time)
    channels = {
        "current": Channel("current", "A", 7e-4 * slope + 3e-4 * speed + 0.1),
        "speed": Channel("speed", "rad/s", speed),
        "supply_voltage": Channel("supply_voltage", "V", np.full(len(time), 12.0)),
        "command": Channel("command", "1", 0.3 + 0.002 * speed),
    }
    log = Capture(np.rint(time * 1e9).astype(np.int64), 1e9, channels)
    assert module.suits([log])
    found = module.fit([log])
    assert found.combinations["J/K"].value == pytest.approx(7e-4, rel=0.01)
    (said,) = [d.message for d in found.diagnostics if d.code == "duty_and_supply"]
    assert "voltage=COMMAND/FULL*SUPPLY:V" in said
