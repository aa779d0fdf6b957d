"""Every fault shows where it should, on the wire."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.errors import LinkError
from motorid.sim.faults import KINDS, parse_faults
from motorid.wire.enums import Channel, Fault, ResetCause, State, Status
from tests.sim.client import CONFIG, Client, Record, coast, duty


def run_with(fault: str, *steps: dict[str, int], options: str = "seed=3") -> Record:
    return Client(options, fault=fault).run(*(steps or (duty(0.5, 600),)))


def column(record: Record, channel: Channel) -> np.ndarray:
    return record.samples[:, channel].astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["flip:0.004", "drop:0.004", "insert:0.004", "double:0.004"])
def test_spoiled_bytes_make_bad_frames_and_lost_blocks(fault: str) -> None:
    client = Client("seed=3", fault=fault + "@0.0")
    hashes = client.prepare(duty(0.5, 2000))
    client.send("start", config_hash=hashes[0], program_hash=hashes[1])
    for _ in range(400):
        client.listen(0.01)
        client.send("heartbeat", sequence=0)
    blocks = [m for m in client.said if m.name == "sample_block"]
    assert client.bad > 5
    assert 5 < len(blocks) < 72


def test_silence_is_silence_both_ways() -> None:
    client = Client(fault="silence@0.02")
    with pytest.raises(TimeoutError):
        client.run(duty(0.5, 9000))
    assert client.port.read(100, 1.0) == b""
    device = client.port._device
    assert device.board.state == State.FAULTED
    assert device.board.fault == Fault.HOST_SILENCE


def test_silence_from_the_beginning_has_no_greeting() -> None:
    assert Client(fault="silence").port.read(100, 1.0) == b""


def test_a_deaf_board_talks_on_until_the_host_seems_silent() -> None:
    record = run_with("deaf@0.01", duty(0.5, 9000))
    assert record.event("fault").fields["fault"] == Fault.HOST_SILENCE


def test_unplugged_is_a_link_error() -> None:
    client = Client(fault="unplug@0.02")
    with pytest.raises(LinkError, match="unplugged"):
        client.run(duty(0.5, 1000))
    with pytest.raises(LinkError):
        client.port.write(b"x")
    gone = Client(fault="unplug")
    with pytest.raises(LinkError):
        gone.identify()


def test_bursts_arrive_in_lumps_and_whole() -> None:
    client = Client(fault="burst:0.05@0.0")
    record = client.run(duty(0.3, 2000))
    assert len(record.samples) == 2000


def test_reads_may_be_split() -> None:
    client = Client(fault="split")
    assert max(len(client.port.read(100, 0.1)) for _ in range(3)) < 8
    assert client.identify().status == Status.OK


@pytest.mark.parametrize(("fault", "says"), [("text", b"ok T:"), ("garbage", b"")])
def test_another_device_answers_nothing_sensible(fault: str, says: bytes) -> None:
    client = Client(fault=fault)
    client.port.write(b"\0" * 10)
    heard = b"".join(client.port.read(1000, 0.2) for _ in range(5))
    assert says in heard
    assert len(heard) > 100
    with pytest.raises(TimeoutError):
        Client(fault=fault).identify()


def test_another_major_says_so_and_refuses() -> None:
    client = Client(fault="major:2")
    assert client.identify().fields["protocol_major"] == 2
    assert client.ask("configure", **CONFIG).status == Status.MAJOR_MISMATCH


def test_a_reset_forgets_everything_and_says_hello() -> None:
    client = Client(fault="reset@0.02")
    before = client.identify().fields["boot_id"]
    with pytest.raises(TimeoutError):
        client.run(duty(0.5, 1000))
    after = client.identify().fields
    assert after["boot_id"] != before
    assert (after["reset_cause"], after["state"]) == (ResetCause.EXTERNAL, State.IDLE)
    assert client.port._device.board.bench.is_open


def test_a_brownout_resets_and_the_supply_comes_back() -> None:
    client = Client(fault="brownout:0.05@0.02")
    with pytest.raises(TimeoutError):
        client.run(duty(0.5, 1000))
    assert client.identify().fields["reset_cause"] == ResetCause.BROWN_OUT
    client.listen(0.5)
    assert client.ask("read_status").fields["supply_voltage_raw"] > 3000


def test_a_missing_supply_trips() -> None:
    record = run_with("supply:0@0.02")
    assert record.event("fault").fields["fault"] == Fault.SUPPLY_LOW
    assert len(record.samples) == pytest.approx(200, abs=20)


def test_a_jammed_rotor_draws_stall_current_and_does_not_turn() -> None:
    record = run_with("stall")
    assert np.ptp(column(record, Channel.POSITION)) == 0
    current = (column(record, Channel.CURRENT)[-100:].mean() - 2048) * 0.00169
    assert current == pytest.approx(0.5 * 7 / (2.6 + 0.1 + 0.02), rel=0.03)


def test_encoder_faults() -> None:
    sound = column(run_with(""), Channel.POSITION)
    reverse = column(run_with("encoder_reversed"), Channel.POSITION)
    dead = column(run_with("encoder_dead"), Channel.POSITION)
    lossy = column(run_with("encoder_drop:0.1"), Channel.POSITION)
    assert np.array_equal(reverse - reverse[0], -(sound - sound[0]))
    assert np.ptp(dead) == 0
    assert (lossy[-1] - lossy[0]) / (sound[-1] - sound[0]) == pytest.approx(0.9, abs=0.01)


def test_current_sensor_faults() -> None:
    sound = column(run_with(""), Channel.CURRENT) - 2048
    dead = column(run_with("current_dead"), Channel.CURRENT) - 2048
    reverse = column(run_with("current_reversed"), Channel.CURRENT) - 2048
    full = run_with("current_saturated")
    assert sound.max() > 500
    assert np.abs(dead).max() < 15
    assert reverse.min() < -500
    assert full.event("fault").fields["fault"] == Fault.OVER_CURRENT
    assert (column(full, Channel.CURRENT) == 4095).all()


def test_voltage_and_converter_faults() -> None:
    dead = column(run_with("voltage_dead"), Channel.TERMINAL_VOLTAGE) - 2048
    assert np.abs(dead).max() < 15
    stuck = run_with("adc_stuck@0.02", duty(0.5, 400), coast(200)).samples[300:, :3]
    assert np.ptp(stuck, axis=0).tolist() == [0, 0, 0]


def test_every_kind_of_fault_parses_and_is_applied_by_something() -> None:
    for name in KINDS:
        assert parse_faults(f"{name}@1.5")[0].at_s == 1.5
        Client(fault=name)
