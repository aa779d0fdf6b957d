"""Captures from the simulated board, through the real client."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import record
from motorid.acquire.live import Live
from motorid.capture import store
from motorid.errors import RigError, UsageError
from motorid.rig import Nameplate
from tests.acquire.rigs import SAMPLES, SHORT, run, sim_rig


@pytest.mark.slow
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
    assert capture.wiring.dead_time_s == pytest.approx(200e-9)
    assert capture.provenance["serial"] == "M17"
    assert capture.provenance["rig"] == rig.text
    assert capture.provenance["identity"]["board"] == "motorid-sim"
    current = capture.channels["current"]
    assert (current.kind, current.unit) == ("mean", "A")
    assert current.aperture_s == pytest.approx(50e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("stated", "kept"), [("", "sim-7"), ("B9", "B9")])
def test_the_board_has_the_serial_that_the_rig_states_or_else_its_port_s(
    stated: str, kept: str, tmp_path: Path
) -> None:
    rig = replace(sim_rig("board=7"), board_serial=stated)
    path = record.capture(rig, rig.program, tmp_path / "run.h5")
    assert store.load(path).provenance["board_serial"] == kept


@pytest.mark.slow
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


@pytest.mark.slow
def test_progress_is_told(tmp_path: Path) -> None:
    seen: list[Live] = []
    run("", tmp_path / "run.h5", progress=seen.append)
    assert seen[0].done_s == 0
    assert seen[0].total_s == pytest.approx(0.38)


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_burst_is_sent_afterwards(tmp_path: Path) -> None:
    rig = sim_rig("buffer=4000&baud=115200")
    rig = replace(rig, sampling=replace(rig.sampling, mode="burst"))
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert (len(capture), capture.gaps) == (SAMPLES, ())
    small = replace(rig, port=rig.port.replace("buffer=4000", "buffer=2000"))
    with pytest.raises(RigError, match="the board keeps 2000 in burst mode"):
        record.capture(small, small.program, tmp_path / "small.h5")


@pytest.mark.slow
def test_an_unknown_motor_is_judged_by_the_pulse(tmp_path: Path) -> None:
    rig = replace(sim_rig(), nameplate=Nameplate(voltage_v=6.0))
    capture = store.load(record.capture(rig, SHORT, tmp_path / "run.h5"))
    assert 1.5 < capture.provenance["check"]["resistance_bound_ohm"] < 2.6
    weak = replace(rig, limits=replace(rig.limits, current_a=1.5))
    with pytest.raises(RigError, match=r"limits.current_a is 1\.5"):
        record.capture(weak, SHORT, tmp_path / "weak.h5")
    assert not (tmp_path / "weak.h5").exists()


@pytest.mark.slow
def test_existing_files_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_text("precious")
    with pytest.raises(UsageError, match="exists already"):
        run("", path)
    assert path.read_text() == "precious"
    run("", path, force=True)
    assert len(store.load(path)) == SAMPLES


@pytest.mark.slow
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


@pytest.mark.slow
def test_repeats_share_one_opening(tmp_path: Path) -> None:
    rig = sim_rig()
    paths = [tmp_path / f"run-{n}.h5" for n in (1, 2, 3)]
    record.capture_all(rig, rig.program, paths)
    captures = [store.load(path) for path in paths]
    assert [len(capture) for capture in captures] == [SAMPLES] * 3
    assert captures[0].ticks[-1] < captures[1].ticks[0] < captures[2].ticks[0]  # one power-on
    raws = [capture.channels["current"].raw for capture in captures]
    assert not np.array_equal(raws[0], raws[1])
