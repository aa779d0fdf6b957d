"""The records that other programs read."""

from __future__ import annotations

import csv
import io
import json
from xml.etree import ElementTree

import pytest

from motorid.estimate.results.estimate import Estimate
from motorid.quality.judge import judge, not_measured
from motorid.quality.limits import Limit
from motorid.quality.product import Product
from motorid.quality.records import to_csv, to_dict, to_json, to_junit, to_openhtf
from motorid.quality.verdict import Reading, Verdict, decide


@pytest.fixture(scope="module")
def verdict(estimate: Estimate, product: Product) -> Verdict:
    return judge(estimate, product)


@pytest.fixture(scope="module")
def mixed() -> Verdict:
    limit = Limit("R_25", "ohm", 2.4, 2.8)
    readings = [Reading("ohm", 2.6, 0.01), Reading("ohm", 2.79, 0.01), Reading("ohm", problem="?")]
    return Verdict("p", "S<1>\x07", tuple(decide(limit, r, "R & co") for r in readings))


def test_json_is_strict_and_whole(verdict: Verdict) -> None:
    read = json.loads(to_json(verdict))
    assert read["outcome"] == "PASS"
    assert {m["quantity"] for m in read["measurements"]} >= {"R_25", "ripple_segment"}
    assert len(read["inputs"][0]["sha256"]) == 64
    assert len(read["versions"]["product"]) == 64
    json.dumps(to_dict(verdict), allow_nan=False)


def test_junit_counts(mixed: Verdict) -> None:
    suite = ElementTree.fromstring(to_junit(mixed))[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("3", "1", "1")
    failure = suite.find("testcase/failure")
    assert failure is not None
    assert failure.get("type") == "MARGINAL"


def test_csv_has_a_row_a_measurement(mixed: Verdict) -> None:
    rows = list(csv.DictReader(io.StringIO(to_csv([mixed, mixed]))))
    assert [row["outcome"] for row in rows] == ["PASS", "FAIL", "INVALID"] * 2
    assert rows[1]["marginal"] == "True"
    assert rows[2]["value"] == ""


def test_the_openhtf_record(mixed: Verdict, product: Product) -> None:
    record = to_openhtf(mixed, station="one")
    assert record["outcome"] == "FAIL"
    assert record["dut_id"] == mixed.serial
    measured = record["phases"][0]["measurements"]["R_25"]
    assert (measured["outcome"], measured["units"]) == ("UNSET", "ohm")
    assert to_openhtf(not_measured(product, "x", "y"))["outcome"] == "ERROR"
