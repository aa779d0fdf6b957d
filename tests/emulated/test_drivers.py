"""Every state of every driver of a bridge, on the emulated pins and in the motor behind them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from motorid.wire.enums import Bridge, Channel, Fault, ResetCause, Status
from motorid.wire.spec import load
from tests.conformance.boards import MCUSR, emulator_lacks, opened
from tests.conformance.client import Client

MOTOR = "dunkermotoren-gr42"
PERIOD = 800  # ticks of a PWM period
DUTY, TICKS = 0.4, 320
STORES_S = 1.5  # docs/protocol.md
ACTS_WITHIN_S = 200 / 16e6
LOW, HIGH = [0, 0], [0, PERIOD]
NOTCH = [1, PERIOD]  # but for one clock, where a compare register holds 0
OPENS = ("mosfet", "bipolar", "in_in", "pwm_dir")
# of inputs A and B: the ticks of a period between which each is high
PINS: dict[str, dict[str, Any]] = {
    "mosfet": {"forward": ([0, TICKS], LOW), "reverse": (LOW, [0, TICKS]), "brake": (LOW, LOW)},
    "in_in": {
        "forward": (NOTCH, [TICKS + 1, PERIOD]),
        "reverse": ([TICKS + 1, PERIOD], NOTCH),
        "brake": (NOTCH, NOTCH),
    },
    "pwm_dir": {
        "forward": ([0, TICKS], HIGH),
        "reverse": ([0, TICKS], LOW),
        "brake": (LOW, LOW),
    },
}
PINS["bipolar"], PINS["pwm_dir_bare"] = PINS["mosfet"], PINS["pwm_dir"]


class Rig:
    """An emulated Uno whose facts name the driver that its pins lead to."""

    def __init__(self, driver: str, stack: ExitStack) -> None:
        board: Any = stack.enter_context(opened("uno", motor=MOTOR, driver=driver))
        self.emulator = board.port.board
        self.client = Client(board.port)
        self.client.bring_up()
        known = self.client.get("read_front_end")
        names = [field.name for field in load().commands["write_front_end"].fields]
        facts = {name: known[name] for name in names} | {"bridge": Bridge[driver.upper()]}
        request = self.client.send("write_front_end", **facts)
        assert self.client.await_reply(request, STORES_S).status is Status.OK
        self.client.bring_up()
        self.driver, self.opens = driver, driver in OPENS
        self.pins = PINS[driver]

    @property
    def facts(self) -> dict[str, Any]:
        return dict(self.emulator.facts())

    def shows(self, state: str) -> bool:
        """Whether the pins are as they should be, and enable is high."""
        now = self.facts
        return [now["a"], now["b"], now["enable"]] == [*self.pins[state], 1]

    @property
    def is_off(self) -> bool:
        """Whether all inputs of the driver are low."""
        now = self.facts
        return [now["a"], now["b"], now["enable"]] == [LOW, LOW, 0]


@pytest.fixture(params=PINS)
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    with ExitStack() as stack:
        yield Rig(request.param, stack)


@pytest.mark.slow
def test_every_state_is_on_the_pins_and_in_the_motor(rig: Rig) -> None:
    client, samples = rig.client, 160
    forward, reverse = client.drive(samples, DUTY), client.drive(samples, -DUTY)
    brake, rest = client.brake(samples), client.coast(samples)
    steps = {"brake": brake, "forward": forward, "reverse": reverse}
    off = ("off",) if rig.opens else ()
    names = ("forward", "brake", "reverse", *off, "forward", "brake")
    program = [(steps | {"off": rest})[name] for name in names]
    record = client.start(*program, host_silence_ms=5000)
    began, length = client.port.now(), client.seconds(samples)
    for n, name in enumerate(names):
        client.wait(began + (n + 0.3) * length - client.port.now())
        before = rig.facts["speed"]
        if name == "off":
            assert rig.is_off
            assert abs(rig.facts["current"]) < 1e-6
            assert before < -10.0  # it turns on
        else:
            assert rig.shows(name), (name, rig.facts)
        client.wait(began + (n + 0.8) * length - client.port.now())
        after = rig.facts["speed"]
        if name in ("forward", "reverse"):
            assert after * (1 if name == "forward" else -1) > 10.0
        else:
            assert abs(after) < abs(before)
    client.follow(record)
    assert rig.is_off
    current = record.channel(Channel.CURRENT)
    volts = record.channel(Channel.TERMINAL_VOLTAGE)
    late = slice(samples // 2, samples - 8)  # of the first step
    supply = rig.facts["bus"]
    assert client.value(Channel.TERMINAL_VOLTAGE, volts[late].mean()) == pytest.approx(
        DUTY * supply, rel=0.03
    )
    assert client.value(Channel.CURRENT, current[late].mean()) > 0.1
    assert not rig.facts["recalled"]


def test_a_trip_makes_all_inputs_low_at_once_and_the_next_run_begins_clean(rig: Rig) -> None:
    client = rig.client
    for duty in (DUTY, -DUTY):
        record = client.start(client.drive(4000, duty))
        client.wait(0.03 + 2e-6)
        began = rig.emulator.now
        rig.emulator.set("complain", 1)
        client.wait(20e-6)
        assert rig.is_off
        assert rig.facts["enabled"] == int(not rig.opens)
        assert rig.opens or rig.facts["level"] == 0  # it brakes
        assert not rig.opens or 0 < rig.facts["changed"] - began < ACTS_WITHIN_S
        rig.emulator.set("complain", 0)
        client.follow(record)
        assert record.one("fault")["fault"] is Fault.DRIVER
        assert rig.is_off
        client.get("clear_fault")
        client.wait(0.3)
    hides = rig.driver in ("mosfet", "bipolar", "pwm_dir")  # enable is low meanwhile
    assert hides or not rig.facts["recalled"]


def test_stop_opens_the_bridge_and_a_reset_too(rig: Rig) -> None:
    client = rig.client
    client.start(client.drive(4000, DUTY))
    client.wait(0.03)
    assert rig.shows("forward")
    client.get("stop")
    assert rig.is_off
    client.wait(0.1)
    client.start(client.drive(4000, -DUTY))
    client.wait(0.03)
    assert rig.shows("reverse")
    rig.emulator.set("reset", MCUSR[ResetCause.EXTERNAL])
    assert rig.is_off
    client.wait(0.05)
    assert rig.is_off


def test_a_driver_that_cannot_open_refuses_a_coast(rig: Rig) -> None:
    client = rig.client
    assert client.configure().status is Status.OK
    status = client.ask("add_step", index=0, **client.coast(40)).status
    assert status is (Status.OK if rig.opens else Status.NOT_SUPPORTED)
    assert client.ask("add_step", index=int(rig.opens), **client.brake(40)).status is Status.OK


@pytest.mark.parametrize("ticks", [1, 2, 400, 798, 799, 800])
def test_in_in_drives_for_the_ticks_it_is_told(ticks: int) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    with ExitStack() as stack:
        rig = Rig("in_in", stack)
        rig.client.start(rig.client.drive(400, ticks / PERIOD))
        rig.client.wait(0.03)
        assert rig.facts["level"] == min(ticks, PERIOD - 1)  # one clock is the other input's
