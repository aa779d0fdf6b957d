"""The recorder against pyvisa-sim: protections first, refusals, a whole polled run."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.acquire.record import capture_all
from motorid.capture import store
from motorid.errors import LinkError, MotoridError, RigError
from tests.scpi.rigs import rig
from tests.scpi.sim import METER, SUPPLY, definition

SHORT = {"scope": False, "supply": SUPPLY, "drive_s": 0.06, "rate_hz": 200, "levels": "[[3]]"}


def run(folder: Path, top: str, more: str = "") -> Path:
    one = rig(folder, top=top, more=more, **SHORT)
    return capture_all(one, one.program, [folder / "run.h5"])[0]


@pytest.mark.slow
def test_a_polled_run_is_a_capture_with_honest_facts(tmp_path: Path) -> None:
    found = store.load(run(tmp_path, definition(tmp_path)))
    assert len(found) >= 2
    assert found.end_reason == "completed"
    assert found.channels["current"].values == pytest.approx(1.25)
    assert found.channels["terminal_voltage"].values == pytest.approx(3.001)
    assert found.channels["terminal_voltage"].sense == "bridge"  # of the supply, before the leads
    assert found.program is None  # no clock is common to supply and readings
    assert not found.phases
    current = found.channels["current"]
    assert {"filter", "aperture"} <= set(current.undeclared)
    assert current.delay_uncertainty_s == pytest.approx(found.period_s / 12**0.5, rel=0.01)
    assert any("one by one" in note for note in found.provenance["notes"])
    told = found.provenance["instruments"]
    assert told["identities"] == {"supply": "MOCK,SUPPLY,1,1.0"}
    assert told["protection"] == {"over_voltage": 9.0, "current_limit": 4.0, "over_current": 4.0}
    assert [one["volts"] for one in told["commanded"]] == [None, 3.0, None]


@pytest.mark.slow
def test_a_meter_adds_a_channel_with_its_own_scale(tmp_path: Path) -> None:
    more = f"""
[meters.tacho]
resource = "{METER}"
[channels.current]
[channels.terminal_voltage]
[channels.speed]
instrument = "tacho"
query = "READ?"
scale = 2.0
zero = 25.0
gain_uncertainty = 0.01
"""
    found = store.load(run(tmp_path, definition(tmp_path), more))
    assert found.channels["speed"].values == pytest.approx(200.0)
    assert found.channels["speed"].gain_uncertainty == 0.01
    assert "gain" not in found.channels["speed"].undeclared


UNSAFE = {
    "reads back higher": ({}, {"VOLT:PROT?": "6.0E+01", "VOLT:PROT 9.0": None}, "reads back 60 V"),
    "refused": ({"VOLT:PROT": 5.0}, {}, "refused 'VOLT:PROT 9.0': -222"),
    "stays off": ({}, {"CURR:PROT:STAT?": "0", "CURR:PROT:STAT ON": None}, "reads back '0'"),
    "limit clamped": ({}, {"CURR?": "0.1", "CURR 4.0": None}, "current-limit was set to 4 A"),
    "infinite": ({}, {"VOLT:PROT?": "9.9E37", "VOLT:PROT 9.0": None}, "reads back nan"),
    "tripped": ({}, {"VOLT:PROT:TRIP?": "1"}, "over-voltage protection has tripped already"),
    "no number": ({}, {"VOLT:PROT?": "9,0 V", "VOLT:PROT 9.0": None}, "which is no number"),
}


@pytest.mark.parametrize("case", [*UNSAFE])
def test_nothing_is_switched_on_without_protections_that_read_back(
    case: str, tmp_path: Path
) -> None:
    most, answers, said = UNSAFE[case]
    switched = {"OUTP?": "0", "OUTP OFF": None, "OUTP ON": None}
    with pytest.raises(MotoridError, match=said):
        run(tmp_path, definition(tmp_path, most, {**switched, **answers}))
    assert not (tmp_path / "run.h5").exists()


def test_a_dialect_without_over_current_protection_is_refused(tmp_path: Path) -> None:
    dialect = Path(__file__).parents[2] / "rigs" / "instruments" / "scpi.toml"
    text = dialect.read_text(encoding="utf-8")
    begin, end = text.index("[over_current]"), text.index("[output]")
    (tmp_path / "bare.toml").write_text(text[:begin] + text[end:])
    with pytest.raises(RigError, match=r"has no over_current\.on: without over-current protection"):
        run(tmp_path, definition(tmp_path), 'dialect = "bare.toml"\n')


def test_an_output_that_stays_on_is_said_first_of_all(tmp_path: Path) -> None:
    stuck = {"OUTP?": "1", "OUTP OFF": None}
    with pytest.raises(LinkError, match="MAY STILL BE ON: switch it off by hand"):
        run(tmp_path, definition(tmp_path, None, stuck))
