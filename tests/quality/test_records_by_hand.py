"""Each field of the records for other programs, of a verdict that was made by hand."""

from __future__ import annotations

import csv
import io
import json
import math
from datetime import UTC, datetime, timedelta
from xml.etree import ElementTree

import pytest

from motorid.quality.guard_band import Rule
from motorid.quality.limits import Limit
from motorid.quality.records import COLUMNS, to_csv, to_dict, to_json, to_junit, to_openhtf
from motorid.quality.verdict import Reading, Verdict, decide

AT = datetime(2026, 11, 20, 6, 30, 15, 123456, tzinfo=UTC)
STAMP = "2026-11-20T06:30:15.123+00:00"
RIPPLE = Reading("1", 0.75, 0.1)
MADE = (
    decide(Limit("R_25", "ohm", 2.4, 2.8), Reading("ohm", 2.6, 0.01), "resistance"),
    decide(Limit("K_25", "N·m/A", 1.0), Reading("N·m/A", 1.01, 0.01), "constant"),
    decide(Limit("ripple_turn", "1", high=0.5, rule=Rule("simple")), RIPPLE, "ripple"),
    decide(Limit("J", "kg·m²", 0.0, 1.0), Reading("kg·m²", problem="lost"), "inertia"),
)  # fmt: skip
VERDICT = Verdict("pump\x07", "S\x001", MADE, ({"sha256": "aa"}, {"sha256": "bb"}, {}), {"v": "1"})


def test_a_verdict_as_json() -> None:
    found = to_dict(VERDICT, time=AT, who={"station": "left", "operator": ""})
    assert (found["schema"], found["time"]) == ("motorid-verdict-1", STAMP)
    assert (found["product"], found["serial"], found["outcome"]) == ("pump\x07", "S\x001", "FAIL")
    assert (found["marginal"], found["station"], "operator" in found) == (False, "left", False)
    assert found["reasons"] == list(VERDICT.reasons)
    assert (found["inputs"], found["versions"]) == ([*VERDICT.inputs], {"v": "1"})
    resistance, constant, ripple, inertia = found["measurements"]
    assert resistance == {
        "quantity": "R_25", "meaning": "resistance", "value": 2.6, "uncertainty": 0.01,
        "unit": "ohm", "low": 2.4, "high": 2.8, "rule": "uncertainty", "guard_band": 0.02,
        "conformance": pytest.approx(1.0), "condition": False, "outcome": "PASS",
        "marginal": False, "reason": "",
    }  # fmt: skip
    assert (constant["high"], constant["marginal"], constant["outcome"]) == (None, True, "FAIL")
    assert (ripple["low"], ripple["rule"], ripple["guard_band"]) == (None, "simple", 0.0)
    assert (inertia["value"], inertia["conformance"]) == (None, None)
    assert inertia["reason"] == "inertia: lost"
    text = to_json(VERDICT, time=AT)
    assert text.endswith("}\n")
    assert text.startswith('{\n  "')
    assert json.loads(text)["measurements"] == found["measurements"]


def test_a_verdict_as_junit() -> None:
    (suite,) = ElementTree.fromstring(to_junit(VERDICT, time=AT))
    assert suite.attrib == {
        "name": "pump", "tests": "4", "failures": "2", "errors": "1", "timestamp": STAMP,
        "id": "S1",
    }  # fmt: skip
    cases = suite.findall("testcase")
    assert [(one.get("classname"), one.get("name")) for one in cases] == [
        ("S1", name) for name in ("R_25", "K_25", "ripple_turn", "J")
    ]
    kinds = [(one[0].tag, one[0].get("type"), one[0].get("message")) for one in cases[1:]]
    assert kinds == [
        ("failure", "MARGINAL", MADE[1].reason), ("failure", "FAIL", MADE[2].reason),
        ("error", "INVALID", "inertia: lost"),
    ]  # fmt: skip
    assert [one.findtext("system-out") for one in cases] == [
        "resistance: 2.6 ohm (u = 0.01), limits 2.4 to 2.8",
        "constant: 1.01 N·m/A (u = 0.01), limits 1 to inf",
        "ripple: 0.75 1 (u = 0.1), limits -inf to 0.5",
        "inertia: not measured kg·m², limits 0 to 1",
    ]
    nameless = ElementTree.fromstring(to_junit(Verdict("pump", "", MADE[:1]), time=AT))
    assert [one.get("classname") for one in nameless.iter("testcase")] == ["pump"]
    odd = "a\tb\nc\rd\ud7ff\ue000\U0001f600"
    suite = ElementTree.fromstring(to_junit(Verdict(f"\ufffe\uffff{odd}\x0b", "", MADE[:1])))[0]
    assert suite.get("name") == odd


