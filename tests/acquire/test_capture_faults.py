"""Faults of rig, board and cable: found before the motor turns, or said with what was kept."""

from __future__ import annotations

import os
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.coverage import runs as drawn
from bench.coverage.rigs import draw_bench
from motorid.acquire import record
from motorid.acquire.journal import Kind, journal_path, parse_journal
from motorid.capture import store
from motorid.errors import LinkError, MotoridError, RigError
from motorid.program import Program
from motorid.wire.codec import Reply, decode
from motorid.wire.framing import Decoder, Frame
from tests.acquire.rigs import SAMPLES, SHORT, run, sim_rig

LONG = Program(SHORT.steps * 4)

BEFORE = [  # seen before the run: nothing is left behind
    ("silence", LinkError, "nothing answers: is the board powered"),
    ("deaf", LinkError, "a motorid board speaks there but does not answer"),
    ("unplug", LinkError, "unplugged"),
    ("text", LinkError, "not motorid's protocol"),
    ("garbage", LinkError, "not motorid's protocol"),
    ("major", LinkError, "the board speaks protocol 2.3"),
    ("supply:0", RigError, "is it connected and switched on"),
    ("burst&supply=12", RigError, "above limits.supply_max_v"),
    ("stall", RigError, "free the shaft"),
    ("encoder_dead", RigError, "check the encoder's wires"),
    ("encoder_reversed", RigError, "set wiring.encoder_reversed = true"),
    ("current_dead", RigError, "it is dead or not in the motor's line"),
    ("current_reversed", RigError, "the sensor is reversed"),
    ("current_saturated", RigError, "an end of its range"),
    ("voltage_dead", RigError, "check the bridge's enable"),
    ("adc_stuck", RigError, "is it connected and switched on"),
]


@pytest.mark.parametrize(("fault", "kind", "says"), BEFORE, ids=[row[0] for row in BEFORE])
def test_a_bad_rig_is_found_before_it_turns(
    fault: str, kind: type[MotoridError], says: str, tmp_path: Path
) -> None:
    with pytest.raises(kind) as caught:
        run(f"fault={fault}", tmp_path / "run.h5")
    assert says in str(caught.value)
    assert caught.value.exit_code == 3
    assert list(tmp_path.iterdir()) == []


DURING = [  # in mid-run: what came before is kept
    ("silence@{at}", LinkError, "went silent", "link lost"),
    ("unplug@{at}", LinkError, "unplugged", "link lost"),
    ("deaf@{at}", RigError, "host_silence", "fault: host_silence"),
    ("reset@{at}", LinkError, "was reset in mid-run (external)", "reset: external"),
    ("brownout@{at}", LinkError, "was reset in mid-run (brown_out)", "reset: brown_out"),
    ("supply@{at}", RigError, "tripped (supply_low)", "fault: supply_low"),
]


@pytest.fixture(scope="module")
def run_start_s(tmp_path_factory: pytest.TempPathFactory) -> float:
    """Seconds from the check pulse, from which faults count, to the run proper."""
    rig = sim_rig(program=LONG)
    heard = bytearray()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("motorid.acquire.journal_writer.JournalWriter.discard", lambda self: None)
        path = record.capture(rig, rig.program, tmp_path_factory.mktemp("probe") / "probe.h5")
    for entry in parse_journal(journal_path(path).read_bytes()).records:
        heard += entry.data if entry.kind is Kind.RECEIVED else b""
    messages = [decode(f.payload) for f in Decoder().feed(bytes(heard)) if isinstance(f, Frame)]
    starts = [
        m.fields["start_tick"] for m in messages if isinstance(m, Reply) and m.name == "start"
    ]
    return float(starts[-1] - starts[0]) / 16e6


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
@pytest.mark.parametrize(("fault", "kind", "says", "ends"), DURING, ids=[r[3] for r in DURING])
def test_what_was_measured_before_a_fault_is_kept(
    fault: str,
    kind: type[MotoridError],
    says: str,
    ends: str,
    tmp_path: Path,
    run_start_s: float,
) -> None:
    options = f"fault={fault.format(at=round(run_start_s + 0.05, 3))}"
    rig = sim_rig(options, program=LONG)
    with pytest.raises(kind) as caught:
        record.capture(rig, rig.program, tmp_path / "run.h5")
    capture = store.load(tmp_path / "run.h5")
    assert says in str(caught.value)
    assert f"{len(capture)} samples are kept in" in str(caught.value)
    assert capture.end_reason == ends
    assert 0 < len(capture) < 4 * SAMPLES
    assert capture.time_s[-1] > 0.04  # all that came before the fault, but the last block
    assert ends in record.missing(capture)


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["flip:5e-4", "drop:5e-4", "insert:5e-4", "double:5e-4"])
def test_a_bad_cable_loses_blocks_and_nothing_else(fault: str, tmp_path: Path) -> None:
    """The same seed without the fault sent the same samples: each one kept is in its place."""
    clean = store.load(run("", tmp_path / "clean.h5"))
    spoilt = store.load(run(f"fault={fault}", tmp_path / "spoilt.h5"))
    assert spoilt.end_reason == "completed"
    assert sum(gap.samples for gap in spoilt.gaps) == SAMPLES - len(spoilt) > 0
    # a repeated command may start the run later, so sample n is told by its place, not its tick
    origin = spoilt.phases[0].tick if spoilt.phases[0].index == 0 else spoilt.ticks[0]
    places = (spoilt.ticks - origin) // 1600
    assert np.all(np.diff(places) >= 1)
    assert places[-1] < SAMPLES
    for gap in spoilt.gaps:
        before = places[gap.index - 1] if gap.index else -1
        after = places[gap.index] if gap.index < len(places) else SAMPLES
        assert after - before - 1 >= gap.samples
    # positions do not depend on the noise of a channel, only on the motor's start angle
    moved = spoilt.channels["position"].raw[-1] - spoilt.channels["position"].raw[0]
    whole = clean.channels["position"].raw[-1] - clean.channels["position"].raw[0]
    assert abs(moved - whole) < 0.01 * whole


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["split", "burst"])
def test_odd_deliveries_change_nothing(fault: str, tmp_path: Path) -> None:
    capture = store.load(run(f"fault={fault}", tmp_path / "run.h5"))
    assert (len(capture), capture.gaps) == (SAMPLES, ())


