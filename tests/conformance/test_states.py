"""The state machine: which state accepts which command, and what the others answer."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.wire.enums import Fault, Feature, Input, State, Status
from motorid.wire.spec import load
from tests.conformance.client import Client, Fields

SPEC = load()
STATES = [State.IDLE, State.CONFIGURED, State.LOADED, State.RUNNING, State.ZEROING, State.FAULTED]
AFTER = {  # the state that an accepted command leads to, where it is another
    ("configure", State.IDLE): State.CONFIGURED,
    ("configure", State.LOADED): State.CONFIGURED,
    ("clear_program", State.LOADED): State.CONFIGURED,
    ("add_step", State.CONFIGURED): State.LOADED,
    ("start", State.LOADED): State.RUNNING,
    ("stop", State.RUNNING): State.LOADED,
    ("stop", State.ZEROING): State.CONFIGURED,
    ("clear_fault", State.FAULTED): State.CONFIGURED,
}
SLOW = 8  # times the sample period: a busy computer's device answers late


def reach(client: Client, state: State) -> Fields:
    """Bring a board that was just brought up into a state; the fields of a valid ``start``."""
    hashes = {"config_hash": 0, "program_hash": 0}
    if state is State.IDLE:
        return hashes
    if state in (State.CONFIGURED, State.ZEROING):
        slow = SLOW if state is State.ZEROING else 1  # so that it lasts over any reply
        client.configure(sample_period_ticks=slow * client.settings["sample_period_ticks"])
        if state is State.ZEROING:
            client.send("zero", samples=4096)
            client.wait(0.01)
        return hashes
    hashes = client.load([client.coast(4000)])
    if state is State.RUNNING:
        client.get("start", **hashes)
    if state is State.FAULTED:
        client.run(client.coast(4000), run_time_limit_ms=1)
    return hashes


def fields_of(client: Client, name: str, hashes: Fields, state: State) -> Fields:
    """Fields that the board would accept."""
    match name:
        case "identify":
            return {"host_major": SPEC.major, "host_minor": SPEC.minor}
        case "describe_channel":
            return {"index": 0}
        case "configure":
            return client.settings
        case "add_step":
            return {"index": 1 if state is State.LOADED else 0, **client.coast(10)}
        case "start":
            return hashes
        case "heartbeat":
            return {"sequence": 0}
        case "zero":
            return {"samples": 10}
        case "describe_input":
            return {"input": Input.GUARD_CLOSED}
        case "write_front_end":
            return front_end(client)
    return {}


def front_end(client: Client) -> Fields:
    """The facts that the board has, or any where it keeps none."""
    fields = SPEC.commands["write_front_end"].fields
    if client.has(Feature.FRONT_END):
        known = client.get("read_front_end")
        return {field.name: known[field.name] for field in fields}
    return {field.name: "" if field.type == "text16" else 0 for field in fields}


NEEDS = {
    "describe_input": Feature.INPUTS,
    "read_front_end": Feature.FRONT_END,
    "write_front_end": Feature.FRONT_END,
}


def expected(client: Client, name: str, state: State) -> Status:
    """What docs/protocol.md says of a command in a state."""
    feature = NEEDS.get(name)
    states = SPEC.commands[name].states
    if not states or state.name.lower() in states:
        if name == "read_config" and state is State.IDLE:
            return Status.NOT_CONFIGURED
        lacking = feature is not None and not client.has(feature)
        return Status.NOT_SUPPORTED if lacking else Status.OK
    if state is State.FAULTED:
        return Status.FAULT_LATCHED
    if state is State.IDLE and name != "clear_fault":
        return Status.NOT_CONFIGURED
    if state is State.CONFIGURED and name == "start":
        return Status.PROGRAM_EMPTY
    return Status.BAD_STATE


def is_idle_possible(client: Client) -> bool:
    return client.state is State.IDLE


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.name.lower())
@pytest.mark.parametrize("name", sorted(SPEC.commands))
def test_a_state_accepts_what_the_table_says(client: Client, name: str, state: State) -> None:
    if state is State.IDLE and not is_idle_possible(client):
        pytest.skip("no device: only a reset brings a real board back to idle")
    hashes = reach(client, state)
    assert client.state is state
    fields = fields_of(client, name, hashes, state)
    reply = client.insist(name, 1.0 if state in (State.IDLE, State.ZEROING) else 0.1, **fields)
    assert reply.status is expected(client, name, state)
    if reply.status is Status.OK and name != "zero":
        assert client.state is AFTER.get((name, state), state)
    elif name != "zero":
        assert client.state is state
    client.get("stop")


def test_zero_returns_to_the_state_before(client: Client) -> None:
    client.configure()
    assert client.ask("zero", samples=10).status is Status.OK
    assert client.state is State.CONFIGURED
    client.load([client.coast(10)])
    assert client.ask("zero", samples=10).status is Status.OK
    assert client.state is State.LOADED


def test_clear_fault_forgets_the_program_and_keeps_the_configuration(client: Client) -> None:
    reach(client, State.FAULTED)
    assert client.fault is Fault.RUN_TIME
    assert client.get("clear_fault")["state"] == State.CONFIGURED
    assert client.fault is Fault.NONE
    config = client.get("read_config")
    assert {name: config[name] for name in client.settings} == client.settings
    assert client.ask("start", config_hash=0, program_hash=0).status is Status.PROGRAM_EMPTY


def test_stop_clears_no_fault(client: Client) -> None:
    reach(client, State.FAULTED)
    assert client.get("stop")["state"] == State.FAULTED
    assert client.fault is Fault.RUN_TIME


def test_a_configuration_forgets_the_program(client: Client) -> None:
    client.load([client.coast(10)])
    client.configure()
    assert client.state is State.CONFIGURED
    added: Any = client.get("add_step", index=0, **client.coast(10))
    assert added["steps"] == 1
