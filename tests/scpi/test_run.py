"""Runs of a mock supply, scope and motor: what is measured, what ends a run, what is said of it."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire.scpi.bench_file import of_rig
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import LinkError, RigError
from motorid.rig import load_rig
from motorid.toml_file import packaged
from motorid.workflow.record import bursting
from tests.scpi.bench import MOTOR, Bench
from tests.scpi.rigs import mock, recorded, rig
from tests.six_parameters import fit


def notes(found: Capture) -> str:
    return " ".join(found.provenance["notes"])


@pytest.mark.slow
def test_a_recorded_run_identifies_the_motor(tmp_path: Path) -> None:
    bench, clock = mock()
    found = recorded(bench, clock, rig(tmp_path, drive_s=0.4), tmp_path / "run.h5")
    assert found.channels["current"].resolution == pytest.approx(10 * 20 / 65536)
    assert found.provenance["instruments"]["identities"]["recorder"] == "MOCK,SCOPE,2,1.0"
    estimate = fit([found])
    for name, truth in MOTOR.items():
        low, high = estimate.parameters[name].interval_95
        assert low <= truth <= high, name
    low, high = estimate.parameters["R"].interval_95
    assert (high - low) / MOTOR["R"] < 0.05


@pytest.mark.study  # a scanned run, in test_scan.py, shows as much
def test_a_polled_run_with_a_tacho_shows_all_but_the_inductance(tmp_path: Path) -> None:
    bench, clock = mock(reply_s=8e-3)  # 24 ms a row
    plain = "gain_uncertainty = 0.005\noffset_uncertainty = 0.005\n"
    more = f"""
