"""The filters before the converters against closed forms and a plant in small steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib

from motorid.sim import identity, truth
from motorid.sim.bench import Bench, Guard
from motorid.sim.board import Board
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url
from motorid.wire.enums import Decay, Fault, Mode, StepKind

EXACT = "noise=0&gain_error=0&voltage_gain_error=0&offset_error=0&clock_ppm=0&bits=15"
MICRO = 1e-6


def lowpass(*taus: float, value: float = 0.0) -> Any:
    f = ffi.new("lowpass *")
    lib.lowpass_init(f, *taus, value)
    return f


def follow(f: Any, step: float, poly: np.polynomial.Polynomial, end: float) -> None:
    """Let it see a polynomial of time from 0 on, in steps."""
    area = poly.integ()
    for n in range(round(end / step)):
        a, b = n * step, (n + 1) * step
        lib.lowpass_follow(f, step, poly(a), poly(b), area(b) - area(a))


@pytest.mark.parametrize("step", [1e-3, 0.02, 0.999, 1.001, 10.0, 1e4])
def test_a_pole_follows_a_parabola_exactly_in_steps_of_any_length(step: float) -> None:
    """The answer to c2 t²: c2 (t² - 2 tau t + 2 tau² (1 - exp(-t/tau))), and so on."""
    tau, c0, c1, c2 = 1.0, 2.0, -3.0, 0.7
    f = lowpass(tau, 0.0, value=1.5)
    end = max(3.0, step) // step * step
    follow(f, step, np.polynomial.Polynomial([c0, c1, c2]), end)
    late = -np.expm1(-end / tau)
    expected = 1.5 * (1 - late) + c0 * late + c1 * (end - tau * late)
    expected += c2 * (end**2 - 2 * tau * end + 2 * tau**2 * late)
    assert f.out[0] == pytest.approx(expected, rel=1e-12)


def test_a_step_through_two_poles() -> None:
    first, second, end = 3.0, 1.0, 4.0
    f = lowpass(first, second)
    follow(f, 0.5, np.polynomial.Polynomial([1.0]), end)
    fast, slow = np.exp(-end / second), np.exp(-end / first)
    expected = 1 - (first * slow - second * fast) / (first - second)
    assert lib.lowpass_value(f, 1.0) == pytest.approx(expected, abs=1e-4)
    area = end - first - second + (first**2 * slow - second**2 * fast) / (first - second)
    assert end - lib.lowpass_behind(f) == pytest.approx(area, abs=1e-4)


def test_without_a_pole_the_value_itself_shows() -> None:
    f = lowpass(0.0, 0.0, value=5.0)
    follow(f, 1.0, np.polynomial.Polynomial([1.0, 1.0]), 3.0)
    assert lib.lowpass_value(f, 4.0) == 4.0
    assert lib.lowpass_behind(f) == 0.0


def readings(query: str, samples: int = 60) -> tuple[np.ndarray, Bench]:
    """Of a bench whose bridge switches, a sample each 100 µs."""
    options = parse_url(f"sim://?{EXACT}&{query}")
    bench = Bench(options, draw_chain(options))
    bench.set_period(1600)
    bench.command(StepKind.DRIVE_DUTY, 0.6, Decay.SYNCHRONOUS_SLOW)
    return bench.run(samples)[0].astype(float), bench


def in_small_steps(taus: tuple[float, ...], samples: int = 60) -> np.ndarray:
    """The current behind filters, integrated a tenth of a microsecond at a time; (n, 3): the mean
    over 50 µs that ends 5 µs before each tick, an instant at the tick, and the current there.
    """
    options = parse_url(f"sim://?{EXACT}")
    _, bench = readings("", 0)
    plant, h, fine = bench.plant, 0.1 * MICRO, [0.0]
    for n in range(samples * 1000):
        lib.plant_advance(ffi.addressof(bench._c, "plant"), h)
        if (n + 1) % 1000 == 0:
            lib.plant_new_period(ffi.addressof(bench._c, "plant"))
        fine.append(plant.current)
    seen = current = np.array(fine)
    for tau in taus:
        out, keep = [seen[0]], np.exp(-h / tau)
        middle = 0.5 * (seen[1:] + seen[:-1])
        for x in middle:
            out.append(x + (out[-1] - x) * keep)
        seen = np.array(out)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (seen[1:] + seen[:-1]))]) * h
    at = np.arange(1, samples + 1) * 1000
    mean = (area[at - 50] - area[at - 550]) / (50 * MICRO)
    scale = draw_chain(options).current
    return np.column_stack([mean, seen[at], current[at]]) / scale.scale + scale.offset


@pytest.mark.slow
@pytest.mark.parametrize(
    ("query", "taus"),
    [
        ("current_filter=15e-6", (15e-6,)),
        ("current_filter=100e-6&filter_error=0.2", (120e-6,)),
        ("hidden_filter=1e-6", (1e-6,)),
        ("current_filter=30e-6&hidden_filter=20e-6", (30e-6, 20e-6)),
    ],
)
def test_the_current_is_read_through_its_filters(query: str, taus: tuple[float, ...]) -> None:
    fine = in_small_steps(taus)
    mean, _ = readings(query)
    instant, _ = readings(f"{query}&aperture=0&delay=0")
    plain, bench = readings("")
    assert np.abs(mean[:, 0] - fine[:, 0]).max() <= 1.1
    assert np.abs(instant[:, 0] - fine[:, 1]).max() <= 1.1
    assert np.abs(plain[:, 0] - mean[:, 0]).max() > 20
    assert bench.plant.current == readings(query)[1].plant.current  # nothing acts back
    assert (plain[:, 1:] == mean[:, 1:]).all()


def test_the_board_declares_what_it_knows_of_its_filters() -> None:
    """The delay counts the filter, in a fast burst too; the board knows of no hidden one."""
    query = "current_filter=30e-6&filter_error=0.2&hidden_filter=7e-6&voltage_filter=58e-6"
    url = f"sim://?{query}&delay=5e-6&aperture=50e-6&voltage_aperture=50e-6"
    board = Board(parse_url(url), lambda _: None)
    for mode, delay_ns in ((Mode.STREAM, 35_000), (Mode.BURST, 30_000)):
        current = identity.describe(board, 0, mode)
        assert (current["filter_ns"], current["delay_ns"]) == (30_000, delay_ns)
        for index in (1, 2):
            voltage = identity.describe(board, index, mode)
            assert (voltage["filter_ns"], voltage["delay_ns"]) == (58_000, 58_000)
    assert truth(url)["chain"]["current"]["filter_s"] == pytest.approx((36e-6, 7e-6))


def test_a_limit_is_compared_with_what_the_filter_shows() -> None:
    """The same stroke of current trips later behind a filter, and at a reading above the limit."""

    def taken(query: str) -> tuple[int, int]:
        options = parse_url(f"sim://?{EXACT}&{query}")
        bench = Bench(options, draw_chain(options))
        bench.set_period(1600)
        bench.arm(Guard(1.0, 1e9, -1.0, 1e3))
        bench.command(StepKind.DRIVE_DUTY, 1.0, Decay.SYNCHRONOUS_SLOW)
        bench.stall()
        return len(bench.run(200)[0]), bench.trip[0]

    plain, filtered = taken(""), taken("current_filter=1e-3")
    assert plain[1] == filtered[1] == Fault.OVER_CURRENT
    # of 2.7 A at the end, 1 A shows after 0.46 time constants
    assert 3 < filtered[0] - plain[0] < 6
