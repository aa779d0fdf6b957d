"""Facts of a front end from the file to the board, and from the board to the capture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import front_end, record
from motorid.acquire.board import Board
from motorid.acquire.header import check_kinds
from motorid.capture import store
from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.errors import DataError, RigError, UsageError
from motorid.program import StepKind
from motorid.rig import Calibration, Rig
from motorid.rig_front_end import FrontEnd, load_front_end, parse
from motorid.sim.front_end import compiled
from motorid.sim.port import SimPort, open_sim
from motorid.wire.enums import Bridge, ResetCause
from tests.acquire.rigs import SAMPLES, sim_rig
from tests.test_rig_front_end import GOOD


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Rig:
    """A rig whose every opening meets the same simulated board, reset by it."""
    rig = sim_rig()
    board = open_sim(rig.port)
    monkeypatch.setattr(board, "close", lambda: None)

    def opened(url: str) -> SimPort:
        found = board._device.board
        assert found is not None
        found.reset(ResetCause.EXTERNAL)
        return board

    for module in (record, front_end):
        monkeypatch.setattr(module, "open_port", opened)
    return rig


def wired() -> FrontEnd:
    """Facts that say of the simulated bench what is so."""
    device = open_sim(sim_rig().port)._device
    assert device.board is not None
    facts = compiled(device.board.chain) | {"name": "as wired", "current_gain_uncertainty": 777}
    return FrontEnd(facts, "")


@pytest.mark.slow
def test_a_capture_records_the_facts_and_declares_their_uncertainty(
    bench: Rig, tmp_path: Path
) -> None:
    facts = wired()
    before = store.load(record.capture(bench, bench.program, tmp_path / "before.h5"))
    told = front_end.store(bench.port, facts)
    assert told[0].endswith("stored")
    kept = store.load(record.capture(bench, bench.program, tmp_path / "run.h5"))
    assert (kept.end_reason, len(kept)) == ("completed", SAMPLES)
    recorded = kept.provenance["front_end"]
    assert recorded["name"] == "as wired"
    assert recorded["front_end_hash"] == facts.hash
    assert kept.provenance["configuration"]["front_end_hash"] == facts.hash
    assert kept.channels[CURRENT].gain_uncertainty == pytest.approx(777e-5, rel=1e-5)
    assert "front_end" not in before.provenance
    for name in (CURRENT, VOLTAGE):
        scales = [one.channels[name].scale for one in (before, kept)]
        np.testing.assert_allclose(scales[1], scales[0], rtol=1e-6)


def test_a_rig_that_names_another_front_end_is_not_driven(bench: Rig, tmp_path: Path) -> None:
    named = replace(bench, front_end="acs712-20")
    with pytest.raises(RigError, match="names the front end acs712-20, and the board holds simul"):
        record.capture(named, bench.program, tmp_path / "run.h5")
    front_end.store(bench.port, load_front_end("acs712-30"))
    with pytest.raises(RigError, match="the board holds acs712-30: `motorid board set acs712-20`"):
        record.capture(named, bench.program, tmp_path / "run.h5")


def test_a_rig_finds_its_own_file_beside_it(bench: Rig, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(GOOD)
    front_end.store(bench.port, parse(GOOD.replace("12.5", "12.4")))
    named = replace(bench, front_end="own.toml", folder=str(tmp_path))
    with pytest.raises(RigError, match="the board holds mine with other figures"):
        record.capture(named, bench.program, tmp_path / "run.h5")


@pytest.mark.slow
def test_a_current_without_a_sign_is_no_measurement(bench: Rig, tmp_path: Path) -> None:
    facts = wired().facts | {"sensor": 2, "name": "no sign"}
    front_end.store(bench.port, FrontEnd(facts, ""))
    with pytest.raises(
        RigError, match=r"\(no sign\) shows how much current flows and not its sign"
    ):
        record.capture(bench, bench.program, tmp_path / "run.h5")
    assert not (tmp_path / "run.h5").exists()
    without = replace(bench.sampling, channels=(VOLTAGE, POSITION))
    kept = store.load(
        record.capture(replace(bench, sampling=without), bench.program, tmp_path / "run.h5")
    )
    assert (kept.end_reason, CURRENT in kept.channels) == ("completed", False)


def test_a_board_without_facts_says_so_and_is_told_how(tmp_path: Path) -> None:
    rig = sim_rig("front_end=none")
    with pytest.raises(RigError, match="`motorid board set"):
        record.capture(rig, rig.program, tmp_path / "run.h5")
    assert "refuses to drive" in next(front_end.show(rig.port))


def test_facts_of_another_kind_of_board_are_refused_unless_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = sim_rig()
    monkeypatch.setattr("motorid.sim.identity.NAME", "motorid-pico")
    with pytest.raises(RigError, match="acs712-20 is that of uno or mega, and motorid-pico"):
        front_end.store(rig.port, load_front_end("acs712-20"))
    assert front_end.store(rig.port, load_front_end("acs712-20"), any_board=True)
    assert front_end.store(rig.port, load_front_end("pico-ina240"))


def test_an_older_board_keeps_none() -> None:
    with pytest.raises(RigError, match="keeps no facts of its front end"):
        front_end.store(sim_rig("minor=2").port, load_front_end("acs712-20"))


def test_a_configured_board_stores_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = sim_rig()
    port = open_sim(rig.port)
    monkeypatch.setattr(front_end, "open_port", lambda url: port)
    client = Board(port)
    client.identify()
    record.configure(client, rig)
    with pytest.raises(UsageError, match="reset it"):
        front_end.store(rig.port, load_front_end("acs712-20"))


@pytest.mark.slow
def test_a_driver_that_cannot_open_brakes_where_it_would_coast(
    bench: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bare = FrontEnd(wired().facts | {"bridge": Bridge.PWM_DIR_BARE, "name": "bare"}, "")
    front_end.store(bench.port, bare)
    with pytest.raises(RigError, match="cannot open the bridge, and 3 of the program's steps"):
        record.capture(bench, bench.program, tmp_path / "run.h5")
    monkeypatch.setattr(front_end, "load_front_end", lambda *_: bare)
    named = replace(bench, front_end="bare")
    kept = store.load(record.capture(named, bench.program, tmp_path / "run.h5"))
    assert (kept.end_reason, len(kept)) == ("completed", SAMPLES)
    assert kept.program == bench.program.braked()
    assert StepKind.COAST not in {step.kind for step in kept.program.steps}
    assert [s.duration_s for s in kept.program.steps] == [s.duration_s for s in bench.program.steps]
    assert kept.provenance["check"]["coast_v"] is None


@pytest.mark.slow
def test_the_rest_of_the_chain_goes_from_rig_to_capture(tmp_path: Path) -> None:
    """The journal's header carries it, so that a recovered run has it too."""
    rig = sim_rig()
    bent = Calibration(nonlinearity=0.002, nonlinearity_shape="bow")
    wiring = replace(
        rig.wiring, reference_drift=1e-3, reference_time_s=2.0, encoder_eccentricity_rad=2e-3
    )
    rig = replace(rig, wiring=wiring, calibration={CURRENT: bent})
    found = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    current = found.channels[CURRENT]
    assert (current.nonlinearity, current.nonlinearity_shape) == (0.002, "bow")
    ends = current.scale * (np.array([current.raw_min, current.raw_max]) - current.offset)
    assert current.full_scale == pytest.approx(np.abs(ends).max())
    assert found.channels[VOLTAGE].nonlinearity == 0.0
    assert found.wiring.reference_drift == 1e-3
    assert found.wiring.encoder_eccentricity_rad == 2e-3


@pytest.mark.slow
def test_a_sensor_that_follows_the_reference_is_kept_as_such(bench: Rig, tmp_path: Path) -> None:
    facts = wired()
    front_end.store(bench.port, FrontEnd({**facts.facts, "ratiometric": 1}, ""))
    kept = store.load(record.capture(bench, bench.program, tmp_path / "run.h5"))
    assert {n for n, c in kept.channels.items() if c.ratiometric} == {CURRENT}


def test_a_header_whose_shape_is_none_is_damaged() -> None:
    good = {"calibration": {CURRENT: {"nonlinearity": 0.1, "nonlinearity_shape": "s"}}}
    check_kinds(good, "header")
    with pytest.raises(DataError, match="header is damaged: calibration"):
        check_kinds({"calibration": {CURRENT: {"nonlinearity_shape": "z"}}}, "header")