def test_a_verdict_as_csv() -> None:
    text = to_csv([VERDICT, VERDICT], time=AT)
    assert "\r" not in text
    rows = list(csv.DictReader(io.StringIO(text)))
    assert (tuple(rows[0]), len(rows)) == (COLUMNS, 8)
    assert rows[0]["time"] == STAMP
    assert (rows[0]["verdict"], rows[0]["outcome"], rows[0]["marginal"]) == (
        "FAIL",
        "PASS",
        "False",
    )
    assert (rows[0]["low"], rows[0]["high"], rows[0]["value"]) == ("2.4", "2.8", "2.6")
    assert rows[1]["capture_sha256"] == "aa bb "
    assert (rows[3]["value"], rows[3]["reason"]) == ("", "inertia: lost")


def test_a_verdict_as_openhtf() -> None:
    end = AT + timedelta(seconds=2.5)
    found = to_openhtf(VERDICT, station="left", operator="kim", begin=AT, end=end)
    begun = round(AT.timestamp() * 1000)
    for one in (found, found["phases"][0]):
        assert (one["start_time_millis"], one["end_time_millis"]) == (begun, begun + 2500)
        assert one["outcome"] == "FAIL"
    assert (found["dut_id"], found["station_id"]) == ("S\x001", "left")
    assert found["outcome_details"] == [
        {"code": "FAIL", "description": reason} for reason in VERDICT.reasons
    ]
    assert found["metadata"] == {
        "test_name": "pump\x07", "operator": "kim", "versions": {"v": "1"},
        "captures": ["aa", "bb", ""],
    }  # fmt: skip
    measured = found["phases"][0]["measurements"]
    assert measured["R_25"] == {
        "name": "R_25", "outcome": "PASS", "measured_value": 2.6, "docstring": "resistance",
        "validators": ["uncertainty: low 2.4, high 2.8"], "marginal": False, "units": "ohm",
    }  # fmt: skip
    assert "units" not in measured["ripple_turn"]
    assert measured["ripple_turn"]["validators"] == ["simple: high 0.5"]
    assert (measured["K_25"]["validators"], measured["K_25"]["marginal"]) == (
        ["uncertainty: low 1"], True,
    )  # fmt: skip
    assert (measured["J"]["outcome"], measured["J"]["measured_value"]) == ("UNSET", None)
    backwards = to_openhtf(VERDICT, begin=end, end=AT)
    assert backwards["end_time_millis"] == backwards["start_time_millis"] == begun + 2500
    assert (backwards["station_id"], "operator" in backwards["metadata"]) == ("", False)
    good = to_openhtf(Verdict("pump", "1", MADE[:1]))
    assert (good["outcome"], good["phases"][0]["outcome"]) == ("PASS", "PASS")


def test_no_number_is_null() -> None:
    strange = decide(Limit("x", "1", high=1.0), Reading("1", math.inf, math.nan), "x")
    (said,) = to_dict(Verdict("p", "", (strange,)))["measurements"]
    assert (said["value"], said["uncertainty"], said["outcome"]) == (None, None, "INVALID")
