"""What a bridge's dead time takes, against the simulated bridge, which shares nothing with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from motorid.capture.model import SUPPLY, Capture, Channel, Wiring
from motorid.estimate.signals.source.current_transient import PLACES, rises, swing_at_start
from motorid.estimate.signals.source.dead_time import DeadTime, dead_time_loss, swinging, turning
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind
from motorid.sim.bench import Bench
from motorid.sim.chain import draw_chain
from motorid.sim.options import Options

PWM_HZ, DEAD_S, RAIL_V = 20_000, 1e-6, 6.0
OPTIONS = Options(
    pwm=PWM_HZ, dead_time=DEAD_S, supply=RAIL_V, supply_resistance=1e-5, supply_capacitance=50.0,
    bridge_resistance=0.0, heating=False, stiction=1.0,
)  # fmt: skip


def shown(duty: float, decay: Decay) -> tuple[np.ndarray, np.ndarray]:
    """Mean current (n,) and the volts (n,) that are missing, as the motor comes up to speed."""
    bench = Bench(OPTIONS, draw_chain(OPTIONS))
    bench.command(StepKind.DRIVE_DUTY, duty, decay)
    totals = [bench.integrals()]
    for _ in range(1500):
        bench.run(1)
        totals.append(bench.integrals())
    seconds, charge, flux, supply = np.array([np.subtract(b, a) for a, b in pairwise(totals)]).T
    return charge / seconds, (duty * supply - flux) / seconds


def bridge(duty: float, decay: Decay) -> tuple[Capture, Part]:
    """A capture of that bridge as far as it is asked for here, and its driven part."""
    count = 1500
    one = Capture(
        ticks=np.arange(count, dtype=np.int64) * 100,
        clock_hz=1e6,
        channels={SUPPLY: Channel(SUPPLY, "V", np.full(count, RAIL_V))},
        wiring=Wiring(pwm_hz=PWM_HZ, dead_time_s=DEAD_S),
    )
    return one, Part(0, count, StepKind.DRIVE_DUTY, duty, decay)


def model(duty: float, decay: Decay) -> DeadTime:
    """What the fit takes the dead time for."""
    motor = OPTIONS.preset
    found = DeadTime.of(*bridge(duty, decay), motor.inductance_h, motor.resistance_ohm)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("duty", "decay"),
    [
        (0.3, Decay.SYNCHRONOUS_SLOW),
        (-0.7, Decay.SYNCHRONOUS_SLOW),
        (0.5, Decay.FAST),
        (-0.4, Decay.FAST),
    ],
)
def test_the_loss_is_that_of_the_bridge_however_the_ripple_lies(duty: float, decay: Decay) -> None:
    current, lost = shown(duty, decay)
    found = model(duty, decay)
    most = float(np.abs(found.volts).max())
    along = np.sign(duty) * current
    turned = along < found.amperes[4]
    assert turned.sum() > 100  # the ripple comes to pass zero
    late = np.arange(len(current)) > 20  # the supply's windows have settled
    assert np.abs(found.lost(current) - lost)[late].mean() < 0.015 * most
    assert np.abs(lost[late & (along > 1.3 * found.amperes[5])]).min() > 0.97 * most


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.FAST])
def test_without_an_inductance_the_loss_has_the_currents_sign(decay: Decay) -> None:
    one, part = bridge(0.4, decay)
    resistance = OPTIONS.preset.resistance_ohm
    lost, _ = dead_time_loss(one, [part], np.linspace(-1.0, 1.0, 1500), 0.0, resistance)
    full = model(0.4, decay).volts
    assert lost[0] == pytest.approx(full.min())
    assert lost[-1] == pytest.approx(full.max())
    assert (np.diff(lost) > -1e-9).all()


def stepped(before: float, duty: float, decay: Decay) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean currents (6,) and missing volts (6,) from the interval before a command on, and the
    current at the end of the first interval under it. ``before``: the duty until then; 0: rest.
    """
    bench = Bench(OPTIONS, draw_chain(OPTIONS))
    if before:
        bench.command(StepKind.DRIVE_DUTY, before, decay)
        bench.run(4000)
    totals, ends = [bench.integrals()], []
    for n in range(6):
        if n == 1:
            bench.command(StepKind.DRIVE_DUTY, duty, decay)
        bench.run(1)
        totals.append(bench.integrals())
        ends.append(float(bench.plant.current))
    seconds, charge, flux, supply = np.array([np.subtract(b, a) for a, b in pairwise(totals)]).T
    command = np.array([before] + [duty] * 5)
    return charge / seconds, (command * supply - flux) / seconds, ends[1]


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.FAST])
@pytest.mark.parametrize(("before", "duty"), [(0.0, 0.5), (0.3, 0.6), (0.4, -0.4), (-0.5, -0.8)])
def test_the_first_interval_loses_period_by_period(
    before: float, duty: float, decay: Decay
) -> None:
    """The first PWM period finds the current of before, all of whose ripple is the old one."""
    current, lost, end = stepped(before, duty, decay)
    one, part = bridge(duty, decay)
    motor = OPTIONS.preset
    R, L = motor.resistance_ohm, motor.inductance_h
    kind = StepKind.DRIVE_DUTY if before else StepKind.COAST
    parts = [Part(0, 1, kind, before, decay if before else Decay.NONE), replace(part, start=1)]
    mean = np.concatenate([current, np.full(len(one) - 6, current[-1])])
    # the model's current knows of no ripple, nor of the jump in the mean that its change makes
    swings = [swing_at_start(one, p, L, R) for p in parts]
    tau, jump = L / R / one.period_s, swings[1] - swings[0]
    forgotten = np.exp(-np.arange(6) / tau)
    mean[1:6] -= jump * tau * (forgotten[:5] - forgotten[1:])
    ends = np.concatenate([mean[:1], [end + swings[1] - jump * forgotten[1]], mean[2:]])
    risen = list(rises(one, parts, mean, ends, L, R))
    even = np.full(len(PLACES), 1 / len(PLACES))
    _, found = dead_time_loss(one, parts, mean, L, R, risen, even)
    settled, _ = dead_time_loss(one, parts, mean, L, R)
    most = float(np.abs(model(duty, decay).volts).max())
    assert abs(found[1] - lost[1]) < 0.15 * most
    assert abs(found[1] - lost[1]) <= abs(settled[1] - lost[1]) + 0.02 * most


