"""Captures from the simulated board, whole and under faults, through the real client."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import leftover, record
from motorid.acquire.journal import Kind, encode_record, journal_path, parse_journal
from motorid.acquire.live import Live
from motorid.capture import store
from motorid.errors import DataError, LinkError, MotoridError, RigError, UsageError
from motorid.program import Program
from motorid.rig import Nameplate
from motorid.wire.codec import Reply, decode
from motorid.wire.framing import Decoder, Frame
from tests.acquire.rigs import SHORT, sim_rig

SAMPLES = 3800  # of SHORT at 10 kHz
LONG = Program(SHORT.steps * 4)


def run(options: str, path: Path, **more: object) -> Path:
    rig = sim_rig(options)
    return record.capture(rig, rig.program, path, **more)  # type: ignore[arg-type]


@pytest.fixture
def keep_journal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Journals stay after their capture is saved, and recovery need not wait to see them rest."""
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    monkeypatch.setattr("motorid.acquire.journal.JournalWriter.discard", lambda self: None)


def test_a_capture_is_whole_and_says_what_it_is(tmp_path: Path) -> None:
    rig = sim_rig()
    path = record.capture(rig, rig.program, tmp_path / "run.h5", serial="M17", note="first")
    capture = store.load(path)
    assert list(tmp_path.iterdir()) == [path]
    assert len(capture) == SAMPLES
    assert capture.gaps == ()
    assert capture.end_reason == "completed"
    assert [phase.index for phase in capture.phases] == [0, 1, 2, 3, 4]
    steps = np.diff([phase.tick for phase in capture.phases]) / capture.clock_hz
    np.testing.assert_allclose(steps, [s.duration_s for s in SHORT.steps[:-1]])
    assert capture.program == rig.program
    assert capture.wiring.pwm_hz == 20_000
    assert capture.provenance["serial"] == "M17"
    assert capture.provenance["rig"] == rig.text
    assert capture.provenance["identity"]["board"] == "motorid-sim"
    current = capture.channels["current"]
    assert (current.kind, current.unit) == ("mean", "A")
    assert current.aperture_s == pytest.approx(50e-6)


def test_the_readings_are_the_motor_s(tmp_path: Path) -> None:
    """Ohm and Kirchhoff on the raw means: V - R i is the back-EMF K w at the top level."""
    capture = store.load(run("seed=3", tmp_path / "run.h5"))
    end = capture.phases[4].tick
    top = (capture.ticks > end - 160_000) & (capture.ticks <= end)  # the last 10 ms at 6 V
    volts, amps = (capture.channels[n].values[top].mean() for n in ("terminal_voltage", "current"))
    angle = capture.channels["position"].values[top]
    speed = (angle[-1] - angle[0]) / (capture.time_s[top][-1] - capture.time_s[top][0])
    # switches, dead time and the supply's sag take 5 % of the 6 V on their way to the terminals
    assert volts == pytest.approx(6.0, rel=0.06)
    assert volts - 2.6 * amps == pytest.approx(7.68e-3 * speed, rel=0.02)
    rest = slice(10, 150)
    noise = capture.channels["current"].noise
    assert abs(capture.channels["current"].values[rest].mean()) < noise


def test_progress_is_told(tmp_path: Path) -> None:
    seen: list[Live] = []
    run("", tmp_path / "run.h5", progress=seen.append)
    assert seen[0].done_s == 0
    assert seen[0].total_s == pytest.approx(0.38)


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