@pytest.mark.slow
def test_a_slow_link_drops_and_says_so(tmp_path: Path) -> None:
    capture = store.load(run("baud=250000&buffer=256", tmp_path / "run.h5"))
    assert capture.end_reason == "completed"
    assert sum(gap.samples for gap in capture.gaps) == SAMPLES - len(capture) > 0
    assert all("dropped by the board" in gap.reason for gap in capture.gaps)


@pytest.mark.slow
def test_over_current_trips_and_is_said(tmp_path: Path) -> None:
    """A nameplate that lies high about R: the firmware's trip is what saves the motor."""
    rig = sim_rig()
    rig = replace(
        rig,
        nameplate=replace(rig.nameplate, resistance_ohm=6.0),
        limits=replace(rig.limits, current_a=1.5),
    )
    with pytest.raises(RigError, match=r"tripped \(over_current\).*samples are kept"):
        record.capture(rig, rig.program, tmp_path / "run.h5")
    assert store.load(tmp_path / "run.h5").end_reason == "fault: over_current"


@pytest.mark.slow
def test_no_thread_or_descriptor_is_left(tmp_path: Path) -> None:
    run("", tmp_path / "first.h5")
    threads = threading.active_count()
    for number, fault in enumerate(["", "fault=unplug@1.2", "fault=silence", "fault=supply:0"]):
        try:
            run(fault, tmp_path / f"{number}.h5")
        except MotoridError:
            assert fault  # only with a fault
    assert threading.active_count() == threads
    if Path("/proc/self/fd").is_dir():
        names = [os.readlink(fd) for fd in Path("/proc/self/fd").iterdir() if fd.is_symlink()]
        assert not [name for name in names if str(tmp_path) in name]


OFF_PART = "pwm=8000&voltage_aperture=125e-6&aperture=0&delay=0&phase=0.95"


@pytest.mark.slow
def test_a_current_read_in_the_off_part_of_a_pwm_period_is_judged_while_braking(
    tmp_path: Path,
) -> None:
    """Ripple turns it round there: its mean over the pulse is negative, and the sensor is right."""
    check = store.load(run(OFF_PART, tmp_path / "run.h5")).provenance["check"]
    assert check["current_a"] < 0 < check["counts"]
    assert check["resistance_bound_ohm"] is None
    for fault, says in (("dead", "dead or not in the motor's line"), ("reversed", "is reversed")):
        with pytest.raises(RigError, match=says):
            run(f"{OFF_PART}&fault=current_{fault}", tmp_path / f"{fault}.h5")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [907, 63], ids=["stands", "swings"])
def test_no_sound_sensor_is_called_reversed_by_a_brake(seed: int, tmp_path: Path) -> None:
    """A motor that cogs moves in the first pulse and stands in the next, whose current is positive
    until L/R has ended it; another's braking current swings through zero.
    """
    runs = drawn.record(draw_bench(seed), tmp_path)
    assert [len(capture.phases) for capture in runs.captures] == [6, 6, 6]
    assert runs.captures[0].provenance["check"]["counts"] > 0
