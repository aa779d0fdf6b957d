"""The Pico's firmware on an emulated RP2040: pins, times, crashes and a motor."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.capture import store
from motorid.sim.motor import find_motor
from motorid.wire.enums import Channel, Fault, Mode, ResetCause, State
from motorid.workflow.record import bench, bursting, capture_runs
from tests.conformance.boards import ROOT, opened, pico_lacks
from tests.conformance.client import Client
from tests.emulated.pico_stream import CHECKS, INTERRUPT_S, THREE, VOLTS
from tests.emulated.pico_stream import EDGES_HZ as EDGES_HZ_MORE

pytestmark = pytest.mark.slow
MOTOR = "dunkermotoren-gr42"
OPENS_WITHIN_S = 20e-6  # from the end of the window that showed the limit passed
WATCH_TICKS = 18_750  # of a fast burst: three PWM periods
WATCHDOG_S = 0.2
EDGES_HZ = 1e6
SPEED_LIMIT = 2000  # counts/s of the motor
PERIOD_S = 50e-6
READS_WITHIN_V = 0.05
CYCLE_S = 8e-9
INSTRUCTIONS = 20  # in which the start code opens the bridge


@pytest.fixture(autouse=True)
def _needs_an_emulator() -> None:
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")


@pytest.fixture
def client() -> Iterator[Client]:
    """Of a board with that motor, idle."""
    with opened("pico", motor=MOTOR) as board:
        client = Client(board.port)
        client.bring_up()
        yield client


@pytest.fixture
def fastest() -> Iterator[Client]:
    """Of a board at USB, at its highest rate."""
    with opened("pico-usb", motor=MOTOR) as board:
        client = Client(board.port)
        client.bring_up()
        client.settings["sample_period_ticks"] = client.identity["min_sample_period_ticks"]
        yield client


def emulator(client: Client) -> Any:
    """Behind it."""
    port: Any = client.port
    return port.board


def counted(client: Client) -> int:
    """The board's position, which begins at 0."""
    return (int(client.get("read_status")["position"]) + (1 << 31)) % (1 << 32) - (1 << 31)


def begin(client: Client) -> None:
    """A program that drives for a second, followed until it does."""
    client.start(client.drive(6666, 0.5))
    client.wait(0.05)
    assert emulator(client).facts()["enabled"]


def greet_again(client: Client) -> dict[str, Any]:
    """What the board says of its start."""
    client.wait(0.05)
    client.port.write(b"\0")
    return client.get("identify", host_major=1, host_minor=3)


def test_no_edge_is_lost_at_a_million_a_second(client: Client) -> None:
    board = emulator(client)
    before = board.facts()["count"]
    board.set("extra_edges", EDGES_HZ)
    client.wait(0.05)
    board.set("extra_edges", 0.0)
    client.wait(0.01)
    assert board.facts()["count"] - before >= 0.04 * EDGES_HZ
    assert counted(client) == board.facts()["count"] - before


def test_the_count_goes_down_below_zero(client: Client) -> None:
    board = emulator(client)
    before = board.facts()["count"]
    board.set("extra_edges", -EDGES_HZ)
    client.wait(0.01)
    board.set("extra_edges", 0.0)
    client.wait(0.01)
    assert counted(client) == board.facts()["count"] - before < 0


@pytest.mark.parametrize("current_ma", [500, 900, 1200])
def test_an_over_current_opens_the_bridge_within_20_us(client: Client, current_ma: int) -> None:
    emulator(client).times()
    record = client.run(client.drive(2000, 0.6), current_limit_ma=current_ma)
    times = emulator(client).times()
    assert Fault(record.one("fault")["fault"]) is Fault.OVER_CURRENT
    assert times["openings"] == 1
    assert 0 < times["opened"] <= OPENS_WITHIN_S


def test_an_over_speed_opens_the_bridge_within_20_us(client: Client) -> None:
    emulator(client).times()
    record = client.run(client.drive(4000, 0.6), speed_limit_counts_s=SPEED_LIMIT)
    times = emulator(client).times()
    assert Fault(record.one("fault")["fault"]) is Fault.OVER_SPEED
    assert times["openings"] == 1
    assert 0 < times["opened"] <= OPENS_WITHIN_S


