"""A change of limits from stored values: the database's short cut against judging every result."""

from __future__ import annotations

import csv
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from bench import line_history
from motorid.cli.main import run
from motorid.quality.guard_band import RULES, Rule, accepts
from motorid.quality.history import History, MeasurementRecord, Query, open_history
from motorid.quality.history.candidates import bounds
from motorid.quality.product import Product, load_product
from motorid.quality.stored_verdict import Stored, judge_stored, surely_within
from motorid.workflow import rejudge_stored as workflow
from tests.history.records import record
from tests.history.servers import running

PRODUCT = load_product("sim-disc")
COUNT = 400


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> str:
    found = tmp_path_factory.mktemp("stored") / "line.db"
    with open_history(found) as history:
        line_history.fill(history, COUNT)
    return str(found)


@pytest.fixture
def history(place: str) -> Iterator[History]:
    with open_history(place, create=False) as found:
        yield found


def limited(**changes: object) -> Product:
    """The product with these changed in the limit of R_25."""
    return replace(
        PRODUCT, limits={**PRODUCT.limits, "R_25": replace(PRODUCT.limits["R_25"], **changes)}
    )


def one_by_one(history: History, product: Product, query: Query) -> Counter[tuple[str, str]]:
    found: Counter[tuple[str, str]] = Counter()
    for row in history.results(query):
        rows = history.measurements(row.id)
        stored = [Stored(m.name, m.unit, m.value, m.uncertainty, m.outcome, m.reason) for m in rows]
        after = str(judge_stored(stored, product).outcome)
        if after != row.outcome:
            found[row.outcome, after] += 1
    return found


@pytest.mark.slow
def test_the_same_limits_give_every_outcome_again(history: History) -> None:
    """Passed, failed and not to be judged, as ``judge`` had them."""
    assert {row.outcome for row in history.results()} == {"PASS", "FAIL", "INVALID"}
    found = workflow.rejudge_stored(history, PRODUCT, Query())
    assert (found.judged, found.rows) == (COUNT, [])


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"low": 2.55},
        {"low": 2.0, "high": 3.5},
        *({"rule": Rule(name, process_mean=2.6, process_sd=0.04)} for name in RULES),
        {"rule": Rule("uncertainty", r=-1.0)},
        {"rule": Rule("specific_risk", consumer_risk=1e-6), "low": 2.5},
    ],
    ids=str,
)
@pytest.mark.parametrize("query", [Query(), Query(station="line-03")], ids=["all", "station"])
def test_no_result_that_changes_is_passed_over(
    history: History, monkeypatch: pytest.MonkeyPatch, changes: dict[str, object], query: Query
) -> None:
    product = limited(**changes)
    monkeypatch.setattr(workflow, "AT_ONCE", 70)
    found = workflow.rejudge_stored(history, product, query)
    assert found.outcomes == one_by_one(history, product, query)
    assert found.judged == history.count(query)


def test_what_is_sure_is_accepted_by_each_rule() -> None:
    rng = random.Random(3)
    for _ in range(2000):
        rule = Rule(
            rng.choice(RULES), rng.uniform(-1.0, 2.0), 2.0, 10 ** rng.uniform(-6.0, -0.5), 2.6, 0.04
        )
        u, side = rng.choice([0.0, 10 ** rng.uniform(-4.0, -1.0)]), rng.choice([2.4, -9.0])
        value = side + surely_within(rule) * u + rng.uniform(0.0, 1e-3) if side > 0 else 2.6
        if value + surely_within(rule) * u <= 2.8:
            assert accepts(value, u, side, 2.8, rule)


@pytest.mark.slow
def test_ranges_hold_each_result_once(history: History) -> None:
    for count in (1, 7, COUNT, 10 * COUNT):
        found = bounds(history, Query(), count)
        assert all(a[1] == b[0] for a, b in pairwise(found))
        ids = [row.id for row in history.results()]
        held = [sum(low < one <= high for one in ids) for low, high in found]
        assert sum(held) == COUNT
        assert max(held) <= count
    assert bounds(history, Query(product="none"), 10) == []