BEFORE = [  # seen before the run: nothing is left behind
    ("silence", LinkError, "nothing answers: is the board powered"),
    ("deaf", LinkError, "a motorid board speaks there but does not answer"),
    ("unplug", LinkError, "unplugged"),
    ("text", LinkError, "not motorid's protocol"),
    ("garbage", LinkError, "not motorid's protocol"),
    ("major", LinkError, "the board speaks protocol 2.0"),
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


def run_start_s(tmp_path: Path) -> float:
    """Seconds from the check pulse, from which faults count, to the run proper."""
    rig = sim_rig(program=LONG)
    path = record.capture(rig, rig.program, tmp_path / "probe.h5")
    journal = parse_journal(journal_path(path).read_bytes())
    received = b"".join(r.data for r in journal.records if r.kind is Kind.RECEIVED)
    messages = [decode(f.payload) for f in Decoder().feed(received) if isinstance(f, Frame)]
    starts = [
        m.fields["start_tick"] for m in messages if isinstance(m, Reply) and m.name == "start"
    ]
    for file in tmp_path.iterdir():
        file.unlink()
    return float(starts[-1] - starts[0]) / 16e6


@pytest.mark.usefixtures("keep_journal")
@pytest.mark.parametrize(("fault", "kind", "says", "ends"), DURING, ids=[r[3] for r in DURING])
def test_what_was_measured_before_a_fault_is_kept(
    fault: str, kind: type[MotoridError], says: str, ends: str, tmp_path: Path
) -> None:
    options = f"fault={fault.format(at=round(run_start_s(tmp_path) + 0.05, 3))}"
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


@pytest.mark.parametrize("fault", ["split", "burst"])
def test_odd_deliveries_change_nothing(fault: str, tmp_path: Path) -> None:
    capture = store.load(run(f"fault={fault}", tmp_path / "run.h5"))
    assert (len(capture), capture.gaps) == (SAMPLES, ())


def test_ticks_go_on_past_32_bits(tmp_path: Path) -> None:
    plain = store.load(run("", tmp_path / "plain.h5"))
    middle = int(plain.ticks[len(plain) // 2])
    wrapped = store.load(run(f"first_tick={(1 << 32) - middle}", tmp_path / "wrapped.h5"))
    assert wrapped.ticks[-1] > 1 << 32
    np.testing.assert_array_equal(wrapped.ticks - wrapped.ticks[0], plain.ticks - plain.ticks[0])
    first = wrapped.phases[0].tick
    assert [phase.tick - first for phase in wrapped.phases] == [
        phase.tick - plain.phases[0].tick for phase in plain.phases
    ]


def test_a_slow_link_drops_and_says_so(tmp_path: Path) -> None:
    capture = store.load(run("baud=250000&buffer=256", tmp_path / "run.h5"))
    assert capture.end_reason == "completed"
    assert sum(gap.samples for gap in capture.gaps) == SAMPLES - len(capture) > 0
    assert all("dropped by the board" in gap.reason for gap in capture.gaps)


def test_a_burst_is_sent_afterwards(tmp_path: Path) -> None:
    rig = sim_rig("buffer=4000&baud=115200")
    rig = replace(rig, sampling=replace(rig.sampling, mode="burst"))
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert (len(capture), capture.gaps) == (SAMPLES, ())
    small = replace(rig, port=rig.port.replace("buffer=4000", "buffer=2000"))
    with pytest.raises(RigError, match="the board keeps 2000 in burst mode"):
        record.capture(small, small.program, tmp_path / "small.h5")


def test_an_unknown_motor_is_judged_by_the_pulse(tmp_path: Path) -> None:
    rig = replace(sim_rig(), nameplate=Nameplate(voltage_v=6.0))
    capture = store.load(record.capture(rig, SHORT, tmp_path / "run.h5"))
    assert 1.5 < capture.provenance["check"]["resistance_bound_ohm"] < 2.6
    weak = replace(rig, limits=replace(rig.limits, current_a=1.5))
    with pytest.raises(RigError, match=r"limits.current_a is 1\.5"):
        record.capture(weak, SHORT, tmp_path / "weak.h5")
    assert not (tmp_path / "weak.h5").exists()


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


def test_existing_files_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_text("precious")
    with pytest.raises(UsageError, match="exists already"):
        run("", path)
    assert path.read_text() == "precious"
    run("", path, force=True)
    assert len(store.load(path)) == SAMPLES


def test_two_captures_to_one_path_cannot_clobber_each_other(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    second: list[BaseException] = []

    def intrude(live: Live) -> None:
        if not second:
            with pytest.raises(UsageError, match="is still being written") as caught:
                run("", path, force=True)
            second.append(caught.value)

    run("", path, progress=intrude)
    assert second
    assert len(store.load(path)) == SAMPLES


def test_repeats_share_one_opening(tmp_path: Path) -> None:
    rig = sim_rig()
    paths = [tmp_path / f"run-{n}.h5" for n in (1, 2, 3)]
    record.capture_all(rig, rig.program, paths)
    captures = [store.load(path) for path in paths]
    assert [len(capture) for capture in captures] == [SAMPLES] * 3
    assert captures[0].ticks[-1] < captures[1].ticks[0] < captures[2].ticks[0]  # one power-on
    raws = [capture.channels["current"].raw for capture in captures]
    assert not np.array_equal(raws[0], raws[1])


@pytest.mark.usefixtures("keep_journal")
def test_a_replay_gives_the_same_file(tmp_path: Path) -> None:
    path = run("seed=5&fault=flip:2e-4", tmp_path / "live.h5")
    rig = replace(sim_rig(), port=f"replay://{journal_path(path)}")
    again = record.capture(rig, rig.program, tmp_path / "again.h5")
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.usefixtures("keep_journal")
def test_recovery_gives_the_same_file(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    live = path.read_bytes()
    path.unlink()
    assert record.recover(journal_path(path)) == path
    assert path.read_bytes() == live
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.usefixtures("keep_journal")
def test_a_torn_journal_gives_what_it_holds(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    whole = store.load(path)
    data = journal_path(path).read_bytes()
    for share in (0.6, 0.8, 0.99):
        target = tmp_path / f"{share}.h5"
        journal_path(target).write_bytes(data[: int(share * len(data))])
        capture = store.load(record.recover(target))
        assert capture.end_reason == "interrupted"
        assert "ended early" in record.missing(capture)
        n = len(capture)
        assert 0 < n < SAMPLES
        for name, channel in capture.channels.items():
            np.testing.assert_array_equal(channel.raw, whole.channels[name].raw[:n])


@pytest.mark.usefixtures("keep_journal")
def test_a_journal_without_a_sample_says_so(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    found = parse_journal(journal_path(path).read_bytes())
    early = tmp_path / "early.h5.journal"
    whole = journal_path(path).read_bytes()
    head = whole[: whole.index(b'"measure"') - 20]
    early.write_bytes(head)
    with pytest.raises(DataError, match="not one sample"):
        record.recover(early)
    assert any(r.kind is Kind.MARK and "measure" in r.json for r in found.records)
    assert not (tmp_path / "early.h5").exists()


@pytest.mark.usefixtures("keep_journal")
def test_a_hostile_journal_is_one_sentence(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    found = parse_journal(journal_path(path).read_bytes())
    tail = b"".join(encode_record(r.kind, r.time_s, r.data) for r in found.records)
    for number, header in enumerate([b"{}", b'{"program": 3}', b'{"wiring": {"x": 1}}']):
        bad = tmp_path / f"bad{number}.h5.journal"
        bad.write_bytes(b"motorid journal 1\n" + encode_record(Kind.HEADER, 0, header) + tail)
        with pytest.raises(DataError) as caught:
            record.recover(bad)
        assert "\n" not in str(caught.value)


def test_a_full_disk_stops_the_motor_and_keeps_what_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The journal's disk fills in mid-run; room is made; the journal holds the beginning."""
    full = threading.Event()
    fsync = os.fsync

    def sync(handle: int) -> None:
        if full.is_set():
            raise OSError(28, "No space left on device")
        fsync(handle)

    monkeypatch.setattr("motorid.acquire.journal.os.fsync", sync)
    monkeypatch.setattr("motorid.acquire.journal.SYNC_S", 0.0)
    rig = sim_rig()

    def fill(live: Live) -> None:
        full.set()
        time.sleep(0.2)

    with pytest.raises(DataError, match=r"No space left.*the motor was stopped"):
        record.capture(rig, rig.program, tmp_path / "run.h5", progress=fill)
    assert not (tmp_path / "run.h5").exists()
    full.clear()
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    capture = store.load(record.recover(tmp_path / "run.h5"))
    assert 0 < len(capture) < SAMPLES


def test_no_room_for_the_file_keeps_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    def no_name(sibling: Path, path: Path) -> None:
        full(0)

    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    with monkeypatch.context() as patch:
        patch.setattr("motorid.capture.whole.os.replace", no_name)
        patch.setattr("motorid.capture.whole.os.link", no_name)
        patch.setattr("motorid.capture.whole.os.rename", no_name)
        with pytest.raises(DataError, match=r"cannot be written.*motorid recover"):
            run("", tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == [tmp_path / "run.h5.journal"]
    assert len(store.load(record.recover(tmp_path / "run.h5"))) == SAMPLES


CHILD = """
import sys
from pathlib import Path
from motorid.acquire import leftover, record
from motorid.program import StepKind, climbs
from tests.acquire.rigs import sim_rig
def on(live): print("on", flush=True)

program = climbs([[3.0, 6.0]], kind=StepKind.DRIVE_VOLTS, drive_s=4.0, coast_s=[0.5], rest_s=0.02)
rig = sim_rig(program=program, speed="realtime")
try:
    record.capture(rig, rig.program, Path(sys.argv[1]), progress=on)
except KeyboardInterrupt as stopped:
    print(stopped, file=sys.stderr)
    sys.exit(130)
"""


def capture_until(path: Path, act: Callable[[subprocess.Popen[str]], None]) -> tuple[int, str]:
    """A capture in real time in a child, and what is done to it half a second into the run."""
    root = Path(__file__).resolve().parents[2]
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(path)],
        cwd=root,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "on\n", child.stderr.read() if child.stderr else ""
    time.sleep(0.8)
    act(child)
    _, said = child.communicate(timeout=20)
    return child.returncode, said


@pytest.mark.slow
def test_kill_9_loses_nothing_that_was_read(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    code, _ = capture_until(path, lambda child: child.kill())
    assert code != 0
    assert list(tmp_path.iterdir()) == [journal_path(path)]
    capture = store.load(record.recover(path))
    assert capture.end_reason == "interrupted"
    assert capture.gaps == ()
    assert capture.time_s[-1] > 0.6  # 0.8 s ran; 100 ms may be unwritten, and the pipe lags
    assert "ended early" in record.missing(capture)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to one child")
def test_ctrl_c_stops_gently_and_keeps_the_run(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    code, said = capture_until(path, lambda child: child.send_signal(signal.SIGINT))
    capture = store.load(path)
    assert code == 130
    assert f"{len(capture)} samples are kept in" in said
    assert capture.end_reason == "interrupted"
    assert capture.provenance["link"]["done"]["reason"] == 1  # the board's own word: stopped
    assert capture.gaps == ()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to one child")
def test_ctrl_c_twice_quits_at_once_and_keeps_the_journal(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"

    def twice(child: subprocess.Popen[str]) -> None:
        child.send_signal(signal.SIGSTOP)  # so that both arrive before the first is served
        child.send_signal(signal.SIGINT)
        child.send_signal(signal.SIGCONT)
        child.send_signal(signal.SIGINT)

    code, said = capture_until(path, twice)
    assert code == 130
    kept = path if path.exists() else record.recover(path)  # the first stop may win the race
    assert len(store.load(kept)) > 0
    assert "kept in" in said or "motorid recover" in said


@pytest.mark.usefixtures("keep_journal")
def test_a_torn_journal_replays_as_it_recovers(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    data = journal_path(path).read_bytes()
    torn = tmp_path / "torn.h5"
    journal_path(torn).write_bytes(data[: 3 * len(data) // 4])
    rig = replace(sim_rig(), port=f"replay://{journal_path(torn)}")
    with pytest.raises(LinkError, match="the journal ends here"):
        record.capture(rig, rig.program, tmp_path / "again.h5")
    record.recover(torn)
    assert (tmp_path / "again.h5").read_bytes() == torn.read_bytes()
