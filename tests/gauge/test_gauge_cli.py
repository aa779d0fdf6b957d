"""motorid gauge and motorid trend: files in, reports and exit codes out."""

from __future__ import annotations

import csv
import json
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from motorid.capture import store
from motorid.cli.main import run
from motorid.errors import UsageError
from motorid.workflow.gauge import plan
from motorid.workflow.plan_file import with_program
from tests.acquire.rigs import SHORT
from tests.gauge.published import AIAG_GRR, LINEARITY, LINEARITY_AT, PISTON_RINGS


@pytest.fixture
def readings(tmp_path: Path) -> Path:
    """The AIAG's study as a file, its rows shuffled as a bench would give them."""
    rows = [
        (f"P{p}", "ABC"[o], r + 1, AIAG_GRR[p, o, r])
        for p in range(10)
        for o in range(3)
        for r in range(3)
    ]
    order = np.random.default_rng(2).permutation(len(rows))
    path = tmp_path / "readings.csv"
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["Part", "Appraiser", "trial", "R"])
        writer.writerows([rows[k] for k in order])
    return path


class Tags(HTMLParser):
    """Counts the tags of a page, and notes what is not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.count: dict[str, int] = {}
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.count[tag] = self.count.get(tag, 0) + 1
        if tag not in ("meta", "path", "rect", "link", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in ("path", "rect"):
            assert self.open.pop() == tag


def tags(path: Path) -> dict[str, int]:
    parser = Tags()
    parser.feed(path.read_text(encoding="utf-8"))
    assert parser.open == []
    return parser.count


def test_crossed_study_from_a_file(
    readings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["gauge", "crossed", str(readings), "--tolerance", "R=8"]
    assert run([*words, "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "R: GRR 22.7 % of the tolerance, may be acceptable; 4 distinct categories" in said
    assert "10 parts × 3 operators × 3 repeats" in said
    found = json.loads((tmp_path / "out" / "gauge.json").read_text(encoding="utf-8"))
    study = found["studies"][0]
    assert study["components"]["GRR"]["percent_study"] == pytest.approx(27.86, abs=5e-3)
    assert study["standing"] == "may be acceptable"
    assert tags(tmp_path / "out" / "gauge.html")["svg"] >= 5
    assert run([*words, "-o", str(tmp_path / "out")]) == 2  # exists


def test_a_verdict_only_where_a_limit_was_given(readings: Path) -> None:
    words = ["gauge", "crossed", str(readings)]
    assert run([*words, "--max-grr", "30"]) == 0
    assert run([*words, "--max-grr", "10"]) == 1
    assert run([*words, "--method", "range", "--max-grr", "26.7"]) == 0


def test_a_study_that_is_not_crossed_is_refused(
    readings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = readings.read_text().splitlines()
    readings.write_text("\n".join(lines[:-1]))
    assert run(["gauge", "crossed", str(readings)]) == 4
    assert "has 2 readings, another has 3" in capsys.readouterr().err
    assert run(["gauge", "crossed", str(readings), "--quantity", "Q"]) == 2


def test_golden_and_linearity(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "golden.csv"
    rng = np.random.default_rng(4)
    path.write_text("R\n" + "\n".join(f"{v:.5f}" for v in 2.6 + rng.normal(0, 0.002, 50)))
    words = ["gauge", "golden", str(path), "--quantity", "R", "--reference", "2.6"]
    assert run([*words, "--tolerance", "0.4", "--min-cgk", "1.33"]) == 0
    assert "Cgk" in capsys.readouterr().out
    assert run([*words, "--tolerance", "0.04", "--min-cgk", "1.33"]) == 1
    assert run([*words, "--min-cgk", "1.33"]) == 2
    path = tmp_path / "linearity.csv"
    rows = [f"{x},{v}" for x, vs in zip(LINEARITY_AT, LINEARITY, strict=True) for v in vs]
    path.write_text("at,R\n" + "\n".join(rows))
    line = ["gauge", "linearity", str(path), "--quantity", "R", "--reference-column", "at"]
    assert run(line) == 0
    said = capsys.readouterr().out
    assert "slope t = -12.043" in said
    assert "not acceptable" in said


def test_trend_of_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Piston rings: in control for 25 subgroups, then an alarm, which is a FAIL."""
    path = tmp_path / "rings.csv"
    path.write_text("d\n" + "\n".join(f"{v:.3f}" for v in PISTON_RINGS.ravel()))
    words = ["trend", str(path), "--quantity", "d", "--subgroup", "5"]
    limits = ["--lower", "73.95", "--upper", "74.05"]
    page = tmp_path / "rings.html"
    assert run([*words, *limits, "--baseline", "25", "-o", str(page)]) == 1
    said = capsys.readouterr().out
    assert "OUT OF CONTROL" in said
    assert "ALARM X-bar chart, rule 1" in said
    assert tags(page)["svg"] >= 3
    path.write_text("d\n" + "\n".join(f"{v:.3f}" for v in PISTON_RINGS[:25].ravel()))
    assert run([*words, *limits, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["capability"]["cpk"]["value"] == pytest.approx(1.663, abs=1e-3)
    assert run([*words, *limits, "--min-ppk", "1.67"]) == 1
    path.write_text("d\n74.0\n74.1\n")
    assert run(["trend", str(path), "--quantity", "d"]) == 4


def test_the_order_of_a_study_is_shuffled_and_repeatable(tmp_path: Path) -> None:
    runs = plan(["a", "b", "c", "d", "e"], ["x", "y"], 3, tmp_path)
    assert runs == plan(["a", "b", "c", "d", "e"], ["x", "y"], 3, tmp_path)
    assert len({(r.part, r.operator, r.repeat) for r in runs}) == 30
    rounds = [tuple(r.part for r in runs[k : k + 5]) for k in range(0, 30, 5)]
    assert all(sorted(one) == ["a", "b", "c", "d", "e"] for one in rounds)
    assert len(set(rounds)) > 1
    with pytest.raises(UsageError, match="share a file"):
        plan(["a/1", "a:1"], ["x"], 2, tmp_path)


@pytest.mark.slow
@pytest.mark.long
def test_a_study_on_the_simulated_rig(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two fixtures whose current gains differ by 2 %, two discs: J's parts and R's fixtures show.

    Interrupted or not, a second call measures nothing again. One fixture is calibrated, and every
    run of it is one with that board.
    """
    out = tmp_path / "study"
    chain = "board={}&gain_error={}&voltage_gain_error=0&offset_error=0&clock_ppm=0&speed=max"
    (tmp_path / "left.toml").write_text(rig_text(chain.format(7, 0.0)))
    (tmp_path / "right.toml").write_text(rig_text(chain.format(8, 0.02)))
    calibrated = '[board]\nname = "motorid-sim"\nserial = "{}"\n'
    head = 'format = "motorid calibration 1"\ndate = 2026-11-21T12:00:00Z\n'
    (tmp_path / "left.calibration.toml").write_text(head + calibrated.format("sim-7"))
    words = ["gauge", "run", "--yes", "-o", str(out), "--repeats", "2"]
    words += ["-f", f"left={tmp_path / 'left.toml'}", "-f", f"right={tmp_path / 'right.toml'}"]
    for k in (1, 2):
        words += ["--part", f"D{k}=load_inertia={k}e-8"]
    assert run(words) == 0
    found = json.loads((out / "gauge.json").read_text(encoding="utf-8"))
    studies = {study["quantity"]: study for study in found["studies"]}
    J, R = studies["J"]["components"], studies["R"]["components"]
    assert J["PV"]["sigma"] == pytest.approx(1e-8 / 2**0.5, rel=0.1)
    # 2 % of 2.58 ohm between two fixtures is a standard deviation of 2 % / sqrt(2)
    assert R["AV"]["sigma"] == pytest.approx(0.02 * 2.58 / 2**0.5, rel=0.1)
    assert R["AV"]["sigma"] > 10 * R["EV"]["sigma"]
    assert studies["R"]["stated_sigma"] is not None
    before = {path: path.stat().st_mtime_ns for path in (out / "captures").iterdir()}
    assert len(before) == 8
    assert run(words) == 2
    assert run([*words, "--force"]) == 0
    left = [store.load(path).provenance for path in before if "_left_" in path.name]
    assert {one["board_serial"] for one in left} == {"sim-7"}
    assert before == {path: path.stat().st_mtime_ns for path in (out / "captures").iterdir()}
    capsys.readouterr()


def rig_text(options: str) -> str:
    """The packaged simulated rig with another measuring chain and a short program."""
    from importlib import resources

    here = resources.files("motorid").joinpath("rigs", "sim.toml")
    path = Path(str(here)) if here.is_file() else Path(__file__).parents[2] / "rigs" / "sim.toml"
    lines = with_program(path.read_text(encoding="utf-8"), SHORT, "this test").splitlines()
    return "\n".join(
        f'port = "sim://?{options}"' if line.startswith("port") else line for line in lines
    )
