"""motorid history and motorid trend on a history, through the verdicts of real captures."""

from __future__ import annotations

import json
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from motorid.cli.main import run
from motorid.quality.history import Query, open_history
from motorid.quality.history.records import MeasurementRecord, ResultRecord
from motorid.quality.product import load_product
from tests.history.records import BEGAN, record

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def golden(tmp_path: Path) -> Path:
    """A history in which a golden motor drifts and the line's motors do not."""
    place = tmp_path / "line.db"
    rng = np.random.default_rng(8)
    with open_history(place) as history:
        for number in range(60):
            history.add(record(number))
            for serial, drift in (("GOLD-1", 0.0), ("GOLD-2", 0.002)):
                value = 2.6 + drift * number + rng.normal(0, 0.004)
                measured = (MeasurementRecord("R", "ohm", value, 0.004, 2.4, 2.8),)
                at = BEGAN + timedelta(days=number)
                history.add(ResultRecord("golden", serial, measured, at=at))
    return place


@pytest.mark.slow
def test_golden_motor_drift(golden: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["trend", str(golden), "--quantity", "R", "--kind", "golden", "--rules", "limits"]
    assert run([*words, "--golden", "GOLD-1"]) == 0
    assert "drift" in capsys.readouterr().out
    assert run([*words, "--golden", "GOLD-2", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    low, high = found["drift"]["interval_95"]
    assert low <= 0.002 <= high
    assert any("drifts by 0.00" in alarm for alarm in found["alarms"])
    assert found["capability"]["upper"] == 2.8  # the limits that were in force


@pytest.mark.slow
def test_trend_refuses_what_was_never_measured(
    golden: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trend", str(golden), "--quantity", "RR"]) == 2
    assert "did you mean 'R'" in capsys.readouterr().err
    assert run(["trend", str(golden), "--quantity", "R", "--serial", "nobody"]) == 4
    assert run(["trend", "absent.db", "--quantity", "R"]) == 4


@pytest.mark.slow
def test_list_and_export(golden: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["history", "list", str(golden), "--serial", "SN-0000?", "--last", "3"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert [line.split()[3] for line in out[1:]] == ["SN-00007", "SN-00008", "SN-00009"]
    target = golden.with_name("table.csv")
    assert run(["history", "export", str(golden), "-o", str(target), "--kind", "golden"]) == 0
    assert len(target.read_text().splitlines()) == 121
    assert run(["history", "export", str(golden), "-o", str(target)]) == 2


@pytest.mark.slow
def test_trace_from_the_serial_and_from_the_digest(
    golden: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["history", "trace", str(golden), "SN-00003"]) == 0
    forth = capsys.readouterr().out
    sha256 = record(3).captures[0].sha256
    assert sha256 in forth
    assert run(["history", "trace", str(golden), sha256[:10]]) == 0
    assert capsys.readouterr().out == forth
    assert run(["history", "trace", str(golden), "SN-99999"]) == 4


@pytest.mark.slow
def test_captures_judged_in_and_judged_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Today's tighter limits turn a PASS into a FAIL; the old result stays; moved files are found;
    another file under the old name is not taken for the capture.
    """
    place, folder = str(tmp_path / "line.db"), tmp_path / "captures"
    folder.mkdir()
    words = ["check", "--product", "sim-disc", "--rig", "sim-line", "--speed", "max"]
    words += ["--serial", "D000001", "-o", str(tmp_path / "shift")]
    assert run([*words, "--history", str(tmp_path / "check.db")]) == 0
    with open_history(tmp_path / "check.db") as history:
        (row,) = history.results()
        (cited,) = history.captures_of(row.id)
        assert (row.serial, row.outcome, cited.serial) == ("D000001", "PASS", "D000001")
        assert "line" in history.document(cited.rig)
        assert history.document(cited.program)
        assert history.document(cited.calibration)
    (made,) = (tmp_path / "shift").rglob("capture.h5")
    (folder / "warm-up.h5").write_bytes(made.read_bytes())  # is no inspection
    made.rename(folder / "D000001.h5")
    add = ["history", "add", place, str(folder), "--product", "sim-disc", "--station", "s1"]
    assert run(add) == 0
    assert run(add) == 0
    said = capsys.readouterr().out
    assert "known already" in said
    assert "warm-up" not in said
    product = load_product("sim-disc")
    tight = tmp_path / "tight.toml"
    tight.write_text(product.text.replace("low = 2.4\nhigh = 2.8", "low = 2.4\nhigh = 2.5"))
    again = ["history", "rejudge", place, "--product", str(tight)]
    assert run(again) == 0
    assert "D000001  PASS -> FAIL" in capsys.readouterr().out
    with open_history(place) as history:
        assert [(r.kind, r.outcome) for r in history.results()] == [
            ("check", "PASS"),
            ("rejudged", "FAIL"),
        ]
        limits = {history.document(r.limits) for r in history.results()}
        assert limits == {product.text, tight.read_text()}
        assert history.series("R_25", Query(outcome="FAIL"))[0].high == 2.5
    (tmp_path / "archive").mkdir()
    (folder / "D000001.h5").rename(tmp_path / "archive" / "D000001.h5")
    assert run(again) == 4
    assert "is not there any more" in capsys.readouterr().out
    (folder / "D000001.h5").write_bytes(b"another file")
    assert run(again) == 4
    assert "has other bytes now" in capsys.readouterr().out
    assert run([*again, "--captures", str(tmp_path / "archive")]) == 0
    assert "FAIL -> FAIL (known already)" in capsys.readouterr().out