@pytest.mark.parametrize(
    ("limit", "fault"),
    [
        ({"current_limit_ma": 500}, Fault.OVER_CURRENT),
        ({"speed_limit_counts_s": int(EDGES_HZ_MORE) + SPEED_LIMIT}, Fault.OVER_SPEED),
    ],
)
def test_at_its_highest_rate_with_all_loads_a_trip_is_no_later(
    fastest: Client, limit: dict[str, int], fault: Fault
) -> None:
    """20 kHz over USB, volts held, every check, 200,000 edges a second beside the motor's."""
    board = emulator(fastest)
    board.set("inputs", 3)
    board.set("extra_edges", EDGES_HZ_MORE)
    board.times()
    record = fastest.run(fastest.hold(8000, VOLTS), channels=THREE, **CHECKS, **limit)
    times = board.times()
    assert Fault(record.one("fault")["fault"]) is fault
    assert times["openings"] == 1
    assert 0 < times["opened"] <= OPENS_WITHIN_S


@pytest.mark.parametrize(
    ("supply_v", "fault"), [(14.0, Fault.SUPPLY_LOW), (34.0, Fault.SUPPLY_HIGH)]
)
def test_a_supply_beyond_its_limits_opens_the_bridge_within_20_us(
    client: Client, supply_v: float, fault: Fault
) -> None:
    record = client.start(
        client.drive(2000, 0.5), supply_min_mv=18_000, supply_max_mv=30_000, host_silence_ms=5000
    )
    client.wait(0.02)
    board = emulator(client)
    board.times()
    board.set("supply", supply_v)
    client.follow(record)
    times = board.times()
    assert Fault(record.one("fault")["fault"]) is fault
    assert times["openings"] == 1
    assert 0 < times["opened"] <= OPENS_WITHIN_S


@pytest.mark.parametrize(("link", "volts"), [("pico", -2.0), ("pico-usb", 2.0)])
def test_two_volts_of_a_large_supply_read_as_what_the_motor_gets(link: str, volts: float) -> None:
    """A sampling that is locked to the PWM reads a small duty as half as much again."""
    exact = {"voltage_gain_error": 0, "offset_error": 0, "heating": 0, "ambient": 25}
    with opened(link, motor=MOTOR, **exact) as board:
        client = Client(board.port)
        client.bring_up()
        client.settings["sample_period_ticks"] = client.identity["min_sample_period_ticks"]
        client.configure()
        zero = client.get("zero", samples=500)["voltage_offset"]  # as every capture begins
        emulator(client).set("locked", 1.0)
        record = client.start(client.drive(600, volts / emulator(client).facts()["bus"]))
        client.wait(client.seconds(500))
        amperes = []
        for _ in range(20):  # all over a PWM period, for the current ripples
            client.wait(PERIOD_S / 20)
            amperes.append(emulator(client).facts()["current"])
        client.follow(record)
    truth = find_motor(MOTOR)[1].resistance_ohm * sum(amperes) / len(amperes)
    raw = record.channel(Channel.TERMINAL_VOLTAGE)[400:600]
    fact = client.descriptors[Channel.TERMINAL_VOLTAGE]
    shown = fact["scale"] * (float(raw.mean()) - zero)
    assert 0.9 * abs(volts) < abs(truth) < abs(volts)  # dead time and switches take the rest
    assert abs(shown - truth) <= READS_WITHIN_V
    # and each reading by itself, wherever it begins in the order of the inputs
    assert abs(raw - raw.mean()).max() <= 5 * fact["noise"]


def test_a_sample_takes_half_its_period_at_most(fastest: Client) -> None:
    """With volts held, every check of minor 3, a fast encoder and heartbeats."""
    client, board = fastest, emulator(fastest)
    board.set("inputs", 3)
    board.set("extra_edges", 0.2 * EDGES_HZ)
    board.times()
    record = client.run(client.hold(5000, 6.0), client.coast(10), **CHECKS)
    assert not record.all("fault")
    assert len(record.samples) == record.one("done")["samples"] == 5010
    assert 0 < board.times()["sample"] <= INTERRUPT_S


def test_at_its_highest_rate_the_reading_that_trips_is_the_last_sample(fastest: Client) -> None:
    """There is none between samples; tests/conformance/test_trips.py tries slower ones."""
    limit = fastest.identity["max_current_ma"] // 25
    record = fastest.run(fastest.drive(2000), current_limit_ma=limit)
    raw = record.channel(Channel.CURRENT)
    assert record.one("fault")["value"] == raw[-1]
    over = [abs(fastest.value(Channel.CURRENT, sample)) * 1000 > limit for sample in raw]
    assert over == [False] * (len(raw) - 1) + [True]


