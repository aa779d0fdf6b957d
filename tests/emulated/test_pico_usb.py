"""A Pico's own USB: a host finds a serial port there, which carries more than the UART."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from motorid.wire.enums import Mode, ResetCause, Status
from tests.conformance.boards import opened, pico_lacks
from tests.conformance.client import Client

pytestmark = pytest.mark.slow
MOTOR = "dunkermotoren-gr42"
FOUND_S = 0.1
DEVICE, CONFIGURATION, INTERFACE, ENDPOINT, OF_CLASS = 1, 2, 4, 5, 0x24
COMMUNICATION, DATA = 2, 10
UART_BYTES_S = 100e3  # 1 Mbaud
WATCH_TICKS = 18_750  # of a fast burst: three PWM periods
STREAM_BYTES_S = 132e3  # 20 kHz of three channels


@pytest.fixture(autouse=True)
def _needs_an_emulator() -> None:
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")


@pytest.fixture
def board() -> Iterator[Any]:
    """One that hangs on a computer's USB."""
    with opened("pico-usb", motor=MOTOR) as board:
        yield board


def parts(descriptor: list[int]) -> list[list[int]]:
    """The descriptors in one, which each begin with their length."""
    found, at = [], 0
    while at < len(descriptor):
        found.append(descriptor[at : at + descriptor[at]])
        at += descriptor[at]
    assert at == len(descriptor)
    return found


def test_the_host_finds_a_serial_port(board: Any) -> None:
    board.port.board.advance_to(FOUND_S)
    told = board.port.board.usb()
    device, configuration = told["device"], told["configuration"]
    assert (device[0], device[1], device[17]) == (18, DEVICE, 1)
    assert device[2:4] == [0x00, 0x02]
    assert len(configuration) == configuration[2] + 256 * configuration[3]
    head, *rest = parts(configuration)
    assert head[1] == CONFIGURATION
    interfaces = [part for part in rest if part[1] == INTERFACE]
    assert head[4] == len(interfaces) == 2
    assert [one[5] for one in interfaces] == [COMMUNICATION, DATA]
    ends = [part for part in rest if part[1] == ENDPOINT]
    assert [one[4] for one in interfaces] == [1, 2]
    assert sorted(end[2] for end in ends) == [0x02, 0x81, 0x82]
    assert all(end[4] + 256 * end[5] == 64 for end in ends if end[3] == 2)  # full speed, bulk
    (union,) = [part for part in rest if part[1] == OF_CLASS and part[2] == 6]
    assert union[3:] == [0, 1]
    maker, name, number = told["texts"]
    assert (maker, name) == ("motorid", "motorid-pico")
    assert number == "E6614104032B1C27"  # of the flash chip: another on each board


def test_it_carries_more_than_a_stream_of_20_khz_needs(
    board: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fast burst, which is sent when it is over."""
    client = Client(board.port)
    client.bring_up()
    step = client.drive(1, 0.2) | {"ticks": 300 * WATCH_TICKS}
    emulator = board.port.board
    lengths: list[int] = []
    take = emulator.take

    def counting(size: int) -> bytes:
        data: bytes = take(size)
        lengths.append(len(data))
        return data

    monkeypatch.setattr(emulator, "take", counting)
    period = client.identity["burst_sample_period_ticks"]
    record = client.start(step, mode=Mode.BURST, sample_period_ticks=period)
    client.wait(300 * 150e-6)
    lengths.clear()
    began = board.port.now()
    client.follow(record)
    rate = sum(lengths) / (board.port.now() - began)
    assert len(record.channel(0)) == 300 * 25
    assert not record.all("fault")
    assert rate > STREAM_BYTES_S > UART_BYTES_S


def test_a_command_right_behind_another_is_answered_at_any_moment_of_a_stream(board: Any) -> None:
    """Also where the reply to the first still waits for the host to take the packet before it."""
    client = Client(board.port)
    client.bring_up()
    client.settings["sample_period_ticks"] = client.identity["min_sample_period_ticks"]
    record = client.start(client.coast(4000))
    for number in range(30):
        client.wait(0.0021 + 17e-6 * number)
        for request in [client.send("heartbeat", sequence=number) for _ in range(2)]:
            assert client.await_reply(request).status is Status.OK, number
    client.get("stop")
    client.follow(record)


def test_a_board_that_restarts_is_found_again(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    first = client.identity["boot_id"]
    for cause in (ResetCause.POWER_ON, ResetCause.WATCHDOG):
        board.reset(cause)
        client.wait(FOUND_S)
        client.bring_up()
        assert client.identity["reset_cause"] is cause
        assert client.identity["boot_id"] != first


def test_a_run_is_the_same_over_either_link() -> None:
    """The motor does not know it."""
    seen = []
    for name in ("pico", "pico-usb"):
        with opened(name, motor=MOTOR, noise=0) as board:
            client = Client(board.port)
            client.bring_up()
            client.settings["sample_period_ticks"] = WATCH_TICKS  # which the UART carries, too
            client.wait(0.2 - board.port.now())
            record = client.run(client.drive(200, 0.5), client.coast(50))
            seen.append([list(record.channel(channel)) for channel in range(4)])
    for one, other in zip(*seen, strict=True):
        assert len(one) == len(other)
        assert max(abs(int(a) - int(b)) for a, b in zip(one, other, strict=True)) <= 2
