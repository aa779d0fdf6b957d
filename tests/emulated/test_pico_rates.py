"""The Pico's rates: a stream of 20 kHz, its readings' times, what it identifies, and a burst."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motorid
from motorid.sim.motor import find_motor
from motorid.wire.enums import Channel, Mode
from motorid.workflow.record import bench, bursting, capture_runs
from tests.conformance.boards import ROOT, opened, pico_lacks
from tests.conformance.client import Client
from tests.emulated.motors import NAMES, SURE, figures, fitted
from tests.emulated.pico_stream import INTERRUPT_S, stream

pytestmark = pytest.mark.slow
Floats = NDArray[np.float64]
MOTOR = "dunkermotoren-gr42"
FAST_MOTOR = "faulhaber-2338s006s"  # of 0.18 mH
COPPER = 9.0 / 2.6  # so much more resistance: L/R is 20 us
WATCH_TICKS = 18_750
ROUNDS = 25  # of each input in a reading
MEASURED = (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.SUPPLY_VOLTAGE)
AT_ONE_TIME_S = 0.3e-6
MOST_L = 0.02  # relative
MOST_DROP = 0.001  # of the motor's voltage: standard uncertainty of a brush drop
EXACT = {"noise": 0, "heating": 0, "ambient": 25, "clock_ppm": 0}
WEAK = {"supply_resistance": 2.0}  # so that the supply sags by many steps of its converter


@pytest.fixture(autouse=True)
def _needs_an_emulator() -> None:
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")


def test_a_stream_of_three_channels_at_20_khz_is_whole() -> None:
    found = stream(0.3)
    assert found.is_whole
    assert 0 < found.interrupt_s <= INTERRUPT_S
    assert found.edges_hz > 200_000


@dataclass(frozen=True)
class Stepped:
    """A locked motor switched on and off."""

    facts: list[dict[str, Any]]  # descriptors by channel
    times: Floats  # after the step, s
    raw: Floats  # (channels, n)


def stepped(link: str, mode: Mode) -> Stepped:
    """The same program in any mode over either link."""
    with opened(link, motor=MOTOR, **EXACT, **WEAK) as board:
        client = Client(board.port)
        client.bring_up()
        board.port.board.set("locked", 1.0)
        board.port.board.set("reference_noise", 0.0)  # no two runs have the same
        kind = "burst_sample_period_ticks" if mode == Mode.BURST else "min_sample_period_ticks"
        client.settings["sample_period_ticks"] = client.identity[kind]
        steps = (client.coast(1), client.drive(1, 1.0), client.coast(1))
        lasting = [s | {"ticks": WATCH_TICKS * n} for s, n in zip(steps, (4, 12, 12), strict=True)]
        record = client.run(*lasting, mode=mode)
        onset = record.all("phase")[1]["tick"] - record.start_tick
        raw = np.stack([record.channel(channel) for channel in MEASURED]).astype(float)
        times = np.arange(raw.shape[1]) * client.period - onset
        facts = [client.get("describe_channel", index=n, mode=mode) for n in MEASURED]
        return Stepped(facts, times / client.identity["clock_hz"], raw)


@pytest.mark.parametrize("link", ["pico", "pico-usb"])
def test_a_reading_is_the_mean_at_the_time_that_its_descriptor_says(link: str) -> None:
    """Against the conversions themselves, which a burst of the same step shows."""
    burst, stream = stepped("pico", Mode.BURST), stepped(link, Mode.STREAM)
    for channel in MEASURED:
        fact = stream.facts[channel]
        # both through the same filter
        instants = burst.times - burst.facts[channel]["delay_ns"] * 1e-9
        ends = stream.times - fact["delay_ns"] * 1e-9
        places = ends[:, None] - fact["aperture_ns"] * 1e-9 * (np.arange(ROUNDS) + 0.5) / ROUNDS
        known = (places.min(axis=1) > instants[0]) & (places.max(axis=1) < instants[-1])
        said = np.interp(places[known], instants, burst.raw[channel]).mean(axis=1)
        slope = np.gradient(said, stream.times[known])
        late = float(slope @ (said - stream.raw[channel][known]) / (slope @ slope))
        assert abs(late) < AT_ONE_TIME_S, channel.name


@pytest.mark.study
def test_a_motor_is_identified_at_20_khz(tmp_path: Path) -> None:
    """One of 0.18 mH and without brushes' drop.

    Through the other boards' firmware tests/emulated/test_motors.py identifies one in every run;
    the tests above have the Pico's stream whole and its readings at their times.
    """
    estimate = fitted(tmp_path, "pico", FAST_MOTOR, more="&link=usb", rate_hz=20_000)
    found = figures(FAST_MOTOR, estimate)
    for name in NAMES:  # 3 standard uncertainties, for six figures of one seed
        assert abs(found[name].value - found[name].truth) <= 1.5 * found[name].half, name
    assert abs(found["L"].error) <= MOST_L
    # the steps of the converter look like a drop as well: they are in its uncertainty
    drop = estimate.nuisance["brush drop"]
    assert drop.interval_95[0] <= 0.0 <= drop.interval_95[1]
    assert drop.instrument > drop.statistical
    assert drop.total < MOST_DROP * find_motor(FAST_MOTOR)[1].voltage_v


def test_a_burst_identifies_a_motor_of_20_us(tmp_path: Path) -> None:
    """One of 6 ms, alone."""
    port = f"&copper={COPPER}&heating=0&ambient=25&counts_per_turn"
    text = (ROOT / "rigs" / "emulated-pico-burst.toml").read_text(encoding="utf-8")
    text = text.replace("&counts_per_turn", port, 1).replace(
        "resistance_ohm = 2.6", "resistance_ohm = 9.0"
    )
    (tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    (path,) = capture_runs(bursting(bench(str(tmp_path / "rig.toml"))), tmp_path / "burst.h5")
    found = motorid.fit(path).parameters
    motor = find_motor(FAST_MOTOR)[1]
    resistance = COPPER * motor.resistance_ohm
    assert motor.inductance_h / resistance == pytest.approx(20e-6)
    for name, truth in (("R", resistance), ("L", motor.inductance_h)):
        assert abs(found[name].value / truth - 1) <= MOST_L, name
        assert abs(found[name].value - truth) <= 1.5 * SURE * found[name].total, name
