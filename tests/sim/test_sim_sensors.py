"""Windows, instants and counts of the measuring chain against a twin plant in small steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib

from motorid.sim.bench import Bench, plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import Options, parse_url
from motorid.wire.enums import Decay, StepKind

EXACT = "noise=0&gain_error=0&voltage_gain_error=0&offset_error=0&clock_ppm=0&bits=15"
MICRO = 1e-6
SAMPLES = 60
DUTY = 0.6


def twin_readings(options: Options, period_us: int) -> dict[str, np.ndarray]:
    """State and integrals of the same plant at every microsecond, from the first tick on."""
    par = plant_params(options, draw_chain(options))
    plant: Any = ffi.new("plant *")
    lib.plant_init(plant, par)
    lib.plant_command(plant, lib.PLANT_DRIVE, DUTY, Decay.SYNCHRONOUS_SLOW)
    rows = [(0.0, 0.0, 0.0, 0.0, 0.0)]
    for n in range(SAMPLES * period_us):
        lib.plant_advance(plant, MICRO)
        if (n + 1) % period_us == 0:
            lib.plant_new_period(plant)
        rows.append((plant.current, plant.i_dt, plant.v_dt, plant.supply_dt, plant.angle))
    return dict(zip(("i", "i_dt", "v_dt", "s_dt", "angle"), np.array(rows).T, strict=True))


def bench_readings(options: Options, period_us: int) -> tuple[np.ndarray, np.ndarray]:
    bench = Bench(options, draw_chain(options))
    bench.set_period(16 * period_us)
    bench.command(StepKind.DRIVE_DUTY, DUTY, Decay.SYNCHRONOUS_SLOW)
    return bench.run(SAMPLES)


@pytest.mark.parametrize(
    ("query", "period_us", "aperture", "delay", "voltage_aperture", "voltage_delay"),
    [
        ("", 100, 50, 5, 100, 0),
        ("", 50, 50, 5, 100, 0),  # both windows reach back into the sample before
        ("aperture=20e-6&delay=12e-6&voltage_aperture=64e-6", 150, 20, 12, 64, 0),
        ("voltage_aperture=50e-6&voltage_delay=9e-6", 100, 50, 5, 50, 9),
    ],
)
def test_a_mean_is_over_the_declared_window(
    query: str,
    period_us: int,
    aperture: int,
    delay: int,
    voltage_aperture: int,
    voltage_delay: int,
) -> None:
    options = parse_url(f"sim://?{EXACT}&{query}")
    raw, _ = bench_readings(options, period_us)
    twin, chain = twin_readings(options, period_us), draw_chain(options)
    ends = np.arange(3, SAMPLES + 1) * period_us
    for column, key, width, lag in (
        (0, "i_dt", aperture, delay),
        (1, "v_dt", voltage_aperture, voltage_delay),
        (2, "s_dt", voltage_aperture, voltage_delay),
    ):
        converter = chain.converters[column]
        end = ends - lag
        mean = (twin[key][end] - twin[key][end - width]) / (width * MICRO)
        counts = mean / converter.scale + converter.offset
        assert np.abs(raw[2:, column] - counts).max() <= 0.55, key


def test_a_delay_that_is_declared_wrong_acts_as_it_truly_is() -> None:
    options = parse_url(f"sim://?{EXACT}&delay=20e-6&delay_uncertainty=4e-6&seed=3")
    true_s = draw_chain(options).current.true_delay_s
    assert abs(true_s - 20e-6) > 1e-6
    exact = parse_url(f"sim://?{EXACT}&delay={true_s!r}&seed=3")
    wrong, _ = bench_readings(options, 100)
    right, _ = bench_readings(exact, 100)
    nominal, _ = bench_readings(parse_url(f"sim://?{EXACT}&delay=20e-6&seed=3"), 100)
    assert np.abs(wrong[:, 0] - right[:, 0]).max() <= 1  # the voltages' windows moved too
    assert np.abs(wrong[:, 0] - nominal[:, 0]).max() > 30


def test_a_phase_makes_the_current_an_instant_there() -> None:
    options = parse_url(f"sim://?{EXACT}&phase=0.3")
    raw, _ = bench_readings(options, 100)
    twin, chain = twin_readings(options, 100), draw_chain(options)
    at = np.arange(1, SAMPLES + 1) * 100 - 35  # 30 % of the last 50 µs
    counts = twin["i"][at] / chain.current.scale + chain.current.offset
    assert np.abs(raw[:, 0] - counts).max() <= 0.55


def test_the_encoder_counts_whole_lines_at_the_tick() -> None:
    options = parse_url(f"sim://?{EXACT}")
    _, counts = bench_readings(options, 100)
    twin, chain = twin_readings(options, 100), draw_chain(options)
    angle = twin["angle"][np.arange(1, SAMPLES + 1) * 100]
    first = np.floor(chain.encoder_angle / (2 * np.pi) * 2048)
    lines = np.floor((angle + chain.encoder_angle) / (2 * np.pi) * 2048) - first
    assert np.abs(counts - lines).max() <= 1
    assert (counts == lines).mean() > 0.9
    assert counts[-1] > 5


def test_gain_offset_and_noise_are_those_asked_for() -> None:
    url = "sim://?noise=2&gain_error=0.05&offset_error=30&clock_ppm=0&heating=0"
    bench = Bench(parse_url(url), draw_chain(parse_url(url)))
    still = bench.run(4000)[0][:, 0]
    assert still.mean() == pytest.approx(2048 + 30, abs=0.2)
    assert still.std() == pytest.approx(2.0, rel=0.05)
    bench.stall()
    bench.command(StepKind.DRIVE_DUTY, 1.0, Decay.SYNCHRONOUS_SLOW)
    bench.run(200)
    amps = 1.05 * bench.plant.current / bench.chain.current.scale
    assert bench.run(2000)[0][:, 0].mean() - 2078 == pytest.approx(amps, rel=2e-3)


def test_a_clock_error_stretches_everything_alike() -> None:
    fast, slow = (
        Bench(o, draw_chain(o))
        for o in (parse_url(f"sim://?{EXACT.replace('ppm=0', f'ppm={p}')}") for p in (2e4, -2e4))
    )
    for bench in (fast, slow):
        bench.command(StepKind.DRIVE_DUTY, 0.5, Decay.SYNCHRONOUS_SLOW)
        bench.run(1000)
    assert fast.period_s / slow.period_s == pytest.approx(0.98 / 1.02)
    assert fast.count < slow.count


def test_a_bent_current_sensor_is_off_at_full_scale_and_straight_at_zero() -> None:
    options = [parse_url(f"sim://?{EXACT}&heating=0{more}") for more in ("", "&current_cubic=0.05")]
    straight, bent = (bench_readings(one, 100)[0][:, 0].astype(float) for one in options)
    chain = draw_chain(options[0])
    share = (straight - chain.current.offset) / 2**14
    assert share.max() > 0.2
    assert np.abs(bent - straight - 0.05 * share**3 * 2**14).max() <= 1.0
    assert np.abs(bent - straight).max() > 4.0


def test_an_eccentric_encoder_errs_once_a_turn() -> None:
    rows = []
    for more in ("", "&eccentricity=0.02"):
        options = parse_url(f"sim://?{EXACT}&counts_per_turn=100000{more}")
        bench = Bench(options, draw_chain(options))
        bench.set_period(1600)
        bench.command(StepKind.DRIVE_DUTY, 0.4, Decay.SYNCHRONOUS_SLOW)
        rows.append(bench.run(1500)[1] * 2 * np.pi / 1e5)
    angle, shown = rows
    assert angle[-1] > 4 * np.pi
    first = draw_chain(parse_url(f"sim://?{EXACT}")).encoder_angle
    error = 0.02 * (np.sin(angle + first) - np.sin(first))
    assert np.abs(shown - angle - error).max() < 3e-4


def test_a_drifting_reference_moves_every_gain_alike_and_anew_in_each_run() -> None:
    options = parse_url(f"sim://?{EXACT}&reference_drift=0.02&reference_time=0.05")
    bench = Bench(options, draw_chain(options))
    bench.set_period(1600)
    whole = bench.plant.bus / bench.chain.supply.scale
    for run in (1, 2):
        bench.seed_run(run)
        supply = bench.run(5000)[0][:, 2]
        at = 100e-6 * np.arange(1, 5001)
        drift = 1 / (1 - 0.02 * -np.expm1(-at / 0.05))
        assert np.abs(supply - whole * drift).max() <= 0.6
