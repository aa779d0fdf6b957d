"""The relay: any port behind a bad cable, and what the client makes of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire import record
from motorid.acquire.port import open_port
from motorid.acquire.relay import RELAY_KINDS, RelayPort
from motorid.capture import store
from motorid.errors import LinkError, UsageError
from motorid.sim.faults import parse_faults
from tests.acquire.rigs import sim_rig

SAMPLES = 3800


class Echo:
    """A port whose clock moves by what is waited, and which says back what it hears."""

    name = "echo"

    def __init__(self) -> None:
        self.time = 0.0
        self.waiting = b""
        self.closed = 0

    def read(self, size: int, timeout_s: float) -> bytes:
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        if not data:
            self.time += timeout_s
        return data

    def write(self, data: bytes) -> None:
        self.waiting += data

    def now(self) -> float:
        return self.time

    def close(self) -> None:
        self.closed += 1


def relay(fault: str, seed: int = 1) -> tuple[RelayPort, Echo]:
    echo = Echo()
    return RelayPort(echo, parse_faults(fault, RELAY_KINDS), seed, lambda which: Echo()), echo


def all_of(port: RelayPort, seconds: float) -> bytes:
    until, heard = port.now() + seconds, b""
    while port.now() < until:
        heard += port.read(100, until - port.now())
    return heard


def test_without_faults_bytes_pass_unchanged_and_waits_end() -> None:
    port, _ = relay("")
    port.write(b"question")
    assert port.read(100, 1.0) == b"question"
    assert port.read(100, 0.25) == b""
    assert port.now() == pytest.approx(0.25)


def test_what_is_written_goes_out_at_once_though_nobody_reads() -> None:
    port, echo = relay("")
    port.write(b"stop")
    assert echo.waiting == b"stop"


@pytest.mark.parametrize("fault", ["flip:0.05", "drop:0.05", "insert:0.05", "double:0.05"])
def test_damage_is_the_seed_s(fault: str) -> None:
    said = bytes(range(256)) * 8
    heard = []
    for seed in (1, 1, 2):
        port, _ = relay(fault, seed)
        port.write(said)
        heard.append(all_of(port, 0.1))
    assert heard[0] == heard[1]
    assert len({said, heard[0], heard[2]}) == 3
    assert (len(heard[0]) == len(said)) == fault.startswith("flip")


def test_a_delay_delays_both_ways_and_keeps_the_order_when_it_ends() -> None:
    port, _ = relay("delay:0.2@0..0.3")
    port.write(b"first")
    assert all_of(port, 0.39) == b""  # there at 0.2, back at 0.4
    port.write(b"second")
    assert all_of(port, 0.1) == b"firstsecond"


def test_bursts_come_at_their_times_and_splits_are_small() -> None:
    port, _ = relay("burst:0.1")
    port.write(b"abc")
    assert all_of(port, 0.099) == b""
    assert all_of(port, 0.01) == b"abc"
    port, _ = relay("split")
    port.write(bytes(50))
    assert len(port.read(100, 0.1)) < 8
    assert len(all_of(port, 0.1)) > 35


@pytest.mark.parametrize("fault", ["silence", "deaf", "mute"])
def test_a_gap_in_the_line_passes(fault: str) -> None:
    port, _ = relay(f"{fault}@0.1..0.2")
    heard = b""
    for letter in b"abcd":
        port.write(bytes([letter]))
        heard += all_of(port, 0.08)
    assert heard == b"abd"  # c was sent at 0.16


def test_a_pulled_cable_is_a_link_error_from_both_sides() -> None:
    port, echo = relay("unplug@0.1")
    with pytest.raises(LinkError, match="pulled the cable"):
        all_of(port, 1.0)
    with pytest.raises(LinkError):
        port.write(b"x")
    port.close()
    assert echo.closed == 1


def test_a_fault_that_is_due_strikes_before_what_is_written_then() -> None:
    port, echo = relay("deaf@0.1")
    echo.time = 0.2  # nobody read or wrote meanwhile
    port.write(b"stop")
    assert echo.waiting == b""


def test_a_relay_that_has_nothing_to_plug_in_says_so() -> None:
    port = RelayPort(Echo(), parse_faults("reset@0.1", RELAY_KINDS))
    with pytest.raises(LinkError, match="echo: the relay has nothing to plug in"):
        all_of(port, 1.0)


def test_a_swap_puts_another_port_in_place_and_time_goes_on() -> None:
    port, echo = relay("swap:0.2@0.5")
    all_of(port, 0.6)
    port.write(b"lost")
    assert all_of(port, 0.2) == b""
    assert echo.closed == 1
    port.write(b"new")
    assert port.read(10, 0.1) == b"new"
    assert port.now() == pytest.approx(0.8, abs=0.01)


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("relay://", "with to last"),
        ("relay://?seed=1", "with to last"),
        ("relay://?to=", "with to last"),
        ("relay://?sed=1&to=sim://", "unknown option sed"),
        ("relay://?seed=x&to=sim://", "whole number"),
        ("relay://?fault=stall&to=sim://", "no fault 'stall'"),
        ("relay://?fault=unplug@1..2&to=sim://", "cannot end"),
        ("relay://?fault=mute@2..1&to=sim://", "cannot end"),
        ("relay://?to=sim://?motr=x", "motor"),
    ],
)
def test_a_senseless_url_is_a_usage_error(url: str, says: str) -> None:
    with pytest.raises(UsageError) as caught:
        open_port(url)
    assert says in str(caught.value)


def capture(fault: str, path: Path, **more: str) -> Path:
    rig = sim_rig()
    options = "".join(f"&{name}={value}" for name, value in more.items())
    rig = replace(rig, port=f"relay://?fault={fault}{options}&to={rig.port}")
    return record.capture(rig, rig.program, path)


@pytest.mark.slow
def test_a_capture_through_a_good_relay_is_whole(tmp_path: Path) -> None:
    kept = store.load(capture("split", tmp_path / "run.h5"))
    assert (len(kept), kept.gaps, kept.end_reason) == (SAMPLES, (), "completed")


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["flip:3e-4", "drop:3e-4", "insert:3e-4", "double:3e-4"])
def test_a_bad_relay_loses_blocks_and_says_so(fault: str, tmp_path: Path) -> None:
    kept = store.load(capture(fault, tmp_path / "run.h5"))
    assert kept.end_reason == "completed"
    assert sum(gap.samples for gap in kept.gaps) == SAMPLES - len(kept) > 0


@pytest.mark.slow
def test_the_same_seed_gives_the_same_gaps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motorid.acquire.run_header.random.randrange", lambda low, high: 77)
    gaps = [
        store.load(capture("drop:4e-4", tmp_path / f"{n}.h5", seed=seed)).gaps
        for n, seed in enumerate(("3", "3", "4"))
    ]
    assert gaps[0] == gaps[1] != ()
    assert gaps[0] != gaps[2]


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["reset", "swap"])
@pytest.mark.parametrize("at_s", [0.05, 0.3, 0.6, 0.9, 1.2])
def test_a_reset_or_another_board_is_said_at_any_time(
    fault: str, at_s: float, tmp_path: Path
) -> None:
    """Whatever the client was doing when it happened."""
    with pytest.raises(LinkError) as caught:
        capture(f"{fault}@{at_s}", tmp_path / "run.h5")
    assert "the board was reset" in str(caught.value)
    assert "firmware" not in str(caught.value)
    assert caught.value.exit_code == 3


def test_open_relay_closes_what_it_holds() -> None:
    port = open_port("relay://?fault=flip:0&to=sim://?speed=max")
    port.close()
    with pytest.raises(LinkError, match="closed"):
        port.read(1, 0.1)
