"""Boards old and new: what a rig may ask of each, and what the host says where one lacks it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire import record
from motorid.acquire.bench_facts import contradictions
from motorid.acquire.drive import of_fault, tripped
from motorid.acquire.guards import brown_out, guards, lacking, signs
from motorid.acquire.link_test import measure_link
from motorid.acquire.ports import details
from motorid.acquire.resets import reset_error
from motorid.capture import store
from motorid.errors import RigError
from motorid.program import StepKind, climbs
from motorid.rig import Rig
from motorid.wire.enums import Fault, ResetCause
from tests.acquire.rigs import SAMPLES, sim_rig

LIKE = {"board": "motorid-uno", "protocol_major": 1, "protocol_minor": 3}
MEAN = {"current_filter": 30e-6, "current_filter2": 20e-6}


def limited(options: str = "", **changes: object) -> Rig:
    rig = sim_rig(options)
    return replace(rig, limits=replace(rig.limits, **changes))  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("minor", [0, 1, 2])
def test_an_older_board_is_driven_as_ever(minor: int, tmp_path: Path) -> None:
    rig = sim_rig(f"minor={minor}")
    kept = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert (kept.end_reason, len(kept)) == ("completed", SAMPLES)
    assert f'"protocol_minor": {minor}' in str(kept.provenance).replace("'", '"')


@pytest.mark.parametrize(
    ("changes", "key"),
    [({"voltage_v": 9.0}, "limits.voltage_v"), ({"inputs": ("guard_closed",)}, "limits.inputs")],
)
def test_what_an_older_board_cannot_hold_is_refused(
    changes: dict[str, object], key: str, tmp_path: Path
) -> None:
    rig = limited("minor=2", **changes)
    with pytest.raises(RigError, match=rf"{key}, and the board motorid-sim \(protocol 1.2\)"):
        record.capture(rig, rig.program, tmp_path / "run.h5")
    assert not (tmp_path / "run.h5").exists()


def test_a_program_above_the_voltage_limit_is_refused_before_the_port_opens(tmp_path: Path) -> None:
    rig = limited(voltage_v=5.0)  # of a program up to 6 V
    with pytest.raises(RigError, match=r"puts 6 V on the motor, and limits.voltage_v is 5"):
        record.capture(rig, rig.program, tmp_path / "run.h5")


@pytest.mark.slow
def test_a_board_holds_the_voltage_limit(tmp_path: Path) -> None:
    """A supply that rises in mid-run lifts a duty's voltage."""
    rig = limited("fault=supply:13@0.7", voltage_v=6.5, supply_max_v=20.0)
    program = climbs([[0.7]], kind=StepKind.DRIVE_DUTY, drive_s=1.0, coast_s=[0.1], rest_s=0.02)
    with pytest.raises(RigError, match=r"tripped .over_voltage."):
        record.capture(rig, program, tmp_path / "run.h5")
    assert store.load(tmp_path / "run.h5").end_reason == "fault: over_voltage"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "says"),
    [("guard_open", "guard_closed is open .pin X2"), ("part_absent", "part_present is open")],
)
def test_an_open_contact_is_said_before_anything_turns(
    fault: str, says: str, tmp_path: Path
) -> None:
    rig = limited(f"fault={fault}", inputs=("part_present", "guard_closed"))
    with pytest.raises(RigError, match=says):
        record.capture(rig, rig.program, tmp_path / "run.h5")
    plain = sim_rig(f"fault={fault}")  # which does not ask for it
    assert record.capture(plain, plain.program, tmp_path / "plain.h5").exists()


@pytest.mark.slow
def test_a_guard_that_opens_in_a_run_ends_it(tmp_path: Path) -> None:
    rig = limited("fault=guard_open@0.7", inputs=("guard_closed",))
    with pytest.raises(RigError, match=r"input_opened: guard_closed\).*close guard and fixture"):
        record.capture(rig, rig.program, tmp_path / "run.h5")


def test_a_sensor_that_turns_round_after_the_pulse_is_seen_by_the_board(tmp_path: Path) -> None:
    """The second run of a series has no pulse before it."""
    rig = sim_rig("fault=encoder_reversed")
    from motorid.acquire.port import open_port

    port = open_port(rig.port)
    try:
        with pytest.raises(RigError, match=r"tripped .wrong_sign: position."):
            record.capture_over(port, rig, rig.program, tmp_path / "run.h5", checked=True)
    finally:
        port.close()


