"""Every state of every driver of a bridge, on the emulated pins and in the motor behind them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import pytest

from motorid.wire.enums import Bridge, Channel, Fault, ResetCause, Status
from motorid.wire.spec import load
from tests.conformance.boards import emulator_lacks, opened, pico_lacks
from tests.conformance.client import Client

MOTOR = "dunkermotoren-gr42"
DUTY = 0.4
STORES_S = 1.5  # docs/protocol.md
ACTS_WITHIN_S = 200 / 16e6
LOW = [0, 0]
OPENS = ("mosfet", "bipolar", "in_in", "pwm_dir")
HIDES = ("mosfet", "bipolar", "pwm_dir")  # enable is low while the timer's outputs are connected


@dataclass(frozen=True)
class Timer:
    """Of a board: ticks of a PWM period, and those by which an inverted compare is late."""

    period: int
    late: int

    def pins(self, driver: str) -> dict[str, Any]:
        """Of inputs A and B in each state: the ticks between which each is high."""
        pulse, high = [0, round(DUTY * self.period)], [0, self.period]
        if driver == "in_in":
            on = [self.late, self.period]  # but for a clock, where a compare of 0 is one
            rest = [pulse[1] + self.late, self.period]
            return {"forward": (on, rest), "reverse": (rest, on), "brake": (on, on)}
        if driver.startswith("pwm_dir"):
            return {"forward": (pulse, high), "reverse": (pulse, LOW), "brake": (LOW, LOW)}
        return {"forward": (pulse, LOW), "reverse": (LOW, pulse), "brake": (LOW, LOW)}


TIMERS = {"uno": Timer(800, 1), "pico": Timer(6250, 0)}
COMPLAINS_WITHIN_S = 20e-6
DRIVERS = [name.lower() for name in Bridge.__members__]


def skip_without(board: str) -> None:
    """Where it cannot be emulated."""
    if lack := pico_lacks() if board == "pico" else emulator_lacks():
        pytest.skip(f"no emulated {board}: {lack}")


class Rig:
    """An emulated board whose facts name the driver that its pins lead to."""

    def __init__(self, name: str, driver: str, stack: ExitStack) -> None:
        board: Any = stack.enter_context(opened(name, motor=MOTOR, driver=driver))
        self.board, self.timer = board, TIMERS[name]
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
        self.pins = self.timer.pins(driver)

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


def case(board: str, what: Any) -> Any:
    """A board and something else as one parameter; a Pico takes longer to emulate."""
    marks = [pytest.mark.slow] if board == "pico" else []
    return pytest.param((board, what), marks=marks, id=f"{board}-{what}")


CASES = [case(board, driver) for board in TIMERS for driver in DRIVERS]


@pytest.fixture(params=CASES)
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    board, driver = request.param
    skip_without(board)
    with ExitStack() as stack:
        yield Rig(board, driver, stack)


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
    assert not rig.facts.get("recalled")


@pytest.mark.slow
def test_a_trip_makes_all_inputs_low_at_once_and_the_next_run_begins_clean(rig: Rig) -> None:
    client = rig.client
    for duty in (DUTY, -DUTY):
        client.wait(0.3 if duty < 0 else 0.0)  # the motor of the first run has slowed down
        record = client.start(client.drive(4000, duty))
        client.wait(0.03 + 2e-6)
        began = rig.emulator.now
        rig.emulator.set("complain", 1)
        client.wait(COMPLAINS_WITHIN_S)
        now = rig.facts
        assert rig.is_off
        assert now["enabled"] == int(not rig.opens)
        assert rig.opens or now["level"] == 0  # it brakes
        if rig.opens and "changed" in now:
            assert 0 < now["changed"] - began < ACTS_WITHIN_S
        rig.emulator.set("complain", 0)
        client.follow(record)
        assert record.one("fault")["fault"] is Fault.DRIVER
        assert rig.is_off
        client.get("clear_fault")
    assert rig.driver in HIDES or not rig.facts.get("recalled")


@pytest.mark.slow
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
    rig.board.reset(ResetCause.EXTERNAL)
    assert rig.is_off
    client.wait(0.05)
    assert rig.is_off


@pytest.mark.slow
def test_a_driver_that_cannot_open_refuses_a_coast(rig: Rig) -> None:
    client = rig.client
    assert client.configure().status is Status.OK
    status = client.ask("add_step", index=0, **client.coast(40)).status
    assert status is (Status.OK if rig.opens else Status.NOT_SUPPORTED)
    assert client.ask("add_step", index=int(rig.opens), **client.brake(40)).status is Status.OK


@pytest.mark.slow
@pytest.mark.parametrize(
    "board_and_ticks",
    [case("uno", ticks) for ticks in (1, 2, 400, 798, 799, 800)]
    + [case("pico", ticks) for ticks in (1, 3125, 6250)],
)
def test_in_in_drives_for_the_ticks_it_is_told(board_and_ticks: tuple[str, int]) -> None:
    board, ticks = board_and_ticks
    skip_without(board)
    with ExitStack() as stack:
        rig = Rig(board, "in_in", stack)
        rig.client.start(rig.client.drive(400, ticks / rig.timer.period))
        rig.client.wait(0.03)
        # a clock is the other input's, where a compare of 0 is one
        assert rig.facts["level"] == min(ticks, rig.timer.period - rig.timer.late)


@pytest.mark.slow
@pytest.mark.parametrize("crash", ["fault", "hang"])
def test_a_crash_of_a_pico_makes_all_inputs_low(crash: str) -> None:
    """At once, where the processor still does anything; the watchdog ends a hang."""
    skip_without("pico")
    with ExitStack() as stack:
        rig = Rig("pico", "in_in", stack)
        rig.client.start(rig.client.drive(4000, -DUTY))
        rig.client.wait(0.03)
        assert rig.shows("reverse")
        rig.emulator.set(crash, 1)
        rig.client.wait(0.24 if crash == "hang" else 100e-6)
        assert rig.is_off
        assert rig.facts["resets"] == 1
