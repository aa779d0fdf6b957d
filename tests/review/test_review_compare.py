"""motorid compare: resumable, the same on any number of processes, legible."""

from __future__ import annotations

import csv
import io
import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from motorid.capture.store import save
from motorid.cli.compare import command
from motorid.errors import DataError, UsageError
from motorid.workflow import compare_tables, tasks
from motorid.workflow.compare import compare_captures
from motorid.workflow.compare_files import captures_to_files, tables_to_files
from motorid.workflow.compare_html import convergence, table_page
from motorid.workflow.compare_text import as_csv, as_markdown, page, percent
from motorid.workflow.tasks import Task, run_all
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy

ran: list[int] = []


def work(number: int) -> dict[str, int]:
    ran.append(number)
    if number < 0:
        raise KeyboardInterrupt
    return {"square": number * number}


def task(number: int) -> Task:
    return Task(work, (number,), {"number": number})


@pytest.fixture(autouse=True)
def _fresh():
    ran.clear()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    capture = clean_capture(FAULHABER, Plan(volts=(6.0, 3.0), count=2500))
    capture = noisy(capture, seed=1, current_a=2e-3, angle_rad=2e-3)
    return save(capture, tmp_path_factory.mktemp("capture") / "run.h5")


def test_an_interrupt_keeps_what_was_finished(tmp_path):
    seen = []
    with pytest.raises(KeyboardInterrupt):
        run_all([task(n) for n in (1, 2, -1, 3)], tmp_path, jobs=1)
    assert ran == [1, 2, -1]
    ran.clear()
    results = run_all(
        [task(n) for n in (1, 2, 3)], tmp_path, jobs=1, progress=lambda *at: seen.append(at)
    )
    assert ran == [3]
    assert results == [{"square": 1}, {"square": 4}, {"square": 9}]
    assert seen == [(2, 3), (3, 3)]


def test_a_torn_result_runs_again(tmp_path):
    run_all([task(5)], tmp_path, jobs=1)
    (file,) = tmp_path.glob("*.json")
    file.write_text('{"squ')
    assert run_all([task(5)], tmp_path, jobs=1) == [{"square": 25}]
    assert ran == [5, 5]
    assert json.loads(file.read_text()) == {"square": 25}


def test_a_changed_definition_runs_again(tmp_path):
    run_all([task(5)], tmp_path, jobs=1)
    run_all([Task(work, (5,), {"number": 5, "budget": 2})], tmp_path, jobs=1)
    assert ran == [5, 5]


@pytest.mark.slow
def test_processes_change_no_figure(tmp_path):
    one = compare_tables.compare_table(6, tmp_path / "one", seeds=3, jobs=1)
    two = compare_tables.compare_table(6, tmp_path / "two", seeds=3, jobs=2)
    timeless = [
        [
            [cell for key, cell in line.items() if key != "seconds"]
            for line in csv.DictReader(io.StringIO(as_csv(result)))
        ]
        for result in (one, two)
    ]
    assert timeless[0] == timeless[1]


@pytest.mark.slow
def test_a_table_says_the_reviews_figures_beside_ours(tmp_path):
    result = compare_tables.compare_table(5, tmp_path, seeds=3, jobs=1)
    lines = list(csv.DictReader(io.StringIO(as_csv(result))))
    ciw = next(
        line
        for line in lines
        if (line["experiment"], line["noise"], line["row"], line["quantity"])
        == ("5-prbs", "0", "CIW PSO", "J1")
    )
    assert float(ciw["review_value"]) == 0.00271
    assert float(ciw["review_error_of_nominal_pct"]) == pytest.approx(1.095, abs=1e-3)
    assert float(ciw["review_error_of_estimate_pct"]) == pytest.approx(1.107, abs=1e-3)
    assert float(ciw["of_nominal_median_pct"]) < 1.0
    assert float(ciw["of_nominal_q1_pct"]) <= float(ciw["of_nominal_median_pct"])
    text, html = as_markdown(result), table_page(result)
    for sentence in result.remarks:
        assert sentence in text
    for piece in ("CIW PSO", "of estimate", "review", "quartiles", "Convergence"):
        assert piece in html or piece in page([result])
    assert html.count("<path") > 20
    assert "3 seeds" in page([result])


@pytest.mark.slow
def test_every_row_keeps_its_budget(tmp_path):
    result = compare_tables.compare_table(6, tmp_path, seeds=2, jobs=1)
    for block in result.blocks:
        for line in block.lines:
            assert line.row.method == "ml" or line.summary.evaluations <= line.row.budget


