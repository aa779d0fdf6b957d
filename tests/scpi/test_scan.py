"""A scanning DAQ in place of a scope: when each input was read is a fact of the capture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.scpi.bench_file import of_rig
from motorid.acquire.scpi.dialect import load_dialect, parse
from motorid.acquire.scpi.run import capture_all
from motorid.acquire.scpi.scan import scans_of
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import LinkError, RigError
from motorid.rig import Rig
from tests.scpi.bench import MOTOR, SHUNT_V_A, TACHO_V_RAD_S
from tests.scpi.daq import PACE_S, STAMP_S, Daq
from tests.scpi.rigs import MockLink, mock, rig
from tests.scpi.sim import SCANNER, SUPPLY, definition
from tests.six_parameters import fit

PLAIN = 'gain_uncertainty = 0.005\noffset_uncertainty = 0.005\nfilter = "0"\naperture = "0"'
SCANNED = f"""
[recorder]
resource = "{{at}}"
dialect = "keysight-34970a"
lead_s = 0.05
[channels.current]
source = "101"
scale = {1 / SHUNT_V_A}
{PLAIN}
[channels.terminal_voltage]
source = "102"
{PLAIN}
[channels.speed]
source = "103"
scale = {1 / TACHO_V_RAD_S}
{PLAIN}
"""
ELEMENTS = ("reading", "time", "channel")
INPUTS = ("101", "102")


def rig_of(folder: Path, text: str = SCANNED, at: str = "daq", **options: object) -> Rig:
    settings = {"rate_hz": 80, "levels": "[[2, 4, 6]]", "drive_s": 0.7, "scope": False}
    return rig(folder, more=text.format(at=at), **{**settings, **options})  # type: ignore[arg-type]


def scanned(folder: Path, text: str = SCANNED, lost: int = -1) -> tuple[Capture, Daq]:
    """A run of the mock bench, and the DAQ that read it."""
    bench, clock = mock()
    daq = Daq(bench, lost)

    def open_link(backend: str, resource: str, timeout_s: float, name: str) -> MockLink:
        return MockLink(bench.supply if resource == "supply" else daq.answer)

    one, path = rig_of(folder, text), folder / "run.h5"
    capture_all(one, one.program, [path], open_link=open_link, clock=clock)
    return store.load(path), daq


@pytest.mark.slow
def test_each_input_has_the_delay_that_it_was_read_with(tmp_path: Path) -> None:
    found, daq = scanned(tmp_path)
    assert daq.heard.index("ROUT:SCAN (@101,102,103)") < daq.heard.index("INIT")
    assert found.provenance["instruments"]["identities"]["recorder"] == "MOCK,DAQ,4,1.0"
    assert found.period_s == pytest.approx(1 / 80, rel=1e-3)  # stamps have whole milliseconds
    for name, before_s in (("current", 2 * PACE_S), ("terminal_voltage", PACE_S), ("speed", 0.0)):
        channel = found.channels[name]
        assert abs(channel.delay_s - before_s) <= STAMP_S / 2, name
        assert "delay" not in channel.undeclared
        assert PACE_S / 12**0.5 < channel.delay_uncertainty_s < PACE_S
    (note,) = found.provenance["notes"]
    assert "a scan of 0.0125 s reads its inputs one after another, the first 0.008 s" in note


@pytest.mark.slow
def test_a_scanned_run_identifies_all_but_the_inductance(tmp_path: Path) -> None:
    estimate = fit([scanned(tmp_path)[0]])
    for name in ("R", "K", "B", "J", "T0"):
        low, high = estimate.parameters[name].interval_95
        assert low <= MOTOR[name] <= high, name
    assert estimate.parameters["L"].value is None


@pytest.mark.slow
def test_a_sensor_s_own_delay_comes_on_top(tmp_path: Path) -> None:
    late = '[channels.current]\ndelay = "5ms"\ndelay_uncertainty = "3ms"\n'
    found, _ = scanned(tmp_path, SCANNED.replace("[channels.current]\n", late))
    current, voltage = found.channels["current"], found.channels["terminal_voltage"]
    assert current.delay_s == pytest.approx(5e-3 + 2 * PACE_S, abs=STAMP_S / 2)
    assert current.delay_uncertainty_s == pytest.approx(
        np.hypot(3e-3, voltage.delay_uncertainty_s), rel=1e-6
    )


@pytest.mark.slow
def test_a_reading_that_is_missing_is_no_scan(tmp_path: Path) -> None:
    """Else all that follows would belong to the scan before."""
    with pytest.raises(LinkError, match="are some missing"):
        scanned(tmp_path, lost=100)


def test_the_order_of_an_answer_is_its_channels(tmp_path: Path) -> None:
    """By number, whatever the dialect's list; a scan that was cut short is left out."""
    values = [5.0, 0.0, 102, 1.0, 0.25, 101, 6.0, 1.0, 102, 2.0, 1.25, 101, 7.0, 2.0, 102]
    found = scans_of(np.array(values), ELEMENTS, INPUTS)
    np.testing.assert_array_equal(found.readings["101"], [1.0, 2.0])
    np.testing.assert_array_equal(found.readings["102"], [5.0, 6.0])
    assert found.late_s == {"101": 0.0, "102": 0.25}
    np.testing.assert_array_equal(found.time_s, [0.0, 1.0])


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ([1.0, 0.0], "2 numbers, and a reading has 3"),
        ([1.0, 0.0, 101.0], "nothing on input 102: is it in its scan list"),
        ([1.0, np.nan, 101.0, 1.0, 0.1, 102.0, 1.0, 1.0, 101.0, 1.0, 1.1, 102.0], "no scans"),
        ([], "nothing on input 101"),
    ],
)
def test_an_answer_that_is_no_scan_is_said(values: list[float], said: str) -> None:
    with pytest.raises(LinkError, match=said):
        scans_of(np.array(values), ELEMENTS, INPUTS)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('source = "102"', 'source = "CHAN2"', "a scan's input is the number of a channel"),
        ('[channels.speed]\nsource = "103"', '[channels.position]\nsources = ["1", "2"]', "edges"),
    ],
)
def test_what_no_scan_can_read_is_refused(old: str, new: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(RigError, match=said):
        of_rig(rig_of(tmp_path, SCANNED.replace(old, new)))


def test_a_dialect_s_elements_hold_reading_time_and_channel() -> None:
    text = 'kind = "recorder"\nacquire.start = ["INIT"]\n[scan]\ndata = "R?"\nelements = '
    parse(text + '["other", "time", "reading", "channel"]', "mine.toml")
    with pytest.raises(RigError, match=r"mine\.toml: scan\.elements must hold 'time' once"):
        parse(text + '["reading", "channel"]', "mine.toml")
    assert "scan" in load_dialect("keithley-2700", Path(), "recorder").tables


@pytest.mark.slow
@pytest.mark.parametrize("block", [False, True])
def test_a_scanner_of_pyvisa_sim(block: bool, tmp_path: Path) -> None:
    rows = [
        f"{value:+.5E},{0.02 * scan + late:.3f},{channel}"
        for scan in range(20)
        for value, late, channel in ((0.125, 0.0, 101), (3.001, 0.004, 102), (0.25, 0.008, 103))
    ]
    answer = ",".join(rows)
    dialect = load_dialect("keysight-34970a", tmp_path, "recorder")
    start = [line for line in dialect.get("acquire", "start") if "TRIG:" not in line]
    heard = {line.format(sources="101,102,103"): None for line in [*start, "TRIG:SOUR TIM"]}
    data = f"#{len(str(len(answer)))}{len(answer)}{answer}" if block else answer
    top = definition(tmp_path, scanner={**heard, "STAT:OPER:COND?": "0", "FETC?": data})
    one = rig_of(tmp_path, at=SCANNER, top=top, supply=SUPPLY, levels="[[3]]", drive_s=0.06)
    found = store.load(capture_all(one, one.program, [tmp_path / "run.h5"])[0])
    assert len(found) == 20
    assert found.channels["current"].values == pytest.approx(1.25)
    assert found.channels["terminal_voltage"].values == pytest.approx(3.001)
    assert found.channels["current"].delay_s == pytest.approx(0.008)
    assert found.period_s == pytest.approx(0.02)
