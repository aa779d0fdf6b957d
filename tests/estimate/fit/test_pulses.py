"""An inductance by the size of a diode's pulses: brute force on pulses of a known one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Capture, Wiring
from motorid.estimate.fit import discontinuous_current_inductance as pulses
from motorid.estimate.fit.discontinuous_current_inductance import FEWEST, Pulses
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Quantity
from motorid.program import Decay, StepKind

L, R, RAIL, PWM_HZ, DUTY = 2e-4, 3.0, 12.0, 20e3, 0.3
AGAINST = np.linspace(1.0, 4.0, 40)


def made(henry: float = L, scale: float = 1.0, **other: Any) -> Pulses:
    """Pulses whose current is what that inductance lets through."""
    facts = {"against": AGAINST, "duty": DUTY, "period_s": 1 / PWM_HZ, "rail": RAIL, "ohms": R}
    one = Pulses(np.zeros(len(AGAINST)), **{**facts, **other})
    return Pulses(scale * one.mean_current(henry), **{**facts, **other})


def test_the_inductance_of_pulses_is_found_from_all_of_them() -> None:
    assert pulses._as_large([made()]) == pytest.approx(L, rel=1e-3)
    both = pulses._as_large([made(duty=0.2), made(duty=0.4)])
    assert both == pytest.approx(L, rel=1e-3)
    assert pulses._as_large([]) is None


def test_larger_pulses_are_of_a_smaller_inductance_and_beyond_some_of_none() -> None:
    twice = pulses._as_large([made(scale=1.5)])
    assert twice is not None
    assert twice < L
    assert pulses._as_large([made(scale=100.0)]) is None
    assert pulses._as_large([made(scale=1e-5)]) is None


def test_a_current_that_nothing_drives_does_not_flow() -> None:
    """Where the back-EMF is the supply, or more, there is no rise."""
    over = made(against=np.full(4, 20.0))
    assert over.mean == pytest.approx(0.0)
    assert (made(against=np.full(4, 11.0)).mean > 0.0).all()


def test_pulses_that_fill_their_periods_do_not_stop() -> None:
    assert made().stops(L)
    assert not made(duty=0.9, against=np.full(4, 1.0)).stops(L)


def looked(monkeypatch: pytest.MonkeyPatch, *found: Pulses) -> float | None:
    left = [list(found)]
    monkeypatch.setattr(pulses, "pulses_of", lambda *_: left.pop(0))
    solution: Any = SimpleNamespace(own=[None], values=None)
    record: Any = "record"
    return pulses.inductance([record], solution)


def test_what_flows_on_at_the_inductance_that_was_found_has_no_word(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert looked(monkeypatch, made()) == pytest.approx(L, rel=1e-3)
    through = made(duty=0.95, against=np.full(40, 0.5), scale=0.9)
    assert looked(monkeypatch, made(), through) == pytest.approx(L, rel=1e-3)
    assert looked(monkeypatch) is None


def record(
    parts: list[Part], pwm_hz: float = PWM_HZ, rail: float = RAIL, source: float = 0.0
) -> Any:
    n, period_s = parts[-1].stop, 1e-4
    capture = Capture(
        np.arange(n) * 100, 1e6, {}, wiring=Wiring(pwm_hz=pwm_hz, supply_voltage_v=rail)
    )
    speed, current = np.linspace(100.0, 200.0, n), np.linspace(0.5, 0.2, n)
    sign = np.sign(parts[0].level)

    def runs(shared: Any, own: Any, over: Any) -> Any:
        """Means over a sample of what is asked for, in the order of asking."""
        known = {Quantity.SPEED: sign * speed, Quantity.CURRENT: sign * current}
        assert (len(shared), len(own)) == (6, 0)
        assert {one.aperture_s for one in over} == {period_s}
        return [known[one.quantity] for one in over]

    return SimpleNamespace(
        shown_parts=parts, capture=capture, timeline=SimpleNamespace(period_s=period_s),
        runs=runs, emf_constant=lambda _: 0.05,
        sources=[None, *(SimpleNamespace(ohms=part * source) for part in (1.0, 0.3))],
        motor=lambda _: np.array([2.0, L, 0.05]),
        sensed=SimpleNamespace(series_ohm=0.4), brush_drop=lambda _s, _o, mean: 0.1 * mean,
    )  # fmt: skip


@pytest.mark.parametrize("level", [DUTY, -DUTY])
def test_each_part_whose_current_stops_has_pulses_along_its_drive(level: float) -> None:
    n = HEAD + FEWEST
    part = Part(0, n, StepKind.DRIVE_DUTY, level, Decay.DIODE, discontinuous=True)
    (one,) = pulses.pulses_of(record([part], source=0.6), np.zeros(6), np.zeros(0))
    assert len(one.mean) == FEWEST
    current, speed = np.linspace(0.5, 0.2, n)[HEAD:], np.linspace(100.0, 200.0, n)[HEAD:]
    assert one.mean == pytest.approx(current)
    assert one.against == pytest.approx(0.05 * speed + 0.1 * current / DUTY)
    assert (one.duty, one.rail) == pytest.approx((DUTY, RAIL))
    assert one.period_s == pytest.approx(1 / PWM_HZ)
    assert one.ohms == pytest.approx(2.0 + 0.4 + 0.6)


def test_a_short_part_and_an_unknown_pwm_tell_nothing() -> None:
    part = Part(0, HEAD + FEWEST, StepKind.DRIVE_DUTY, DUTY, Decay.DIODE, discontinuous=True)
    short = Part(0, HEAD + FEWEST - 1, StepKind.DRIVE_DUTY, DUTY, Decay.DIODE, discontinuous=True)
    through = Part(0, HEAD + FEWEST, StepKind.DRIVE_DUTY, DUTY, Decay.DIODE)
    for subject in (record([short]), record([through]), record([part], pwm_hz=0.0),
                    record([part], rail=0.0)):  # fmt: skip
        assert pulses.pulses_of(subject, np.zeros(6), np.zeros(0)) == []


def test_pulses_of_all_records_are_as_large_as_one_inductance_makes_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each record's by its own unknowns at the common parameters."""
    asked: list[Any] = []

    def pulses_of(record: Any, shared: Any, own: Any) -> list[Pulses]:
        asked.append((record, shared, own))
        return [made(duty=0.2 if record == "one" else 0.4)]

    monkeypatch.setattr(pulses, "pulses_of", pulses_of)
    records, solution = ["one", "two"], SimpleNamespace(own=["a", "b"], values="shared")
    found = pulses.inductance(records, solution)  # type: ignore[arg-type]
    assert found == pytest.approx(L, rel=1e-3)
    assert asked == [("one", "shared", "a"), ("two", "shared", "b")]


def test_a_current_flows_on_below_and_above_what_an_inductance_may_be() -> None:
    """From a thousandth to a hundred times L/R of a PWM period."""
    per_ohm = R / PWM_HZ
    for henry, known in ((2e-3, True), (5e-4, False), (50.0, True), (150.0, False)):
        found = pulses._as_large([made(henry * per_ohm)])
        assert (found is not None) is known
        assert found is None or found == pytest.approx(henry * per_ohm, rel=1e-2)


@pytest.mark.parametrize(("duty", "stops"), [(0.42, True), (0.48, False)])
def test_pulses_stop_where_the_middle_one_does(duty: float, stops: bool) -> None:
    """Of a small resistance they rise and fall straight: by on times 12 - e over 13.4 + e."""
    against = np.array([-9.0, 0.0, 9.0]) - 2.0
    one = Pulses(np.zeros(3), against, duty, 1e-3, 12.0, 1e-3)
    falls = duty * 14.0 / (12.0 + pulses.DIODE_DROPS_V - 2.0)
    assert (duty + falls < 1.0) is stops
    assert one.stops(1.0) is stops
