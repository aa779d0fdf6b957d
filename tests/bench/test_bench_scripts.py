"""Every script of bench/ still runs from end to end, in its shortest useful form.

Those that take longest are studies, run with the evidence. Each is started as a person starts it,
and its table is looked at; never its times, which another program on the machine can spoil. A
script may therefore end with 1 where it judges times, or shares of more runs than it is given here.
Not run:

- bench_plan.py plans a rig for 25 s of the processor; tests/plan/test_plan.py runs its ``confirm``.
- bench_emulated_motors.py emulates at least five captures; tests/emulated/test_motors.py runs what
  each of its rows is made of.
- bench_pico.py emulates a Pico for minutes; tests/emulated/test_pico_rates.py runs a shorter stream
  and one of its motors.
- bench_dead_motors.py judges motors with faults for minutes; tests/quality/test_not_running.py has
  one of each.
- bench_ingest.py starts a server; tests/history/test_postgresql_failures.py has twenty writers.
- bench_cluster.py starts three clusters of processes; tests/many/test_cluster.py has one.
"""

from __future__ import annotations

import json
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench import line_history
from bench.foreign import spice
from motorid.quality.history import open_history
from tests import chromium
from tests.conformance.boards import emulator_lacks
from tests.history.servers import programs
from tests.plant.mosquitto import ABSENT, PROGRAM

pytestmark = pytest.mark.slow

BENCH = Path(__file__).resolve().parents[2] / "bench"
LEFT_OUT = {"plan", "emulated_motors", "dead_motors", "cluster", "ingest", "pico"}
MAY_MISS = {
    "branches",
    "cycle",
    "exactness",
    "false_alarms",
    "gauge",
    "history",
    "import",
    "live",
    "log_chain",
    "many",
    "mistakes",
    "search",
    "startup",
}  # goals of a full run
X86 = ("x86_64", "AMD64")
SIX = ("R", "L", "K", "B", "J", "T0")