@pytest.mark.slow
def test_quantities_that_were_not_measured_or_have_no_limit_now(tmp_path: Path) -> None:
    def measured(name: str, value: float | None, outcome: str) -> MeasurementRecord:
        return MeasurementRecord(name, "1", value, 0.0, 0.0, 1.0, 0.0, outcome, reason="why")

    good = [measured(name, 0.5 * (one.low + one.high) if one.low > 0 else 0.0, "PASS")
            for name, one in PRODUCT.limits.items()]  # fmt: skip
    cases = {  # by serial number: what is stored, and its outcome by the product of today
        "good": (good, "PASS"),
        "not measured": (good[1:], "INVALID"),
        "no value": ([measured("R_25", None, "INVALID"), *good[1:]], "INVALID"),
        "without a limit now": ([measured("K", 9.0, "FAIL"), *good], "PASS"),
        "bad condition": ([measured("run_complete", 0.0, "INVALID"), *good], "INVALID"),
        "fails, and does not fit": (
            [measured("model_fits", 0.0, "INVALID"), measured("R_25", 9.0, "FAIL"), *good[1:]],
            "FAIL",
        ),
        "does not run": ([measured("motor_runs", 0.0, "FAIL")], "FAIL"),
    }
    with open_history(tmp_path / "line.db") as history:
        for number, (serial, (rows, _)) in enumerate(cases.items()):
            bare = replace(record(number), serial=serial, product=PRODUCT.name, outcome="before")
            history.add(replace(bare, measurements=tuple(rows)))
        found = workflow.rejudge_stored(history, PRODUCT, Query(outcome="before"))
    after = {row[2]: row[5] for row in found.rows}
    assert after.pop("good", "PASS") == "PASS"  # all passed: nothing of it is looked at
    assert after == {serial: outcome for serial, (_, outcome) in cases.items()
                     if serial != "good"}  # fmt: skip


def test_the_command_and_its_table(
    place: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    tight, out = tmp_path / "tight.toml", tmp_path / "changes.csv"
    tight.write_text(PRODUCT.text.replace("low = 2.4\nhigh = 2.8", "low = 2.5\nhigh = 2.8"))
    call = ["history", "rejudge", place, "--product", str(tight), "--stored", "-o", str(out)]
    assert run(call) == 0
    said = capfd.readouterr().out
    with out.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert f"{COUNT} results judged from stored values, {len(rows)} change" in said
    assert {(row["before"], row["after"]) for row in rows} == {("PASS", "FAIL")}
    assert all("too near its limit 2.5" in r["reason"] or "too low" in r["reason"] for r in rows)
    with open_history(place, create=False) as history:
        assert history.count() == COUNT  # nothing was added
        assert history.result(int(rows[0]["id"])).serial == rows[0]["serial"]
    assert run(call) == 2
    assert "exists already" in capfd.readouterr().err
    plain = ["history", "rejudge", place, "--product", "sim-disc"]
    assert run([*plain, "-o", str(out)]) == 2
    assert run([*plain, "--stored", "--captures", str(tmp_path)]) == 2
    assert run([*plain, "--stored", "--serial", "none"]) == 4


@pytest.mark.slow
def test_two_processes_say_the_same(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workflow, "AT_ONCE", 90)
    product = limited(low=2.5)
    with open_history(place, create=False) as history:
        alone = workflow.rejudge_stored(history, product, Query())
        assert workflow.rejudge_stored(history, product, Query(), jobs=2) == alone


@pytest.mark.slow
@pytest.mark.long
def test_postgresql_says_the_same(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Over three months, so that ranges cross them."""
    monkeypatch.setattr(workflow, "AT_ONCE", 7)
    drawn = random.Random(5)
    with running() as server, open_history(server.database("stored")) as history:
        with open_history(tmp_path / "line.db") as file:
            for number in range(60):
                made = record(number)
                value = drawn.uniform(2.3, 2.9)
                one = MeasurementRecord("R_25", "ohm", value, 0.01, 2.4, 2.8, 0.02, "PASS")
                at = made.at.replace(month=1 + number % 3)
                made = replace(made, at=at, product=PRODUCT.name, measurements=(one,))
                history.add(made)
                file.add(made)
            product = replace(PRODUCT, limits={"R_25": PRODUCT.limits["R_25"]})
            found = workflow.rejudge_stored(history, product, Query())
            assert found.outcomes == workflow.rejudge_stored(file, product, Query()).outcomes
        assert 0 < len(found.rows) < 60
        assert found.outcomes == one_by_one(history, product, Query())
