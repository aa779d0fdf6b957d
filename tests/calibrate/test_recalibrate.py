"""fit --rig: a stored capture in the light of a corrected rig."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import motorid
from motorid.acquire.record import capture
from motorid.capture import store, store_layout
from motorid.capture.model import Capture
from motorid.cli import main
from motorid.errors import DataError, RigError
from motorid.quality.history import Query, open_history
from motorid.quality.history.records import capture_record
from motorid.report.json_ import schema
from motorid.rig import Rig, load_rig
from motorid.workflow.recalibrate import recalibrated
from tests.acquire.rigs import SHORT
from tests.calibrate.benches import rig_file
from tests.calibrate.test_file import calibration


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("benches")


@pytest.fixture(scope="module")
def stored(folder: Path) -> Path:
    """A run of the bench before it was calibrated."""
    return capture(load_rig(str(rig_file(folder))), SHORT, folder / "run.h5", serial="M1")


@pytest.fixture(scope="module")
def rig(stored: Path, folder: Path) -> Rig:
    """The bench since it was."""
    path = rig_file(folder, name="corrected")
    path.with_name("corrected.calibration.toml").write_text(calibration(), encoding="utf-8")
    return load_rig(str(path))


def same(one: Capture, other: Capture) -> None:
    """Both mean the same, whatever their provenance says."""
    assert one.clock_hz == other.clock_hz
    assert one.clock_uncertainty == other.clock_uncertainty
    assert one.wiring == other.wiring
    for name, channel in one.channels.items():
        twin = other.channels[name]
        np.testing.assert_array_equal(channel.raw, twin.raw)
        for key in store_layout.CHANNEL_FIELDS:
            mine, its = getattr(channel, key), getattr(twin, key)
            assert mine == (pytest.approx(its, rel=1e-12) if isinstance(its, float) else its), key


@pytest.mark.slow
def test_its_own_rig_changes_nothing(stored: Path, folder: Path) -> None:
    own = store.load(stored)
    same(recalibrated(own, load_rig(str(rig_file(folder)))), own)


@pytest.mark.slow
def test_a_corrected_rig_gives_what_a_capture_with_it_would_have_given(
    stored: Path, rig: Rig, tmp_path: Path
) -> None:
    live = store.load(capture(rig, SHORT, tmp_path / "live.h5"))
    again = recalibrated(store.load(stored), rig)
    same(again, live)
    assert again.sha256 == store.load(stored).sha256


@pytest.mark.slow
def test_wiring_and_direction_are_corrected_too(stored: Path, rig: Rig) -> None:
    own = store.load(stored)
    other = replace(
        rig,
        wiring=replace(rig.wiring, counts_per_turn=1024, gear_ratio=3),
        encoder_reversed=True,
        voltage_sense="bridge",
        ambient_c=31.0,
    )
    again = recalibrated(own, other)
    np.testing.assert_allclose(
        again.channels["position"].values, -2 * own.channels["position"].values
    )
    assert again.channels["terminal_voltage"].sense == "bridge"
    assert again.wiring.gear_ratio == 3
    assert again.wiring.pwm_hz == own.wiring.pwm_hz
    assert again.ambient_c == 31.0


@pytest.mark.slow
def test_the_file_stays_and_the_estimate_cites_both(stored: Path, rig: Rig, folder: Path) -> None:
    before = hashlib.sha256(stored.read_bytes()).hexdigest()
    plain = motorid.fit(stored)
    again = motorid.fit(stored, rig=rig)
    assert hashlib.sha256(stored.read_bytes()).hexdigest() == before
    own = load_rig(str(folder / "bench.toml"))
    cited = again.inputs[0]
    assert rig.calibrated is not None
    assert cited["sha256"] == before
    assert cited["rig_sha256"] == hashlib.sha256(own.text.encode()).hexdigest()
    assert "calibration" not in cited
    assert cited["reanalysed"]["rig_sha256"] == hashlib.sha256(rig.text.encode()).hexdigest()
    assert cited["reanalysed"]["calibration"]["sha256"] == rig.calibrated.sha256
    assert "reanalysed" not in plain.inputs[0]
    # the current reads 1.02 times larger: R smaller by that, J larger, K as it was
    shares = {
        name: again.parameters[name].value / plain.parameters[name].value  # type: ignore[operator]
        for name in ("R", "K", "J")
    }
    assert shares["R"] == pytest.approx(1 / 1.02, rel=1e-3)
    assert shares["J"] == pytest.approx(1.02, rel=1e-3)
    assert shares["K"] == pytest.approx(1, rel=1e-4)


@pytest.mark.slow
def test_the_command_prints_both_and_keeps_to_the_schema(
    stored: Path, rig: Rig, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["fit", str(stored), "--rig", str(folder / "corrected.toml")]
    assert main.run([*words, "-o", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Re-analysed with calibration corrected.calibration.toml of 2026-11-21" in said
    assert "taken with rig file" in said
    estimate = json.loads((tmp_path / "out" / "estimate.json").read_text("utf-8"))
    jsonschema.validate(estimate, schema())
    assert "corrected.calibration.toml" in (tmp_path / "out" / "report.html").read_text("utf-8")


@pytest.mark.slow
def test_many_captures_are_re_analysed_as_one_is(
    stored: Path, rig: Rig, folder: Path, tmp_path: Path
) -> None:
    words = ["fit", str(stored), "--jobs", "1", "-o", str(tmp_path)]
    assert main.run(words) == 0
    plain = (tmp_path / "fits.csv").read_text("utf-8")
    words += ["--force", "--rig", str(folder / "corrected.toml")]
    assert main.run(words) == 0
    assert (tmp_path / "fits.csv").read_text("utf-8") != plain  # not the kept answer
    assert len(list((tmp_path / "runs").glob("*.json"))) == 2


@pytest.mark.slow
def test_check_judges_a_stored_capture_under_another_rig(
    stored: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["check", "--product", "sim-disc", "--capture", str(stored), "--json"]
    main.run(words)
    plain = json.loads(capsys.readouterr().out)
    main.run([*words, "--rig", str(folder / "corrected.toml")])
    again = json.loads(capsys.readouterr().out)
    assert "reanalysed" not in plain["inputs"][0]
    assert again["inputs"][0]["reanalysed"]["calibration"]["name"] == "corrected.calibration.toml"


def test_a_rig_of_another_board_or_with_other_channels_is_refused(stored: Path, rig: Rig) -> None:
    own = store.load(stored)
    other = replace(own, provenance={**own.provenance, "board_serial": "sim-8"})
    with pytest.raises(RigError, match=r"run\.h5: .*sim-7, and this board is .*sim-8"):
        recalibrated(other, rig)
    with pytest.raises(RigError, match="taken with board sim-8, and the rig sim is of board B2"):
        recalibrated(other, replace(rig, calibrated=None, board_serial="B2"))
    wide = replace(rig, sampling=replace(rig.sampling, channels=("current", "supply_voltage")))
    with pytest.raises(RigError, match="holds no supply_voltage, which the rig sim samples"):
        recalibrated(own, wide)


def test_an_imported_capture_has_no_rig(stored: Path, rig: Rig) -> None:
    own = store.load(stored)
    with pytest.raises(DataError, match="imported"):
        recalibrated(replace(own, provenance={"note": "from a table"}), rig)


@pytest.mark.parametrize(
    "damage",
    [
        {"descriptors": {}},
        {"descriptors": {"current": 3}},
        {"identity": "nobody"},
        {"identity": {}},
        {"configuration": []},
    ],
)
def test_damaged_provenance_is_one_sentence(
    stored: Path, rig: Rig, damage: dict[str, object]
) -> None:
    own = store.load(stored)
    with pytest.raises(DataError, match="damaged"):
        recalibrated(replace(own, provenance={**own.provenance, **damage}), rig)


@pytest.mark.slow
@pytest.mark.parametrize(
    "said", ["yesterday", {"name": "x"}, {"name": "x", "oldest": "2026"}, [1], {"oldest": 3}]
)
def test_a_calibration_that_is_cited_badly_is_not_cited(stored: Path, said: object) -> None:
    own = store.load(stored)
    odd = replace(own, provenance={**own.provenance, "calibration_file": said, "created": "noon"})
    estimate = motorid.fit(odd)
    assert "calibration" not in estimate.inputs[0]
    assert "calibration_old" not in [d.code for d in estimate.diagnostics]


@pytest.mark.slow
def test_a_capture_from_before_calibrations_still_works(stored: Path, rig: Rig) -> None:
    """Captures of the first version carry no serial, and no date that could be held against one."""
    own = store.load(stored)
    kept = {k: v for k, v in own.provenance.items() if k not in ("board_serial", "created")}
    again = recalibrated(replace(own, provenance=kept), rig)
    assert again.channels["current"].gain_uncertainty == 0.001
    assert motorid.fit(again).diagnostics is not None


@pytest.mark.slow
def test_the_history_keeps_the_calibration_of_a_capture(
    rig: Rig, tmp_path: Path, stored: Path
) -> None:
    assert rig.calibrated is not None
    live = store.load(capture(rig, SHORT, tmp_path / "live.h5"))
    kept = json.loads(capture_record(live).calibration)
    assert kept["calibration_text"] == rig.calibrated.text
    assert kept["calibration_file"]["sha256"] == rig.calibrated.sha256
    assert "calibration_text" not in json.loads(capture_record(store.load(stored)).calibration)


@pytest.mark.slow
def test_the_history_says_when_a_verdict_was_given_under_another_rig(
    stored: Path, folder: Path, tmp_path: Path
) -> None:
    base = str(tmp_path / "line.db")
    words = ["check", "--product", "sim-disc", "--capture", str(stored), "--history", base]
    main.run(words)
    main.run([*words, "--rig", str(folder / "corrected.toml")])
    with open_history(base, create=False) as history:
        notes = [row.note for row in history.results(Query())]
    assert notes[0] == ""
    assert notes[1].startswith("re-analysed with calibration corrected.calibration.toml")
    assert "taken with rig file" in notes[1]