def run(name: str, *arguments: str) -> str:
    """What bench_NAME.py prints; it ends with 0, or with 1 where it may miss a goal."""
    command = [sys.executable, str(BENCH / f"bench_{name}.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert "Traceback" not in done.stderr, done.stderr
    allowed = (0, 1) if name in MAY_MISS else (0,)
    assert done.returncode in allowed, done.stdout + done.stderr
    return done.stdout


def found(pattern: str, text: str) -> re.Match[str]:
    """The first match, which must be there."""
    match = re.search(pattern, text)
    assert match, f"no {pattern!r} in:\n{text}"
    return match


def cells(begins: str, text: str) -> list[str]:
    """The row of a Markdown table whose first cell begins so, without that cell."""
    (row,) = (line for line in text.splitlines() if line.startswith(f"| {begins}"))
    return [cell.strip() for cell in row.strip("|").split("|")][1:]


def test_every_script_is_run_here_or_left_out_with_its_reason() -> None:
    scripts = {path.stem.removeprefix("bench_") for path in BENCH.glob("bench_*.py")}
    here = Path(__file__).read_text(encoding="utf-8")
    assert scripts == LEFT_OUT | set(re.findall(r"\brun\(\s*\"(\w+)\"", here))
    assert all(f"- bench_{name}.py " in (__doc__ or "") for name in LEFT_OUT)


@pytest.mark.study
def test_branches_counts_what_some_tests_take() -> None:
    said = run("branches", "--tests", "tests/wire/test_wire_framing.py", "--jobs", "1")
    count, taken = cells("motorid/wire", said)
    assert int(count) > 900
    assert 20.0 < float(taken.strip("%")) < 100.0
    assert "tests ended with 0" in said


@pytest.mark.study
def test_coverage_scores_a_rig_and_sums_up(tmp_path: Path) -> None:
    out = tmp_path / "coverage.jsonl"
    parts = ("--parts", "bound", "fit", "naive")
    text = run("coverage", "--first", "1", "--rigs", "1", *parts, "--out", str(out), "--causes")
    (row,) = map(json.loads, out.read_text(encoding="utf-8").splitlines())
    for name in ("R", "K", "J"):
        assert abs(row["fit"]["parameters"][name]["off"]) < 0.05, name
        assert row["bound"][name] < 0.05
    assert "1 rigs; without a fit: 0" in text
    assert "by sense: " in text


def test_coverage_sums_up_a_study_without_its_bound(tmp_path: Path) -> None:
    fitted = {"parameters": {"R": {"interval": [-0.1, 0.1], "holds": True, "total": 0.05}}}
    stored = tmp_path / "fit.jsonl"
    stored.write_text(json.dumps({"seed": 1, "power_w": 5.0, "fit": fitted}) + "\n")
    row = cells("R ", run("coverage", "--tables", str(stored)))
    assert row[0].startswith("100.0%")
    assert row[-3:] == ["nan", "5.00%", "0"]


def test_cycle_inspects_a_good_motor() -> None:
    assert "outcomes PASS" in run("cycle", "1")


@pytest.mark.study
def test_exactness_is_near_the_bound_and_the_truth() -> None:
    small = ("--captures", "12", "--count", "1000", "--seeds", "1", "--motor", "faulhaber")
    text = run("exactness", *small)
    for name in SIX:  # of 12 captures the RMS error scatters by a fifth
        assert 0.5 < float(found(rf"\n  {name} +RMS error ([\d.]+) x", text)[1]) < 1.5, name
    assert found(r"faulhaber-\S+ +median error %: .* (ok|MISSED)\n", text)[1] == "ok"
    assert "an lfilter pass" in text


@pytest.mark.study
def test_fit_speed_has_one_minimum_with_its_peer() -> None:
    """Without archimedes, which needs an environment of its own."""
    text = run("fit_speed", "--repeats", "1", "--rtol", "1e-5")
    ours = float(found(r"motorid \(same start\).*chi-square ([\d.]+)", text)[1])
    peer = float(found(r"LSODA, rtol 1e-5.*chi-square ([\d.]+)", text)[1])
    assert ours == pytest.approx(peer, abs=0.1)  # six parameters at one sigma each add 6
    assert ours == pytest.approx(20_000, abs=600)  # of 20,000 readings, 3 sigma


def test_foreign_gives_a_regular_log_its_motor() -> None:
    row = cells("steps, regular stamps", run("foreign", "--only", "regular stamps"))
    assert len(row) == len(SIX)
    errors = dict(zip(SIX, (float(cell.split()[0]) for cell in row), strict=True))
    assert max(abs(errors[name]) for name in ("R", "K", "J")) < 1.0


def test_foreign_plants_are_judged_by_their_truth() -> None:
    if not spice.available():
        pytest.skip("no ngspice")
    text = run("foreign_plants", "--short")
    held, count = map(int, found(r"all parameters: (\d+) of (\d+) hold", text).groups())
    assert 4 <= held <= count <= len(SIX)


@pytest.mark.study
def test_gauge_foretells_what_the_study_finds() -> None:
    """Of 2 parts, fixtures and repeats: 4 to 5 degrees of freedom for EV, and 1 for AV."""
    text = run("gauge", "2", "2", "2", "1")
    assert text.count("2 parts × 2 operators × 2 repeats") == 4
    for name in ("R", "L", "K", "J"):
        row = found(rf"\n{name} +(\S+) +(\S+) +\S+ to \S+ +(\S+) +(\S+) ", text)
        foretold, repeats, most, fixtures = map(float, row.groups())
        assert foretold / 3 < repeats < 3 * foretold, name
        assert fixtures < 2 * most, name


@pytest.mark.study
@pytest.mark.skipif(platform.machine() not in X86, reason="no second kernel for this processor")
def test_kernels_give_one_answer(tmp_path: Path) -> None:
    """The oldest kernel runs on every such processor."""
    out = tmp_path / "kernels.json"
    short = ("--cases", "sim", "--rigs", "1", "--first", "1", "--kernels", "Nehalem")
    text = run("kernels", *short, "--out", str(out))
    row = cells("Nehalem", text)
    assert row[:2] == ["0", "0"]
    assert 0 < float(row[2]) < 0.01  # another kernel was in force, or no bit would have moved
    stored = json.loads(out.read_text(encoding="utf-8"))
    assert stored["subjects"] == 2
    assert stored["kernels"]["Nehalem"]["greatest_u"] == pytest.approx(float(row[2]), rel=0.1)


def test_import_takes_a_log_and_refuses_what_is_beyond_the_limits() -> None:
    text = run("import", "--rows", "20000", "--refused", "10^6 columns", "MAT, 10^13 rows declared")
    assert float(cells("20,000 rows", text)[4]) > 0  # times the file: of so few, the libraries'
    for name in ("10^6 columns", "MAT, 10^13 rows declared"):
        row = cells(name, text)
        assert row[3] == "exit 4", name
        assert float(found(r"(\d+) MiB", row[2])[1]) < 1024, name


@pytest.mark.study
def test_line_lets_no_defect_escape_and_loses_none() -> None:
    text = run("line", "3", "1")
    assert "escapes         0 " in text
    assert "3 results, none lost or doubled" in text
    assert "trend of R_25" in text


@pytest.mark.study
def test_kills_leave_the_history_equal_to_the_disk() -> None:
    text = run("kills", "2")
    assert "2 shifts, each ended by a kill" in text
    assert "orders accepted; 0 faults" in text


@pytest.mark.study
def test_log_chain_counts_intervals_with_a_fault_stated_and_not() -> None:
    text = run("log_chain", "--short")
    row = cells("current delay", text)
    for held in (row[1], row[3]):
        pairs = [tuple(map(int, pair)) for pair in re.findall(r"(\d+)/(\d+)", held)]
        assert sum(of for _, of in pairs) == len(SIX), held
    assert row[4] == "3/3"  # R, K, J within 2 % where the delay is stated


@pytest.mark.study
def test_mistakes_are_named_in_a_log_and_at_a_rig(tmp_path: Path) -> None:
    out = tmp_path / "mistakes.json"
    text = run("mistakes", "--only", "encoder reversed", "--out", str(out))
    assert "mistakes 2, named 2" in text
    kept = json.loads(out.read_text(encoding="utf-8"))["mistakes"]
    assert [(one["where"], len(one["motors"])) for one in kept] == [("rig", 2), ("log", 3)]
    codes = {one["where"]: {m["exit_code"] for m in one["motors"].values()} for one in kept}
    assert codes == {"rig": {3}, "log": {0}}  # the fit of a log turns it round


@pytest.mark.study
def test_a_strangers_logs_are_fine_or_named() -> None:
    text = run("stranger", "--short")
    assert "good: harmless 2" in text
    assert "bad: named 1" in text


@pytest.mark.study
def test_false_alarms_hold_the_truth_of_good_cases() -> None:
    text = run("false_alarms", "--count", "1", "--first", "2", "--kinds", "captures")
    held, of = map(int, found(r"intervals_held (\d+), intervals (\d+)", text).groups())
    assert of == len(SIX)
    assert held >= of - 1  # at 95 % each, more would be missed by one rig in thirty


@pytest.mark.study
def test_captures_that_no_motor_gives_have_no_estimated_parameter() -> None:
    text = run("refusals", "--count", "2", "--seed", "1")
    assert "voltage and current swapped" in text
    assert "'estimated'" not in text
    assert int(found(r"at most (\d+) evaluations", text)[1]) <= 20_000


@pytest.mark.study
def test_many_gives_the_same_digits_on_two_processes() -> None:
    text = run("many", "2", "2")
    assert "2 captures, 0 failed" in text
    assert found(r"the same digits +(\w+)", text)[1] == "True"


@pytest.mark.study
def test_review_finds_the_default_at_the_ideal() -> None:
    text = run("review", "--experiments", "2:4", "--jobs", "1")
    for name in SIX[:5]:
        assert float(cells(name, text)[-2]) == pytest.approx(1.0, abs=0.05), name
    assert "goals met" in text


@pytest.mark.study
def test_search_ends_at_the_noise() -> None:
    text = run("search")
    assert "100 candidates x 5000 samples, with friction" in text
    cost = float(found(r"PSO 30 x 100.* cost ([\d.]+)", text)[1])
    assert cost == pytest.approx(0.01, rel=0.05)


@pytest.mark.study
def test_startup_compares_both_commands() -> None:
    text = run("startup", "1")
    assert len(re.findall(r"ms / \d+ ms = \d+\.\d+ \(at most 2\)", text)) == 2


@pytest.mark.study
def test_suspects_names_faults_and_no_others() -> None:
    parts = ("--part", "chain", "--part", "scale", "--part", "clean")
    cases = ("--case", "current saturated", "--case", "mA for A")
    text = run("suspects", *parts, *cases, "--motor", "qube")
    assert cells("current saturated", text)[-2:] == ["2 of 2", "-"]
    assert cells("mA for A", text)[-2:] == ["2 of 2", "-"]
    assert "2 captures without a fault: 0 alarms" in text
    assert "all goals met" in text


@pytest.mark.study
def test_wider_names_a_brush_drop_and_its_size() -> None:
    row = found(r"\nbrush drop 0.15 V +(.*)", run("wider", "brush", "--seeds", "1"))[1].split()
    runs, _, offered, named, sizes, six = row[:6]
    assert (runs, offered, named, sizes, six) == ("1", "1", "1", "2/2", "6/6")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_live_loses_no_sample() -> None:
    chromium.found()
    text = run("live", "--seconds", "2")
    for name in ("samples of the capture", "samples on the page"):
        assert found(rf"{name} +(\d+)", text)[1] == "8000"
    assert found(r"missing on the page +(\d+)", text)[1] == "0"


def test_emulated_boards_sustain_the_highest_rate() -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated board: {lack}")
    text = run("emulated_boards", "--boards", "uno", "--rates", "4000", "--no-search")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if "uno" in line]
    assert [row[:2] for row in rows] == [["uno", "4000"]] * 2
    assert [row[-1] for row in rows] == ["0", "0"]  # samples dropped


@pytest.mark.study
def test_emulated_bursts_find_the_inductance() -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated board: {lack}")
    alone, with_bursts = cells("faulhaber", run("emulated_burst", "uno", "faulhaber-2338s006s"))[1:]
    halves = []
    for cell in (alone, with_bursts):
        error, half = map(float, found(r"(\S+) \((\S+)\)", cell).groups())
        assert abs(error) < 1.5 * half  # 3 standard uncertainties
        halves.append(half)
    assert halves[1] < halves[0]  # by how much the run alone tells it hangs on its noise
    assert halves[1] < 5.0


@pytest.mark.study
def test_verdicts_go_on_where_they_were_stopped(tmp_path: Path) -> None:
    """One motor, then a line that was cut short, then one more: the first is not judged again."""
    rows = tmp_path / "rows.jsonl"
    assert "1 motors, 0 not fitted" in run("verdicts", "1", "--out", str(rows))
    first = rows.read_text(encoding="utf-8")
    rows.write_text(first + '{"motor": 1, "opt', encoding="utf-8")
    text = run("verdicts", "2", "--out", str(rows))
    assert "2 motors, 0 not fitted" in text
    assert text == run("verdicts", "--table", str(rows))
    assert rows.read_text(encoding="utf-8").startswith(first)
    motors = {json.loads(x)["motor"] for x in rows.read_text().splitlines() if x.endswith("}")}
    assert motors == {0, 1}


@pytest.mark.study
def test_history() -> None:
    table = run("history", "40", "file", "1")
    assert "| command | 10 | 20 | 40 | for a million more | at 10,000,000 |" in table
    asked = ("list --serial", "list --outcome FAIL", "list", "trend --last 100", "trend of a month")
    for question in (*asked, "rejudge --stored --jobs 2"):
        cell = r" [\d.]+ \([\d.]+ \+ 0\.00\), \d+ \|"
        assert found(rf"\| {question} \|({cell}){{3}} -?[\d.]+ \| -?[\d.]+ \|", table)


def test_dashboard(tmp_path: Path) -> None:
    place = tmp_path / "line.db"
    with open_history(place) as history:
        line_history.fill(history, 200)
    table = run("dashboard", str(place))
    assert "200 results: CPU, wall, ms" in table
    for question in ("the line's page", "from within a day", "of a motor", "trend --last 100"):
        assert found(rf"\| {question} \| [\d.]+, [\d.]+ \|", table)


@pytest.mark.study
def test_chain_fits_a_rig_with_and_without_what_its_file_states(tmp_path: Path) -> None:
    rows = tmp_path / "chain.jsonl"
    text = run("chain", "--rigs", "1", "--out", str(rows))
    assert "1 rigs fitted both ways, of 1" in text
    for name in SIX:
        assert float(cells(name, text)[-1]) > 1.0, name  # what is stated widens the interval
    assert text == run("chain", "--tables", str(rows))


@pytest.mark.study
@pytest.mark.long
def test_plant_loses_and_doubles_nothing() -> None:
    programs()
    if PROGRAM is None:
        pytest.skip(ABSENT)
    text = run("plant", "--stations", "1", "--inspections", "1", "--replay", "20", "--every", "3")
    assert "1 stations, 1 motors" in text
    assert "20 results by reference" in text
    assert "0 faults" in text


@pytest.mark.study
def test_kit(tmp_path: Path) -> None:
    rows = tmp_path / "kit.json"
    table = json.loads(run("kit", "--rigs", "1", "--out", str(rows)))["table"]
    assert set(table) == set(SIX)
    assert all(row["given"] == 1 for row in table.values())