@pytest.mark.parametrize(
    ("value", "says"),
    [(1, "part_present"), (3, "part_present and guard_closed"), (4, ""), (-1, "part_present and")],
)
def test_the_contacts_of_a_trip_are_named(value: int, says: str) -> None:
    told = of_fault({"fault": Fault.INPUT_OPENED, "value": value})
    assert says in told
    assert ("(input_opened: " in tripped("fault: input_opened", told)) == bool(says)


def test_a_board_without_current_or_voltage_is_asked_for_no_more() -> None:
    rig, new = sim_rig(), {"features": 0xFF, "inputs": 0xFF, **LIKE}
    found = signs(rig, new, {})
    assert found["sign_check_ma"] == found["sign_check_mv"] == 2**32 - 1
    with pytest.raises(RigError, match="reads instants"):
        guards(limited(voltage_v=6.0), new, {})
    with pytest.raises(RigError, match="no pin for it"):
        guards(limited(inputs=("guard_closed",)), new | {"inputs": 1}, {})


@pytest.mark.slow
def test_a_filter_of_second_order_comes_into_the_capture(tmp_path: Path) -> None:
    rig = sim_rig("&".join(f"{name}={value}" for name, value in MEAN.items()))
    kept = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    current = kept.channels["current"]
    assert current.filter_order == 2
    assert current.filter_s == pytest.approx((30e-6 * 20e-6) ** 0.5, rel=1e-3)
    assert current.filter_delay_s == pytest.approx(50e-6, rel=1e-4)
    assert current.delay_s == pytest.approx(55e-6, rel=1e-4)  # and the board's own


# ---------------------------------------------------------------- brown-out and resets


@pytest.mark.parametrize(
    ("level", "least", "says"),
    [
        (2700, 3780, "resets it below 2.7 V, and its clock needs 3.78 V"),
        (0, 3780, "is off, and its clock needs 3.78 V"),
        (4300, 3780, ""),
        (3780, 3780, ""),
        (0, 0, ""),
    ],
)
def test_a_detector_below_what_the_clock_needs_is_said(level: int, least: int, says: str) -> None:
    facts = LIKE | {"brown_out_mv": level, "brown_out_least_mv": least}
    said = brown_out(facts)
    assert bool(said) == bool(says)
    assert says in said
    rig = sim_rig()
    at_capture = list(contradictions(rig, rig.program, facts | {"pwm_hz": 0}, {}, None, 800))
    assert at_capture == ([said] if said else [])


@pytest.mark.slow
def test_probing_says_what_a_board_lacks_and_what_is_wrong_with_it() -> None:
    new = list(details("sim://?speed=max&brown_out=2700"))
    assert "brown-out detector" in new[1]
    assert new[2:] == ["link: 256 of 256 commands answered, 0 frames damaged"]
    *old, _ = details("sim://?speed=max&minor=2")
    assert old == [
        "motorid-sim, firmware 1.0.0, protocol 1.2",
        "without voltage_limit, inputs, sign_check, front_end",
    ]
    bare = list(details("sim://?speed=max&front_end=none"))
    assert bare[1].startswith("the board motorid-sim has no valid facts of its front end")
    assert lacking({}) == lacking({"features": 0})


@pytest.mark.parametrize("fault", ["drop:0.0005", "flip:0.0005", "insert:0.0005"])
def test_probing_measures_what_a_link_loses(fault: str) -> None:
    from motorid.acquire.port import open_port

    port = open_port(f"sim://?speed=max&fault={fault}")
    try:
        found = measure_link(port)
    finally:
        port.close()
    assert found.sent == 256
    expected = 256 * (1 - (1 - 0.0005) ** 95)  # bytes there and back
    assert 0.3 * expected < found.sent - found.answered < 3 * expected
    assert found.damaged
    assert "loses data under load" in found.sentence()


def test_a_dead_line_ends_the_link_test() -> None:
    from motorid.acquire.port import open_port

    port = open_port("sim://?speed=max&fault=silence")
    try:
        found = measure_link(port)
    finally:
        port.close()
    assert (found.answered, found.clean) == (0, False)
    assert found.sent <= 12


def test_a_reset_of_unknown_cause_says_so() -> None:
    assert "(unknown)" in str(reset_error("port", ResetCause.UNKNOWN, "in use"))
    assert "cannot tell why" in str(reset_error("port", ResetCause.UNKNOWN, "in use"))
