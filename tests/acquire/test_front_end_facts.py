"""A board's front end against a rig's, and as it is shown: by boards that answer as told."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import front_end as room
from motorid.acquire.front_end import bare, check, drivable, refuse_coasts, show, store
from motorid.capture.model import VOLTAGE
from motorid.errors import LinkError, RigError, UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig_front_end import FrontEnd, load_front_end, parse
from motorid.wire.enums import Bridge, Feature, FrontEndSource, Sensor, State
from tests.acquire.rigs import sim_rig
from tests.test_rig_front_end import GOOD

RIG = sim_rig()
WANTED = load_front_end("acs712-20")
FACTS = {
    "name": "mine", "source": FrontEndSource.STORED, "sensor": Sensor.HALL, "ratiometric": 1,
    "bridge": Bridge.PWM_DIR_BARE, "reference_v": 5.0, "current_v_a": 0.1, "current_zero_v": 2.5,
    "voltage_divider": 8.0, "supply_divider": 4.0, "lift_v": 0.25, "front_end_hash": 0xAB,
    "current_gain_uncertainty": 4000, "voltage_gain_uncertainty": 500,
    "current_zero_uncertainty": 200, "current_filter": 220, "current_filter2": 100,
    "voltage_filter": 35, "voltage_filter2": 0,
}  # fmt: skip


class Told:
    """A board with that front end; what it is asked is noted."""

    def __init__(self, told: int = 7, features: int = 0xFF, **facts: Any) -> None:
        self.identity = {
            "front_end_hash": told, "features": features, "board": "bench",
            "max_current_ma": 12_500,
        }  # fmt: skip
        self.facts, self.opens, self.state = FACTS | facts, True, State.IDLE
        self.asked: list[Any] = []
        self.port = SimpleNamespace(name="port", close=lambda: self.asked.append("closed"))

    def ask(self, name: str, /, **fields: Any) -> dict[str, Any]:
        self.asked.append((name, fields) if fields else name)
        return {"read_status": {"state": self.state}}.get(name, self.facts)

    def identify(self) -> None:
        self.asked.append("identify")

    def unlatch(self) -> None:
        self.asked.append("unlatch")


def checked(board: Told, rig: Any = RIG) -> Any:
    return check(board, rig)  # type: ignore[arg-type]


# -- before a run
@pytest.mark.parametrize(("bridge", "opens"), [(Bridge.PWM_DIR_BARE, False), (Bridge.MOSFET, True)])
def test_a_stored_front_end_is_named_in_the_configuration(bridge: Bridge, opens: bool) -> None:
    board = Told(bridge=bridge)
    assert checked(board) == {"front_end_hash": 7}
    assert (board.opens, board.asked) == (opens, ["read_front_end"])


def test_a_board_that_stores_none_is_as_its_firmware_says() -> None:
    board = Told(0, source=FrontEndSource.COMPILED)
    assert checked(board) == {}
    assert board.opens
    old = Told(0, features=0)
    del old.identity["front_end_hash"]
    assert (checked(old), old.asked) == ({}, [])
    with pytest.raises(
        RigError, match=r"^port: the board bench has no valid .*`motorid board list"
    ):
        checked(Told(0, source=FrontEndSource.NONE))


def test_a_sensor_without_a_sign_guards_and_measures_nothing() -> None:
    board = Told(sensor=Sensor.MAGNITUDE)
    with pytest.raises(RigError, match=r"the board's front end \(mine\) shows how much current"):
        checked(board)
    without = replace(RIG, sampling=replace(RIG.sampling, channels=(VOLTAGE,)))
    assert checked(board, without) == {"front_end_hash": 7}


@pytest.mark.parametrize(
    ("name", "says"),
    [
        (
            "other",
            "names the front end acs712-20, and the board holds other: `motorid board set acs",
        ),
        (
            "acs712-20",
            "the board holds acs712-20 with other figures: `motorid board set acs712-20`",
        ),
        ("", "the board holds no valid facts: `motorid board set"),
    ],
)
def test_a_rig_s_front_end_is_the_board_s(name: str, says: str) -> None:
    named = replace(RIG, front_end="acs712-20")
    assert checked(Told(WANTED.hash), named) == {"front_end_hash": WANTED.hash}
    with pytest.raises(RigError, match=says):
        checked(Told(WANTED.hash ^ 1, name=name), named)
    with pytest.raises(RigError, match="the board bench keeps no facts of its front end"):
        checked(Told(0, features=0xFF & ~(1 << Feature.FRONT_END)), named)


def test_a_rig_s_own_file_is_in_its_folder(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(GOOD)
    named = replace(RIG, front_end="own.toml", folder=str(tmp_path))
    told = parse(GOOD).hash
    assert checked(Told(told), named) == {"front_end_hash": told}


# -- a driver that cannot open
COASTS = Program(
    (Step(StepKind.COAST, 0.1), Step(StepKind.DRIVE_VOLTS, 0.1, 3.0, Decay.SYNCHRONOUS_SLOW)) * 2
)


def test_a_program_brakes_where_the_rig_s_driver_cannot_open(tmp_path: Path) -> None:
    assert drivable(RIG, COASTS) is COASTS
    assert drivable(replace(RIG, front_end="acs712-20"), COASTS) is COASTS
    (tmp_path / "own.toml").write_text(
        GOOD.replace("ratiometric", 'bridge = "pwm_dir_bare"\nratiometric')
    )
    bare_one = replace(RIG, front_end="own.toml", folder=str(tmp_path))
    found = drivable(bare_one, COASTS)
    assert [step.kind for step in found.steps] == [StepKind.BRAKE, StepKind.DRIVE_VOLTS] * 2


def test_a_coast_that_a_driver_cannot_do_is_refused() -> None:
    board: Any = Told()
    refuse_coasts(board, COASTS)
    board.opens = False
    with pytest.raises(
        RigError, match="cannot open the bridge, and 2 of the program's steps coast"
    ):
        refuse_coasts(board, COASTS)
    refuse_coasts(board, COASTS.braked())


def test_facts_are_missing_where_a_board_should_have_some() -> None:
    def said(**facts: Any) -> str:
        return bare(Told(**facts))  # type: ignore[arg-type]

    assert said(source=FrontEndSource.NONE).startswith("the board bench has no valid facts of its")
    assert said(source=FrontEndSource.COMPILED) == said() == ""
    assert said(source=FrontEndSource.NONE, features=0) == ""


# -- shown and stored
@pytest.fixture
def behind(monkeypatch: pytest.MonkeyPatch) -> Iterator[Told]:
    """The board behind every port."""
    board = Told(front_end_hash=WANTED.hash)
    board.identity["board"] = "motorid-uno"
    monkeypatch.setattr(room, "open_port", lambda url: board.port)
    monkeypatch.setattr(room, "Board", lambda port: board)
    yield board
    assert board.asked[-1] == "closed"


def test_facts_are_shown_in_units(behind: Told) -> None:
    behind.facts["front_end_hash"] = 0xAB
    assert list(show("port")) == [
        "motorid-uno: facts of the front end are stored",
        "name               mine  (hash 000000ab)",
        "reference          5 V",
        "current            0.1 V/A, 2.5 V at 0 A, signed, follows the reference",
        "   uncertainty     4.00% of a reading, 0.02 V of the zero (standard)",
        "voltage            terminals 1/8, supply 1/4, lifted by 0.25 V",
        "   uncertainty     0.50% of a reading (standard)",
        "filters            current 22 us (second order, 10 us), voltages 3.5 us",
        "bridge             pwm_dir_bare",
        "largest limit      12.5 A",
    ]
    behind.facts |= {"sensor": Sensor.MAGNITUDE, "ratiometric": 0, "voltage_filter": 0}
    lines = list(show("port"))
    assert lines[3].endswith("2.5 V at 0 A, no sign")
    assert lines[7].endswith("voltages none")
    behind.facts["source"] = FrontEndSource.NONE
    head, hint = show("port")
    assert (
        head == "motorid-uno: facts of the front end are none that are valid: it refuses to drive"
    )
    assert hint.startswith("`motorid board set NAME` stores them")


def test_facts_are_stored_and_read_back(behind: Told) -> None:
    assert store("port", WANTED)[0] == "motorid-uno: facts of the front end are stored"
    assert behind.asked == [
        "identify", "unlatch", "read_status",
        ("write_front_end", {"timeout_s": 1.5} | WANTED.facts), "read_front_end", "identify",
        "closed",
    ]  # fmt: skip


def test_facts_that_read_back_otherwise_are_said(behind: Told) -> None:
    behind.facts["front_end_hash"] = 1
    with pytest.raises(LinkError, match=r"^port: the board holds other facts than were sent"):
        store("port", WANTED)


def test_facts_of_another_board_are_not_stored(behind: Told) -> None:
    behind.identity["board"] = "motorid-pico"
    with pytest.raises(RigError, match="or store this with --any-board, if that is what is wired"):
        store("port", WANTED)
    assert behind.asked == ["identify", "closed"]
    store("port", WANTED, True)


def test_a_board_at_work_stores_nothing(behind: Told) -> None:
    behind.state = State.CONFIGURED
    with pytest.raises(UsageError, match=r"^port: the board is configured for runs"):
        store("port", WANTED)
    behind.identity["features"] = 0
    with pytest.raises(RigError, match="keeps no facts of its front end"):
        next(show("port"))


def test_a_front_end_is_named_by_its_facts() -> None:
    assert FrontEnd(WANTED.facts, "").hash == WANTED.hash != parse(GOOD).hash