[channels.current]
{plain}
[channels.terminal_voltage]
{plain}
[channels.speed]
query = "SPEED?"
{plain}
"""
    original = bench.supply
    bench.supply = lambda text: (  # type: ignore[method-assign]
        f"{bench.motor.speed:.2f}" if text == "SPEED?" else original(text)
    )
    one = rig(tmp_path, scope=False, more=more, rate_hz=50, levels="[[2, 4, 6]]", drive_s=0.7)
    estimate = fit([recorded(bench, clock, one, tmp_path / "run.h5")])
    assert estimate.parameters["L"].value is None
    for name in ("R", "K", "B", "J", "T0"):
        low, high = estimate.parameters[name].interval_95
        assert low <= MOTOR[name] <= high, name


@pytest.mark.slow
def test_protections_come_before_the_output_and_it_goes_off_again(tmp_path: Path) -> None:
    bench, clock = mock()
    recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")
    first = bench.heard.index("OUTP ON")
    for asked in ("VOLT:PROT?", "VOLT:PROT:STAT?", "CURR:PROT?", "CURR:PROT:STAT?", "CURR?"):
        assert asked in bench.heard[:first], asked
    sets = [i for i, text in enumerate(bench.heard) if " " in text]
    assert all(bench.heard[i + 1] == "SYST:ERR?" for i in sets)  # after each command
    last = len(bench.heard) - 1 - bench.heard[::-1].index("OUTP OFF")
    assert "OUTP?" in bench.heard[last:]
    assert not bench.on


@pytest.mark.slow
def test_constant_current_is_no_step_and_is_said(tmp_path: Path) -> None:
    bench, clock = mock(ohm=1.2)  # half of the nameplate's: it would draw 5 A of 4
    found = recorded(bench, clock, rig(tmp_path, levels="[[6]]"), tmp_path / "run.h5")
    assert "limited the current in step 1 of the program (constant current)" in notes(found)
    assert found.provenance["instruments"]["current_limited_steps"] == [1]


@pytest.mark.slow
def test_constant_current_is_seen_in_the_readings_of_a_supply_that_does_not_say(
    tmp_path: Path,
) -> None:
    dialect = packaged("rigs/instruments").joinpath("scpi.toml").read_text(encoding="utf-8")
    begin, end = dialect.index("[limiting]"), dialect.index("[measure]")
    (tmp_path / "mute.toml").write_text(dialect[:begin] + dialect[end:])
    bench, clock = mock(ohm=0.4)
    one = rig(tmp_path, more='dialect = "mute.toml"\n')
    found = recorded(bench, clock, one, tmp_path / "run.h5")
    assert "are at the current limit of 4 A below the voltage" in notes(found)


@pytest.mark.slow
def test_a_slow_supply_is_a_ramp_and_is_said(tmp_path: Path) -> None:
    bench, clock = mock(slew_v_s=30.0)
    found = recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")
    assert "a ramp, and no step" in notes(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('source = "CHAN2"', 'source = "CHAN2"\nscale = 0.1', "is the probe's factor in"),
        ('source = "CHAN2"', 'source = "CHAN2"\nscale = 10', "is the probe's factor in"),
        ("scale = 10.0", "scale = -10.0", "turn the probe"),
    ],
)
def test_a_wrong_factor_and_a_turned_probe_are_said(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    one = rig(tmp_path)
    file = tmp_path / "instruments.toml"
    file.write_text(file.read_text().replace(old, new))
    bench, clock = mock()
    assert said in notes(recorded(bench, clock, one, tmp_path / "run.h5"))


@pytest.mark.slow
def test_a_right_run_has_nothing_said_of_it(tmp_path: Path) -> None:
    assert notes(recorded(*mock(), rig(tmp_path), tmp_path / "run.h5")) == ""


@pytest.mark.slow
def test_a_recorder_with_too_little_memory_is_said(tmp_path: Path) -> None:
    bench, clock = mock(memory=500)
    found = recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")
    assert len(found) == 500
    assert "the recorder kept 0.0998 s" in notes(found)


def test_a_burst_is_refused(tmp_path: Path) -> None:
    bench, clock = mock()
    with pytest.raises(RigError, match="a burst is of a board"):
        recorded(bench, clock, bursting(rig(tmp_path)), tmp_path / "run.h5")


def test_a_supply_that_falls_silent_is_said_loudly_and_the_readings_stay(tmp_path: Path) -> None:
    bench, clock = mock(silent_after="STAT:QUES?")
    with pytest.raises(LinkError, match="MAY STILL BE ON: switch it off by hand") as said:
        recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")
    assert "samples are kept in" in str(said.value)
    found = store.load(tmp_path / "run.h5")
    assert found.end_reason == "link lost"
    assert len(found) > 2


@pytest.mark.slow
def test_an_output_that_does_not_switch_off_is_said(tmp_path: Path) -> None:
    bench, clock = mock()
    original = bench.supply

    def sticks(text: str) -> str | None:
        if text == "OUTP ON":
            bench.stuck_on = True
        return original(text)

    bench.supply = sticks  # type: ignore[method-assign]
    with pytest.raises(LinkError, match=r"told to 3 times \(it reads back on\)"):
        recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")


@pytest.mark.slow
def test_an_output_that_its_own_protection_opened_ends_the_run(tmp_path: Path) -> None:
    bench, clock = mock()
    original = bench.supply

    def trips(text: str) -> str | None:
        if text == "STAT:QUES?":
            bench.on = False
        return "1" if text == "CURR:PROT:TRIP?" and "OUTP ON" in bench.heard else original(text)

    bench.supply = trips  # type: ignore[method-assign]
    with pytest.raises(RigError, match=r"fault: over-current.*samples are kept"):
        recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5")
    assert store.load(tmp_path / "run.h5").end_reason == "fault: over-current"


@pytest.mark.slow
@pytest.mark.parametrize("scope", [True, False])
def test_ctrl_c_switches_off_and_keeps_what_was_read(tmp_path: Path, scope: bool) -> None:
    bench, clock = mock()

    def pressed(live: Any) -> None:
        if bench.on:
            os.kill(os.getpid(), signal.SIGINT)

    one = rig(tmp_path, scope=scope, rate_hz=5000 if scope else 20)
    with pytest.raises(KeyboardInterrupt, match="samples are kept"):
        recorded(bench, clock, one, tmp_path / "run.h5", progress=pressed)
    assert not bench.on
    assert store.load(tmp_path / "run.h5").end_reason == "interrupted"


def test_an_error_of_the_callers_own_switches_off_too(tmp_path: Path) -> None:
    bench, clock = mock()

    def breaks(live: Any) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        recorded(bench, clock, rig(tmp_path), tmp_path / "run.h5", progress=breaks)
    assert not bench.on
    assert bench.heard[-2:] == ["SYST:ERR?", "OUTP?"]


@pytest.mark.slow
def test_an_encoder_on_two_inputs_counts(tmp_path: Path) -> None:
    """The scope's third input as both lines would not turn: here are lines of their own."""
    bench, clock = mock()
    original = bench.words

    def lines() -> Any:
        if bench.source not in ("A", "B"):
            return original()
        turned = np.cumsum([row[2] for row in bench.rows]) * bench.period_s / (2 * np.pi) * 4
        place = turned - (0.0 if bench.source == "A" else 0.25)
        return np.where(place % 1.0 < 0.5, 50000, 33000).astype("<u2")

    bench.words = lines  # type: ignore[method-assign]
    one = rig(tmp_path)
    file = tmp_path / "instruments.toml"
    text = file.read_text()
    file.write_text(
        text[: text.index("[channels.speed]")] + '[channels.position]\nsources = ["A", "B"]\n'
    )
    path = tmp_path / "rig.toml"
    path.write_text(path.read_text().replace("[wiring]", "[wiring]\ncounts_per_turn = 16"))
    found = recorded(bench, clock, load_rig(str(path)), tmp_path / "run.h5")
    assert one.wiring.counts_per_turn == 0.0  # none is asked for where there is no encoder
    turns = abs(found.channels["position"].values[-1]) / (2 * np.pi)
    expected = sum(row[2] for row in bench.rows) * bench.period_s / (2 * np.pi)
    assert turns == pytest.approx(expected, abs=0.05)