def test_a_current_that_turns_earlier_loses_less() -> None:
    """The shape of what is unsure of it is the difference of the loss, and none far from there."""
    duty = 0.5
    one, part = bridge(duty, Decay.SYNCHRONOUS_SLOW)
    motor, found = OPTIONS.preset, model(duty, Decay.SYNCHRONOUS_SLOW)
    far, near = 3.0 * found.amperes[5], found.amperes[4]

    def at(amperes: Sequence[float]) -> np.ndarray:
        current = np.resize(np.asarray(amperes), 1500)
        return turning(one, [part], current, motor.inductance_h, motor.resistance_ohm)

    assert at([far])[0] == 0.0
    assert at([near])[0] > 1.0 * found.volts[5]
    assert at([0.0])[0] == pytest.approx(0.0, abs=1e-12)


def test_diodes_alone_need_no_dead_time() -> None:
    assert DeadTime.of(*bridge(0.5, Decay.DIODE), 1e-3, 1.0) is None
    assert DeadTime.of(*bridge(1.0, Decay.SYNCHRONOUS_SLOW), 1e-3, 1.0) is None


@pytest.mark.parametrize("duty", [0.3, -0.6])
@pytest.mark.parametrize("given", [0.0, 1.0])
def test_a_model_with_the_wrong_loss_tells_the_current_that_the_bridge_has(
    duty: float, given: float
) -> None:
    """Given none of the loss, or all of it at every current, at the speed that the motor has."""
    motor = OPTIONS.preset
    one, part = bridge(duty, Decay.SYNCHRONOUS_SLOW)
    current, lost = shown(duty, Decay.SYNCHRONOUS_SLOW)
    dead = model(duty, Decay.SYNCHRONOUS_SLOW)
    taken = np.full(len(current), given * dead.lost(np.array([1e3 * duty]))[0])
    wrong = current + (lost - taken) / motor.resistance_ohm
    known = (motor.inductance_h, motor.resistance_ohm)
    found = wrong - swinging(one, part, wrong, taken, *known)
    late = slice(5, None)  # the current has risen
    off = np.abs(found - current)[late] / np.abs(wrong - current)[late].max()
    assert np.median(off) < 1e-3
    assert off.max() < 0.06  # where it turns: the current still falls, and L takes its share
    kept = swinging(one, part, found, dead.lost(found), *known)
    assert np.abs(kept).max() < 1e-3 * np.abs(dead.amperes).min()  # and there it stays


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.FAST])
def test_readings_of_all_places_see_what_the_interval_loses(decay: Decay) -> None:
    """By linearity; and a reading sees other places than the interval's mean where it is one."""
    one, part = bridge(0.4, decay)
    motor = OPTIONS.preset
    R, L = motor.resistance_ohm, motor.inductance_h
    parts = [Part(0, 1), replace(part, start=1)]
    mean = 0.4 * (1.0 - np.exp(-np.arange(1500) / 4.0))
    risen = list(rises(one, parts, mean, mean + 0.02, L, R))

    def loses(seen: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        return dead_time_loss(one, parts, mean, L, R, risen, seen)

    lost, as_lost = loses(None)
    assert as_lost == pytest.approx(lost)
    each = [loses(row)[1] for row in np.eye(len(PLACES))]
    among = risen[0].weights @ np.array(each)[:, risen[0].where]
    assert among == pytest.approx(lost[risen[0].where])
    assert np.ptp(np.array(each)[:, 1]) > 0.1 * np.abs(lost).max()
    late = slice(risen[0].where.stop, None)
    assert each[3][late] == pytest.approx(lost[late])
