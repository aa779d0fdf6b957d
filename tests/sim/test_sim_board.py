"""The board's end of the wire: states, refusals, runs and trips."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from motorid.sim import truth
from motorid.wire.enums import Decay, EndReason, Fault, State, Status
from motorid.wire.spec import load
from tests.sim.client import CONFIG, TICKS, Client, brake, coast, duty, volts


@pytest.fixture
def client() -> Client:
    return Client(seed=3)


def state(client: Client) -> State:
    return client.ask("read_status").fields["state"]


def test_it_greets_and_identifies(client: Client) -> None:
    fields = client.identify().fields
    assert client.said[0].name == "hello"
    assert fields["boot_id"] == client.said[0].fields["boot_id"]
    assert (fields["protocol_major"], fields["state"]) == (1, State.IDLE)
    assert fields["channel_count"] == 4


def test_each_command_is_refused_where_its_state_forbids(client: Client) -> None:
    assert client.ask("start", config_hash=0, program_hash=0).status == Status.NOT_CONFIGURED
    assert client.ask("read_config").status == Status.NOT_CONFIGURED
    assert client.ask("clear_fault").status == Status.BAD_STATE
    assert client.ask("configure", **CONFIG).status == Status.OK
    assert client.ask("start", config_hash=0, program_hash=0).status == Status.PROGRAM_EMPTY
    assert client.ask("add_step", index=0, **coast(10)).status == Status.OK
    assert client.ask("start", config_hash=0, program_hash=0).status == Status.HASH_MISMATCH
    assert state(client) == State.LOADED


NOTHING_NEW = {f.name: 0 for f in load().commands["configure"].fields if f.since}


def test_configuration_is_read_back(client: Client) -> None:
    reply = client.ask("configure", **CONFIG)
    assert client.ask("read_config").fields == NOTHING_NEW | CONFIG | reply.fields


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"sample_period_ticks": 801}, Status.BAD_VALUE),
        ({"sample_period_ticks": 0}, Status.BAD_VALUE),
        ({"channels": 0}, Status.BAD_VALUE),
        ({"channels": 0b10001}, Status.NOT_SUPPORTED),
        ({"mode": 7}, Status.NOT_SUPPORTED),
        ({"current_limit_ma": 0}, Status.BAD_VALUE),
        ({"current_limit_ma": 4000}, Status.BAD_VALUE),
        ({"supply_min_mv": 9000}, Status.BAD_VALUE),
        ({"host_silence_ms": 60_000}, Status.BAD_VALUE),
        ({"speed_limit_counts_s": 3_000_000}, Status.EDGE_CEILING),
    ],
)
def test_a_bad_configuration_changes_nothing(
    client: Client, change: dict[str, int], status: Status
) -> None:
    assert client.ask("configure", **CONFIG | change).status == status
    assert state(client) == State.IDLE


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"index": 1}, Status.BAD_VALUE),
        ({"kind": 9}, Status.NOT_SUPPORTED),
        ({"decay": 0}, Status.NOT_SUPPORTED),
        ({"decay": Decay.FAST}, Status.NOT_SUPPORTED),
        ({"level": 1_000_001}, Status.BAD_VALUE),
        ({"ticks": 0}, Status.BAD_VALUE),
        ({"ticks": TICKS + 1}, Status.BAD_VALUE),
    ],
)
def test_a_bad_step_is_not_loaded(change: dict[str, int], status: Status) -> None:
    client = Client("decay_modes=synchronous_slow")
    client.ask("configure", **CONFIG)
    step = {"index": 0, **duty(0.1, 10)} | change
    assert client.ask("add_step", **step).status == status
    assert state(client) == State.CONFIGURED


def test_a_program_has_only_so_many_steps() -> None:
    client = Client("max_steps=2")
    client.prepare(coast(1), coast(1))
    assert client.ask("add_step", index=2, **coast(1)).status == Status.PROGRAM_FULL


def test_a_repeated_request_is_answered_again_and_not_executed(client: Client) -> None:
    client.ask("configure", **CONFIG)
    first = client.send("add_step", index=0, **coast(10))
    client.send("add_step", request=first, index=0, **coast(10))
    while len(client.replies) < 2:
        client.listen()
    assert client.replies[0] == client.replies[1]
    assert client.replies[0].fields["steps"] == 1


def test_a_host_of_another_major_is_refused(client: Client) -> None:
    reply = client.ask("identify", host_major=9, host_minor=0)
    assert reply.fields["protocol_major"] == 1
    assert client.ask("read_status").status == Status.MAJOR_MISMATCH
    assert client.ask("stop").status == Status.OK
    client.identify()
    assert client.ask("read_status").status == Status.OK


def test_a_run_has_its_samples_and_phases_at_exact_ticks(client: Client) -> None:
    record = client.run(duty(0.5, 100), coast(70), brake(30))
    start = record.start_tick
    phases = [e.fields for e in record.events if e.name == "phase"]
    assert [p["tick"] - start for p in phases] == [0, 100 * TICKS, 170 * TICKS]
    ticks = [b.first_tick + n * TICKS - start for b in record.blocks for n in range(len(b.samples))]
    assert ticks == [n * TICKS for n in range(200)]
    done = record.event("done").fields
    assert done["reason"] == EndReason.COMPLETED
    assert (done["tick"] - start, done["samples"], done["dropped"]) == (200 * TICKS, 200, 0)
    assert done["blocks"] == len(record.blocks)
    assert state(client) == State.LOADED


def test_a_step_first_shows_in_the_sample_after_it(client: Client) -> None:
    voltage = client.run(duty(0.5, 50), coast(50)).samples[:, 1] - 2048.0
    assert abs(voltage[0]) < 10
    assert voltage[1] > 500
    assert voltage[50] == pytest.approx(voltage[49], abs=10)
    assert voltage[52] < voltage[50] - 20 or voltage[52] > voltage[50] + 20


def test_volts_hold_the_mean_bridge_voltage() -> None:
    client = Client("noise=0&gain_error=0&voltage_gain_error=0&offset_error=0&dead_time=0")
    scale = client.ask("describe_channel", index=1).fields["scale"]
    samples = client.run(volts(4.0, 3000)).samples
    current = (samples[-500:, 0] - 2048) * 0.00169
    assert (samples[-500:, 1] - 2048).mean() * scale == pytest.approx(
        4.0 - 0.1 * current.mean(), abs=2 * scale
    )


def test_position_follows_the_encoder_through_blocks(client: Client) -> None:
    record = client.run(duty(1.0, 3000), coast(200))
    low = record.samples[:, 3].astype(np.uint16).astype(np.int64)
    whole = np.cumsum(np.concatenate([low[:1], np.diff(low.astype(np.int16)).astype(np.int16)]))
    first = np.concatenate([[b.position] for b in record.blocks])
    at = np.cumsum([0] + [len(b.samples) for b in record.blocks[:-1]])
    assert np.array_equal(whole[at], first)
    assert whole[-1] > 65_536, "the low 16 bits must have wrapped"


def test_an_encoder_may_be_counted_the_other_way(client: Client) -> None:
    record = client.run(duty(0.5, 500), encoder_reversed=1)
    assert record.blocks[-1].position > 2**31


def test_zero_measures_the_drawn_offset() -> None:
    url = "sim://?seed=8&noise=1.5"
    client = Client("seed=8&noise=1.5")
    client.ask("configure", **CONFIG)
    fields = client.ask("zero", samples=4096).fields
    offset = 2048 + truth(url)["chain"]["current"]["offset_error"]
    assert fields["current_offset"] == pytest.approx(offset, abs=4 * 1.5 / 64)
    assert fields["current_noise"] == pytest.approx(1.5, rel=0.06)


def test_zero_refuses_a_turning_motor(client: Client) -> None:
    client.run(duty(1.0, 500))
    assert client.ask("zero", samples=500).status == Status.NOT_AT_REST
    assert state(client) == State.LOADED


def test_stop_opens_the_bridge_and_ends_the_run(client: Client) -> None:
    hashes = client.prepare(duty(0.5, 10_000))
    client.ask("start", config_hash=hashes[0], program_hash=hashes[1])
    while not client.said or client.said[-1].name != "sample_block":
        client.listen()
    assert client.ask("stop").fields["state"] == State.LOADED
    assert client.said[-1].name == "done"
    assert client.said[-1].fields["reason"] == EndReason.STOPPED


@pytest.mark.parametrize(
    ("config", "steps", "fault"),
    [
        ({"current_limit_ma": 1000}, [duty(1.0, 500)], Fault.OVER_CURRENT),
        ({"speed_limit_counts_s": 100_000}, [duty(1.0, 5000)], Fault.OVER_SPEED),
        ({"supply_min_mv": 8000}, [duty(0.1, 500)], Fault.SUPPLY_LOW),
        ({"supply_max_mv": 6000}, [duty(0.1, 500)], Fault.SUPPLY_HIGH),
        ({"run_time_limit_ms": 30}, [duty(0.1, 500)], Fault.RUN_TIME),
    ],
)
def test_a_trip_opens_the_bridge_at_once_and_latches(
    client: Client, config: dict[str, int], steps: list[dict[str, int]], fault: Fault
) -> None:
    record = client.run(*steps, **config)
    event, done = record.event("fault").fields, record.event("done").fields
    assert event["fault"] == fault
    assert (done["reason"], done["tick"]) == (EndReason.FAULT, event["tick"])
    last = record.blocks[-1]
    assert last.first_tick + (len(last.samples) - 1) * TICKS == event["tick"]
    assert record.events.index(record.event("fault")) < record.events.index(record.event("done"))
    assert client.port._device.board.bench.is_open
    assert client.ask("configure", **CONFIG).status == Status.FAULT_LATCHED
    status = client.ask("read_status").fields
    assert (status["state"], status["fault"]) == (State.FAULTED, fault)
    assert client.ask("clear_fault").fields["state"] == State.CONFIGURED
    client.run(duty(0.1, 50))


def test_a_silent_host_stops_the_motor(client: Client) -> None:
    record = client.run(duty(0.3, 20_000), beat=False, host_silence_ms=200)
    assert record.event("fault").fields["fault"] == Fault.HOST_SILENCE
    assert record.event("done").fields["tick"] - record.start_tick == 200 * 16_000


def test_heartbeats_keep_a_run_alive(client: Client) -> None:
    record = client.run(duty(0.3, 5000), host_silence_ms=100)
    assert record.event("done").fields["reason"] == EndReason.COMPLETED


def test_burst_keeps_samples_and_drops_what_does_not_fit() -> None:
    client = Client("buffer=100")
    record = client.run(duty(0.3, 300), beat=False, mode=1)
    done = record.event("done").fields
    assert (done["samples"], done["dropped"]) == (100, 200)
    assert np.isfinite(record.samples).all()


def test_a_slow_link_drops_blocks_and_says_so() -> None:
    client = Client("baud=115200&buffer=64")
    record = client.run(duty(0.3, 3000))
    done = record.event("done").fields
    assert done["dropped"] > 1000
    assert done["samples"] + done["dropped"] == 3000
    assert sum(b.dropped for b in record.blocks) <= done["dropped"]
    gaps = [
        (b.first_tick - a.first_tick) // TICKS - len(a.samples)
        for a, b in zip(record.blocks, record.blocks[1:], strict=False)
    ]
    assert [b.dropped for b in record.blocks[1:]] == gaps


def test_slow_sampling_sends_part_filled_blocks(client: Client) -> None:
    step = coast(1) | {"ticks": 50 * 160_000}
    record = client.run(step, sample_period_ticks=160_000)
    assert {len(b.samples) for b in record.blocks} == {6, 2}


def test_a_seed_decides_every_sample() -> None:
    steps = duty(0.5, 300), coast(300)
    first, again, other = (Client(seed=seed).run(*steps).samples for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_run_does_not_depend_on_the_time_before_it() -> None:
    runs = []
    for pause in (0.0, 0.7):
        client = Client(seed=4)
        client.listen(pause)
        runs.append(client.run(duty(0.5, 300)).samples)
    assert np.array_equal(runs[0], runs[1])


def test_ticks_wrap() -> None:
    client = Client(first_tick=2**32 - 100 * TICKS)
    record = client.run(duty(0.2, 300))
    ticks = [b.first_tick for b in record.blocks]
    steps = {(b - a) % 2**32 for a, b in itertools.pairwise(ticks)}
    assert min(ticks) < max(ticks) - 2**31, "the counter must have wrapped"
    assert steps == {28 * TICKS}