@pytest.mark.slow
def test_methods_on_a_capture(path, tmp_path):
    result = compare_captures(
        [path], tmp_path, methods=["nls", "jaya", "steady-state"], budget=600, seeds=3, jobs=1,
        truth={"K": FAULHABER["K"], "R": FAULHABER["R"]},
    )  # fmt: skip
    by_name = {line.method: line for line in result.lines}
    assert result.lines[0].method == "ml"
    assert set(by_name) == {"ml", "nls", "jaya", "steady-state"}
    assert by_name["ml"].errors["K"].median < 0.5
    assert by_name["nls"].errors["R"].median < 1.0
    assert by_name["jaya"].seeds == 3
    assert by_name["jaya"].evaluations == 600
    assert by_name["jaya"].convergence[0][1] >= by_name["jaya"].convergence[-1][1]
    assert by_name["nls"].cost.median <= by_name["jaya"].cost.median
    costs = [line.cost.median for line in result.lines[1:]]
    assert costs == sorted(costs)


@pytest.mark.slow
def test_a_method_that_finds_nothing_says_why(tmp_path):
    capture = clean_capture(FAULHABER, Plan(volts=(6.0,), count=2000))
    where = save(noisy(capture, 1, 2e-3, 2e-3), tmp_path / "one-level.h5")
    text, _ = captures_to_files(
        [where], tmp_path / "out", methods=["steady-state"], seeds=1, jobs=1
    )
    assert "two voltage levels" in text


@pytest.mark.slow
def test_the_command_writes_goes_on_and_does_not_overwrite(path, tmp_path):
    out = tmp_path / "out"
    args = [str(path), "--method", "gwo", "--budget", "300", "--seeds", "2", "--jobs", "1"]
    first = CliRunner().invoke(command, [*args, "-o", str(out)], catch_exceptions=False)
    assert first.exit_code == 0
    assert re.search(r"^ml ", first.output, re.MULTILINE)
    assert {p.name for p in out.iterdir()} == {"runs", "comparison.html", "comparison.csv"}
    stamps = {p: p.stat().st_mtime_ns for p in (out / "runs").iterdir()}
    assert len(stamps) == 3  # ml once, gwo twice
    with pytest.raises(UsageError, match=r"comparison\.html"):
        CliRunner().invoke(command, [*args, "-o", str(out)], catch_exceptions=False)
    again = CliRunner().invoke(command, [*args, "-o", str(out), "--force"], catch_exceptions=False)
    assert again.exit_code == 0
    assert stamps == {p: p.stat().st_mtime_ns for p in (out / "runs").iterdir()}


@pytest.mark.slow
def test_the_command_rebuilds_tables_and_a_page(tmp_path):
    args = ["--table", "6", "--seeds", "1", "--jobs", "1", "-o", str(tmp_path / "out")]
    page_path = tmp_path / "review.md"
    done = CliRunner().invoke(command, [*args, "--page", str(page_path)], catch_exceptions=False)
    assert done.exit_code == 0
    assert "1.0998" in page_path.read_text(encoding="utf-8")
    assert (tmp_path / "out" / "table-6.html").exists()


@pytest.mark.slow
def test_requests_that_make_no_sense_are_refused(path, tmp_path):
    for args in ([], [str(path), "--table", "5"], [str(path), "--page", "x.md"]):
        refused = CliRunner().invoke(command, [*args, "-o", str(tmp_path)])
        assert refused.exit_code == 2, args
    with pytest.raises(UsageError, match="did you mean 'jaya'"):
        compare_captures([path], tmp_path, methods=["jayaa"])
    with pytest.raises(UsageError, match="a truth is a positive value"):
        compare_captures([path], tmp_path, truth={"Q": 1.0})
    with pytest.raises(UsageError, match="no table 1"):
        tables_to_files([1], tmp_path)
    still = clean_capture({**FAULHABER, "T0": 1.0}, Plan(volts=(0.1,), count=1000))
    where = save(still, tmp_path / "still.h5")
    with pytest.raises(DataError):
        compare_captures([where], tmp_path, jobs=1)


def test_convergence_draws_every_curve_and_survives_zero_cost():
    drawn = convergence([("a", [(1.0, 1.0), (10.0, 0.0)]), ("b", []), ("c", [(1, 2), (5, 1)])])
    assert drawn.count('class="c') >= 2
    assert "nan" not in drawn
    assert convergence([("b", [])]) == ""


def test_percents_have_two_digits():
    assert [percent(x) for x in (0.0, 0.809, 12.34, 161.4, 0.00042, 3e-13)] == [
        "0", "0.81", "12", "161", "4e-4", "3e-13",
    ]  # fmt: skip
    assert np.isfinite(float(percent(9.99e-4)))


def test_tasks_module_is_plain_data():
    assert tasks.Task(work, (1,), {"a": np.float64(1.0)}).digest == (
        tasks.Task(work, (1,), {"a": np.float64(1.0)}).digest
    )
