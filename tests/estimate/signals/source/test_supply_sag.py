"""A supply that gives way, against the simulated one: what it shows after every command."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Channel, Wiring
from motorid.estimate.signals.source.current_transient import rises, swing_at_start
from motorid.estimate.signals.source.supply_sag import Sag, sags
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_window import Window
from motorid.program import Decay, StepKind
from motorid.sim.bench import Bench
from motorid.sim.chain import draw_chain
from motorid.sim.options import Options

PWM_HZ, RAIL_V, PERIOD_S = 20_000, 6.0, 1e-4
SLOW = Decay.SYNCHRONOUS_SLOW
NOISE_V = 2e-3
STEPS = ((StepKind.COAST, 0.0), (StepKind.DRIVE_DUTY, 0.4), (StepKind.DRIVE_DUTY, 0.9))
LENGTHS = (40, 200, 200)
Steps = tuple[tuple[StepKind, float], ...]
Run = tuple[list[Part], np.ndarray, np.ndarray]  # parts, current and volts of every interval


def board(share: float, late: float, ripple: float = 0.0) -> Options:
    """Its supply has that share of the motor's resistance, and is late by so many intervals."""
    ohms = share * Options().preset.resistance_ohm
    return Options(
        pwm=PWM_HZ, dead_time=0.0, supply=RAIL_V, supply_resistance=ohms, bits=14, noise=0.3,
        supply_capacitance=late * PERIOD_S / ohms, bridge_resistance=0.0, heating=False,
        ripple=ripple,
    )  # fmt: skip


def run(options: Options, steps: Steps) -> np.ndarray:
    """(n, 3): mean current, mean terminal volts, and the current at the end of every interval."""
    bench = Bench(options, draw_chain(options))
    totals, ends = [bench.integrals()], []
    for (kind, level), length in zip(steps, LENGTHS, strict=True):
        bench.command(kind, level, SLOW)
        for _ in range(length):
            bench.run(1)
            totals.append(bench.integrals())
            ends.append(float(bench.plant.current))
    seconds, charge, flux, _ = np.array([np.subtract(b, a) for a, b in pairwise(totals)]).T
    return np.column_stack([charge / seconds, flux / seconds, ends])


def found(options: Options, steps: Steps) -> tuple[Mapping[int, Sag], Run]:
    """What the fit takes the sags for by noisy readings of whole intervals, and what is true."""
    current, volts, ends = run(options, steps).T
    count = len(current)
    starts = np.cumsum((0, *LENGTHS))
    parts = [
        Part(int(a), int(b), kind, level, SLOW if level else Decay.NONE)
        for (a, b), (kind, level) in zip(pairwise(starts), steps, strict=True)
    ]
    one = Capture(
        ticks=np.arange(count, dtype=np.int64) * 100,
        clock_hz=1e6,
        channels={CURRENT: Channel(CURRENT, "A", current)},
        wiring=Wiring(pwm_hz=PWM_HZ, supply_voltage_v=RAIL_V),
    )
    motor = options.preset
    R, L = motor.resistance_ohm, motor.inductance_h
    swing = [swing_at_start(one, part, L, R) for part in parts]
    ends = ends + np.repeat(swing, LENGTHS)
    risen = tuple(rises(one, parts, current, ends, L, R))
    read = volts + NOISE_V * np.random.default_rng(3).standard_normal(count)
    known = np.ones(count, dtype=bool)
    known[starts[1:-1]] = False  # the first reading shows the command before
    told = sags(Window(PERIOD_S, PERIOD_S), parts, read, current, known, current, risen, RAIL_V)
    return told, (parts, current, volts)


VOLTS = (STEPS[0], (StepKind.DRIVE_VOLTS, 2.0), (StepKind.DRIVE_VOLTS, 4.5))


@pytest.mark.parametrize(
    ("late", "steps"), [(1.0, STEPS), (3.0, STEPS), (12.0, STEPS), (1.0, VOLTS), (3.0, VOLTS)]
)
def test_the_first_intervals_have_the_voltage_of_the_supply(late: float, steps: Steps) -> None:
    """Beyond a line in the current, which every part has of its own: to 8 % of the largest."""
    told, (parts, current, volts) = found(board(0.05, late), steps)
    assert set(told) == {1, 2}
    off, largest = [], []
    for k, sag in told.items():
        here, settled = parts[k].slice, slice(60, None)
        lines = np.vander(current[here], 2)
        true, taken = (
            v - lines @ np.linalg.lstsq(lines[settled], v[settled], rcond=None)[0]
            for v in (volts[here], sag.taken)
        )
        off.append(np.abs(taken - true)[:8].max())
        largest.append(np.abs(true)[:8].max())
    assert max(off) < 0.08 * max(largest)


@pytest.mark.parametrize("late", [0.5, 1.0, 3.0])
def test_commutation_ripple_draws_on_the_supply_as_long_as_the_motor_turns(late: float) -> None:
    """Of what it takes beyond a line in the current, a quarter is left at most."""
    told, (parts, current, volts) = found(board(0.1, late, ripple=0.06), VOLTS)
    here = slice(parts[2].start + 120, parts[2].stop)  # long after the command
    lines = np.vander(current[here], 2)
    true, taken = (
        v - lines @ np.linalg.lstsq(lines, v, rcond=None)[0]
        for v in (volts[here], told[2].taken[120:])
    )
    assert np.std(true) > 1e-3
    assert np.std(taken - true) < 0.25 * np.std(true)


def test_a_stiff_supply_is_left_alone() -> None:
    told, _ = found(board(1e-4, 3.0), STEPS)
    assert not told
