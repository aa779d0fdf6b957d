"""configure, read_config, and the steps of a program: every limit and its status."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from motorid.wire.enums import Feature, State, Status, StepKind
from motorid.wire.hashes import config_hash, program_hash
from tests.conformance.client import ALL, Client, Fields

FULL_DUTY = 1_000_000
U32 = 2**32 - 1


def bad_configs(client: Client) -> dict[str, tuple[Fields, Status]]:
    """Changes that make a configuration unacceptable, and the status that says why."""
    identity = client.identity
    shortest = identity["min_sample_period_ticks"]
    step = identity["sample_period_step_ticks"]
    bad = Status.BAD_VALUE
    cases: dict[str, tuple[Fields, Status]] = {
        "period zero": ({"sample_period_ticks": 0}, bad),
        "period too short": ({"sample_period_ticks": shortest - step}, bad),
        "period no multiple": ({"sample_period_ticks": shortest + 1}, bad),
        "no channels": ({"channels": 0}, bad),
        "a channel beyond": ({"channels": 0b1_0001}, Status.NOT_SUPPORTED),
        "the last bit": ({"channels": 0x80 | ALL}, Status.NOT_SUPPORTED),
        "unknown mode": ({"mode": 2}, Status.NOT_SUPPORTED),
        "reversed twice": ({"encoder_reversed": 2}, bad),
        "no current": ({"current_limit_ma": 0}, bad),
        "too much current": ({"current_limit_ma": identity["max_current_ma"] + 1}, bad),
        "any current": ({"current_limit_ma": U32}, bad),
        "no speed": ({"speed_limit_counts_s": 0}, bad),
        "supply limits equal": ({"supply_min_mv": 9000, "supply_max_mv": 9000}, bad),
        "supply limits swapped": ({"supply_min_mv": 9000, "supply_max_mv": 8000}, bad),
        "no run time": ({"run_time_limit_ms": 0}, bad),
        "no silence": ({"host_silence_ms": 0}, bad),
    }
    if client.has(Feature.SIGN_CHECK):
        signs = {"sign_check_ms": 1, "sign_check_ma": 1, "sign_check_mv": 1, "sign_check_counts": 1}
        cases |= {f"{name} zero": (signs | {name: 0}, bad) for name in list(signs)[1:]}
    cases["an input that is none"] = ({"inputs_required": 0x80}, Status.NOT_SUPPORTED)
    other = identity["front_end_hash"] ^ 1
    cases["another front end"] = ({"front_end_hash": other or 2}, Status.HASH_MISMATCH)
    if identity["encoder_edge_ceiling_hz"] < U32:
        too_fast = identity["encoder_edge_ceiling_hz"] + 1
        cases["faster than edges"] = ({"speed_limit_counts_s": too_fast}, Status.EDGE_CEILING)
    if identity["max_host_silence_ms"] < 0xFFFF:
        cases["long silence"] = ({"host_silence_ms": identity["max_host_silence_ms"] + 1}, bad)
    return cases


def test_every_bad_value_is_refused_and_changes_nothing(client: Client) -> None:
    client.load([client.coast(10)])
    before = client.get("read_config")
    for name, (changes, status) in bad_configs(client).items():
        reply = client.ask("configure", **client.settings | changes)
        assert reply.status is status, name
        assert client.get("read_config") == before, name
        assert client.state is State.LOADED, name


def test_limits_themselves_are_accepted(client: Client) -> None:
    identity = client.identity
    edges = {
        "sample_period_ticks": identity["min_sample_period_ticks"],
        "current_limit_ma": identity["max_current_ma"],
        "speed_limit_counts_s": identity["encoder_edge_ceiling_hz"],
        "supply_min_mv": 0,
        "supply_max_mv": U32,
        "run_time_limit_ms": U32,
        "host_silence_ms": identity["max_host_silence_ms"],
    }
    for name, value in edges.items():
        assert client.ask("configure", **client.settings | {name: value}).status is Status.OK, name
    narrow = client.settings | {"supply_min_mv": 0, "supply_max_mv": 1}
    assert client.ask("configure", **narrow).status is Status.OK
    for name in ("current_limit_ma", "speed_limit_counts_s", "run_time_limit_ms"):
        assert client.ask("configure", **client.settings | {name: 1}).status is Status.OK, name


@pytest.mark.parametrize("mode", [0, 1])
def test_read_config_gives_back_what_is_in_force(client: Client, mode: int) -> None:
    settings = client.settings | {"mode": mode, "channels": 0b0101, "encoder_reversed": 1}
    settings |= {"run_time_limit_ms": 0x0102_0304, "host_silence_ms": 0x0201}
    if client.has(Feature.VOLTAGE_LIMIT):
        settings |= {"voltage_limit_mv": 0x0102_0304}
    if client.has(Feature.SIGN_CHECK):
        settings |= {"sign_check_ms": 0x0102, "sign_check_ma": 3, "sign_check_mv": 0x0405_0607}
        settings |= {"sign_check_counts": 0x0809}
    hashed = {"config_hash": config_hash(settings, client.identity["protocol_minor"])}
    assert client.get("configure", **settings) == hashed
    assert client.get("read_config") == settings | hashed


# ---------------------------------------------------------------- steps


def bad_steps(client: Client) -> dict[str, tuple[Fields, Status]]:
    """Steps, index 0, that are not acceptable."""
    drive, coast, brake = client.drive(10), client.coast(10), client.brake(10)
    hold = client.hold(10, 1.0)
    bad, foreign = Status.BAD_VALUE, Status.NOT_SUPPORTED
    cases = {
        "not the next": (drive | {"index": 1}, bad),
        "unknown kind": (drive | {"kind": 4}, foreign),
        "drive without decay": (drive | {"decay": 0}, foreign),
        "unknown decay": (drive | {"decay": 4}, foreign),
        "a decay beyond a byte's bits": (drive | {"decay": 9}, foreign),
        "coast with decay": (coast | {"decay": 1}, bad),
        "brake with decay": (brake | {"decay": 1}, bad),
        "coast with a level": (coast | {"level": 1}, bad),
        "brake with a level": (brake | {"level": -1}, bad),
        "more than full duty": (drive | {"level": FULL_DUTY + 1}, bad),
        "more than full reverse": (drive | {"level": -FULL_DUTY - 1}, bad),
        "the most negative duty": (drive | {"level": -(2**31)}, bad),
        "a million volts": (hold | {"level": 2**31 - 1}, bad),
        "no time": (drive | {"ticks": 0}, bad),
        "part of a sample": (drive | {"ticks": client.period + 1}, bad),
    }
    for mode in (1, 2, 3):
        if not client.identity["decay_modes"] >> mode & 1:
            cases[f"decay {mode}"] = (drive | {"decay": mode}, foreign)
    return cases


def test_every_bad_step_is_refused_and_not_loaded(client: Client) -> None:
    client.configure()
    for name, (step, status) in bad_steps(client).items():
        assert client.ask("add_step", **{"index": 0, **step}).status is status, name
        assert client.state is State.CONFIGURED, name
    assert client.get("add_step", index=0, **client.coast(1))["steps"] == 1


def test_steps_at_their_limits_are_accepted(client: Client) -> None:
    client.configure()
    longest = U32 // client.period * client.period
    steps = [
        client.drive(1, 1.0),
        client.drive(1, -1.0),
        client.hold(1, 1000.0),
        client.hold(1, -1000.0),
        client.coast(1) | {"ticks": longest},
    ]
    for index, step in enumerate(steps):
        assert client.get("add_step", index=index, **step)["steps"] == index + 1


def test_every_decay_mode_that_the_board_has_is_accepted(client: Client) -> None:
    client.configure()
    for mode in (1, 2, 3):
        if client.identity["decay_modes"] >> mode & 1:
            step = client.drive(1) | {"decay": mode}
            assert client.ask("add_step", index=0, **step).status is Status.OK
            client.get("clear_program")


def test_the_program_hash_grows_with_every_step(client: Client) -> None:
    client.configure()
    steps: list[dict[str, Any]] = []
    for index, step in enumerate([client.drive(3, -0.25), client.brake(2), client.coast(7)]):
        steps.append({"index": index, **step})
        reply = client.get("add_step", **steps[-1])
        assert reply == {"steps": index + 1, "program_hash": program_hash(steps)}
    client.get("clear_program")
    assert client.state is State.CONFIGURED
    first = {"index": 0, **client.coast(1)}
    assert client.get("add_step", **first)["program_hash"] == program_hash([first])


def test_a_full_program_takes_no_more(client: Client) -> None:
    client.configure()
    most = client.identity["max_steps"]
    for index in range(most):
        client.get("add_step", index=index, **client.coast(1))
    reply = client.ask("add_step", index=most, **client.coast(1))
    assert reply.status is (Status.PROGRAM_FULL if most < 255 else Status.BAD_VALUE)
    assert client.state is State.LOADED


@pytest.mark.slow
@pytest.mark.parametrize("board_name", ["sim"])
def test_as_many_steps_as_the_wire_can_count(make_client: Callable[..., Client]) -> None:
    """Indices 0 to 254: one beyond is no index, and not a program that is full."""
    test_a_full_program_takes_no_more(make_client(max_steps=255))


def test_a_full_program_runs_step_by_step(client: Client) -> None:
    most = min(client.identity["max_steps"], 40)
    kinds = [StepKind.COAST, StepKind.BRAKE]
    steps = [client.coast(2) | {"kind": kinds[index % 2]} for index in range(most)]
    record = client.run(*steps)
    phases = record.all("phase")
    assert [phase["index"] for phase in phases] == list(range(most))
    ticks = [(phase["tick"] - record.start_tick) & U32 for phase in phases]
    assert ticks == [2 * client.period * index for index in range(most)]