def test_a_hang_ends_with_an_open_bridge_and_says_so(client: Client) -> None:
    begin(client)
    first = client.identity["boot_id"]
    emulator(client).set("hang", 1)
    client.wait(1.2 * WATCHDOG_S)
    assert not emulator(client).facts()["enabled"]
    identity = greet_again(client)
    assert identity["reset_cause"] is ResetCause.WATCHDOG
    assert identity["state"] is State.FAULTED
    assert identity["boot_id"] != first
    assert Fault(client.get("read_status")["fault"]) is Fault.WATCHDOG


def test_a_main_loop_that_hangs_does_so_too(client: Client) -> None:
    begin(client)
    emulator(client).set("stall", 1)
    client.wait(1.2 * WATCHDOG_S)
    assert not emulator(client).facts()["enabled"]
    assert greet_again(client)["reset_cause"] is ResetCause.WATCHDOG


def test_a_hard_fault_opens_the_bridge_at_once(client: Client) -> None:
    begin(client)
    emulator(client).set("fault", 1)
    client.wait(20e-6)
    assert not emulator(client).facts()["enabled"]
    assert greet_again(client)["reset_cause"] is ResetCause.WATCHDOG


@pytest.mark.parametrize("left", [0, 16, 28])
def test_a_stack_that_reaches_its_bottom_opens_the_bridge_within_two_windows(
    client: Client, left: int
) -> None:
    begin(client)
    emulator(client).set("deep", left)
    client.wait(300e-6)
    assert not emulator(client).facts()["enabled"]
    assert greet_again(client)["reset_cause"] is ResetCause.WATCHDOG


def test_a_stack_that_stays_above_is_no_fault(client: Client) -> None:
    begin(client)
    emulator(client).set("deep", 32)
    client.wait(0.01)
    assert emulator(client).facts()["enabled"]
    assert emulator(client).facts()["resets"] == 0


def test_a_start_without_a_reset_becomes_a_reset(client: Client) -> None:
    begin(client)
    emulator(client).set("wander", 1)
    client.wait(100e-6)
    assert not emulator(client).facts()["enabled"]
    assert emulator(client).facts()["resets"] == 1
    assert greet_again(client)["reset_cause"] is ResetCause.WATCHDOG


def test_the_start_code_opens_the_bridge_before_the_reset(client: Client) -> None:
    """It does so by itself, in its first instructions: memory is not yet what main would find."""
    begin(client)
    board = emulator(client)
    board.set("wander", 1)
    for _ in range(INSTRUCTIONS):
        board.advance_to(board.now + CYCLE_S)
        if not board.facts()["enabled"]:
            break
    assert not board.facts()["enabled"]
    assert board.facts()["resets"] == 0
    client.wait(100e-6)
    assert board.facts()["resets"] == 1


def test_a_driver_that_reports_a_fault_is_opened(client: Client) -> None:
    begin(client)
    emulator(client).set("complain", 1)
    client.wait(0.001)
    assert not emulator(client).facts()["enabled"]
    assert Fault(client.get("read_status")["fault"]) is Fault.DRIVER


def test_two_equal_runs_are_equal_to_the_byte() -> None:
    """In processes of their own, and in one that has served another test."""
    said = []
    with opened("pico", motor=MOTOR, seed=3) as one, opened("pico", motor=MOTOR, seed=3) as other:
        boards: list[Any] = [one, other, one]
        for number, board in enumerate(boards):
            if number == 2:
                board.spoil()
                board.port.board.set("supply", 5.0)
                board.port.board.renew()
            client = Client(board.port)
            client.bring_up()
            client.run(client.drive(200, 0.5), client.coast(100))
            said.append(client.payloads)
    assert said[0] == said[1] == said[2]


def test_the_rig_for_bursts_captures_one(tmp_path: Path) -> None:
    rig = bursting(bench(str(ROOT / "rigs" / "emulated-pico-burst.toml")))
    (path,) = capture_runs(rig, tmp_path / "burst.h5")
    capture = store.load(path)
    assert capture.end_reason == "completed"
    assert capture.period_s == pytest.approx(6e-6)
    assert len(capture) == 1000
    # three milliseconds at full duty, of a motor that settles within 0.07: nearly the stall current
    motor = find_motor("faulhaber-2338s006s")[1]
    stall = motor.supply_v / motor.resistance_ohm
    assert 0.8 * stall < capture.channels["current"].values.max() < stall


def test_a_window_of_a_burst_takes_half_a_period_at_most(client: Client) -> None:
    period = client.identity["burst_sample_period_ticks"]
    step = client.drive(1, 0.5) | {"ticks": 20 * WATCH_TICKS}
    emulator(client).times()
    client.run(step, mode=Mode.BURST, sample_period_ticks=period)
    assert 0 < emulator(client).times()["sample"] <= INTERRUPT_S