REFUSED = {
    "a duty": ("levels_v = [[3, 6]]", "levels_duty = [[0.3]]", "has volts: write drive_volts"),
    "reversal": ("[[3, 6]]", "[[3, -3]]", "gives one sign alone"),
    "too high": ("[[3, 6]]", "[[3, 9.5]]", "asks for 9.5 V, and the supply has 9 V"),
    "too much": ("resistance_ohm = 2.6", "resistance_ohm = 1", "limits.current_a is 4"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_program_that_cannot_be_run_is_refused_before_anything_is_opened(
    case: str, tmp_path: Path
) -> None:
    old, new, said = REFUSED[case]
    rig(tmp_path)
    path = tmp_path / "rig.toml"
    path.write_text(path.read_text().replace(old, new))
    bench, clock = mock()
    with pytest.raises(RigError, match=said):
        recorded(bench, clock, load_rig(str(path)), tmp_path / "run.h5")
    assert not bench.heard


def test_an_encoder_without_its_counts_is_refused_before_a_run(tmp_path: Path) -> None:
    one = rig(tmp_path)
    file = tmp_path / "instruments.toml"
    old = '[channels.speed]\nsource = "CHAN3"\n'
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, '[channels.position]\nsources = ["A", "B"]\n'))
    bench, clock = mock()
    with pytest.raises(RigError, match="counts_per_turn is missing"):
        recorded(bench, clock, one, tmp_path / "run.h5")
    assert not bench.heard


@pytest.mark.slow
def test_a_brake_needs_an_output_that_sinks(tmp_path: Path) -> None:
    one = rig(tmp_path, more="quadrants = 2\n")
    path = tmp_path / "rig.toml"
    begin = one.text[: one.text.index("[program]")]
    path.write_text(
        begin + '[[program.steps]]\nkind = "drive_volts"\nvolts = 3\nduration_s = 0.1\n'
        '[[program.steps]]\nkind = "brake"\nduration_s = 0.1\n'
    )
    bench, clock = mock()
    recorded(bench, clock, load_rig(str(path)), tmp_path / "run.h5")
    file = tmp_path / "instruments.toml"
    file.write_text(file.read_text().replace("quadrants = 2", ""))
    with pytest.raises(RigError, match="an output that only sources cannot"):
        recorded(bench, clock, load_rig(str(path)), tmp_path / "again.h5")


WRONG = {
    "key": ('resource = "supply"', 'resorce = "supply"', "the nearest is supply.resource"),
    "none": ('resource = "supply"', "", "supply.resource is missing"),
    "dialect": ('dialect = "scope.toml"', 'dialect = "rigol"', "known: keithley-2400"),
    "kind": ('dialect = "scope.toml"', 'dialect = "scpi"', "dialect of a supply"),
    "source": ('source = "CHAN1"', "", "name the recorder's input"),
    "channel": ("[channels.current]", "[channels.amps]", "unknown key channels.amps"),
    "missing": ("[channels.terminal_voltage]", "[channels.position]", "sources = "),
    "scale": ("scale = 10.0", "scale = 0", "nothing would be measured"),
    "filter": ("scale = 10.0", 'filter = "20"', "is it Hz or seconds"),
    "delay": ("scale = 10.0", 'delay = "5 parsec"', "channels.current: delay current"),
    "toml": ("[supply]", "[supply", "not valid TOML"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_of_instruments_is_named_in_a_sentence(case: str, tmp_path: Path) -> None:
    old, new, said = WRONG[case]
    one = rig(tmp_path)
    file = tmp_path / "instruments.toml"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))
    with pytest.raises(RigError, match=said):
        of_rig(one)


@pytest.mark.slow
def test_the_bench_runs_twice_and_a_second_run_is_as_the_first(tmp_path: Path) -> None:
    """No state of one run is left in the next."""
    both = [
        recorded(*mock(), rig(tmp_path), tmp_path / f"{name}.h5").channels["current"].raw
        for name in ("a", "b")
    ]
    np.testing.assert_array_equal(*both)


@pytest.mark.slow
def test_the_mock_motor_follows_its_own_constants() -> None:
    """The no-load speed of the mock, by hand: else the intervals above would prove nothing."""
    bench = Bench(lambda: 2.0)
    bench.settings |= {"VOLT": 6.0, "CURR": 10.0}
    bench.on, bench.done_s = True, 0.0
    bench.catch_up()
    m = MOTOR
    speed = (m["K"] * 6.0 - m["R"] * m["T0"]) / (m["K"] ** 2 + m["R"] * m["B"])
    assert bench.motor.speed == pytest.approx(speed, rel=1e-3)
