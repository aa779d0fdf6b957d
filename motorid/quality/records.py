"""A verdict for other programs: JSON, JUnit XML, CSV, and the record that OpenHTF writes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any
from xml.etree import ElementTree

from motorid import csv_text, json_text
from motorid.json_seal import sealed
from motorid.quality.verdict import Measurement, Outcome, Verdict

SCHEMA = "motorid-verdict-1"
COLUMNS = (
    "time", "product", "serial", "verdict", "quantity", "value", "uncertainty", "unit", "low",
    "high", "rule", "guard_band", "conformance", "outcome", "marginal", "reason", "capture_sha256",
)  # fmt: skip
NOBODY: Mapping[str, str] = {}
OPENHTF_OUTCOME = {Outcome.PASS: "PASS", Outcome.FAIL: "FAIL", Outcome.INVALID: "ERROR"}
OPENHTF_MEASUREMENT = {Outcome.PASS: "PASS", Outcome.FAIL: "FAIL", Outcome.INVALID: "UNSET"}


def to_dict(
    verdict: Verdict, *, time: datetime | None = None, who: Mapping[str, str] = NOBODY
) -> dict[str, Any]:
    """Plain data with its digest; a limit that is not there, a value that is not known are null."""
    said: dict[str, Any] = {
        "schema": SCHEMA,
        "time": _stamp(time),
        "product": verdict.product,
        "serial": verdict.serial,
        "outcome": str(verdict.outcome),
        "marginal": verdict.marginal,
        "reasons": list(verdict.reasons),
        "measurements": [_measurement(m) for m in verdict.measurements],
        "inputs": [dict(i) for i in verdict.inputs],
        "versions": dict(verdict.versions),
    }
    said |= {name: value for name, value in who.items() if value}
    return sealed(said)


def to_json(
    verdict: Verdict, *, time: datetime | None = None, who: Mapping[str, str] = NOBODY
) -> str:
    """Strict JSON, ending in a newline. ``who``: the station and its operator, where known."""
    return json_text.dumps(to_dict(verdict, time=time, who=who), indent=2) + "\n"


def to_junit(verdict: Verdict, *, time: datetime | None = None) -> str:
    """One test case a measurement: FAIL is a failure, INVALID an error."""
    counts = {o: sum(m.outcome is o for m in verdict.measurements) for o in Outcome}
    suite = ElementTree.Element(
        "testsuite",
        name=_xml(verdict.product),
        tests=str(len(verdict.measurements)),
        failures=str(counts[Outcome.FAIL]),
        errors=str(counts[Outcome.INVALID]),
        timestamp=_stamp(time),
        id=_xml(verdict.serial),
    )
    for m in verdict.measurements:
        case = ElementTree.SubElement(
            suite, "testcase", classname=_xml(verdict.serial or verdict.product), name=m.quantity
        )
        if m.outcome is not Outcome.PASS:
            kind = "failure" if m.outcome is Outcome.FAIL else "error"
            label = "MARGINAL" if m.marginal else str(m.outcome)
            ElementTree.SubElement(case, kind, message=_xml(m.reason), type=label)
        ElementTree.SubElement(case, "system-out").text = _xml(_sentence(m))
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"


def to_csv(verdicts: Sequence[Verdict], *, time: datetime | None = None) -> str:
    """One row a measurement, with a header."""
    rows = (_row(verdict, m, _stamp(time)) for verdict in verdicts for m in verdict.measurements)
    return csv_text.table(COLUMNS, ([row[name] for name in COLUMNS] for row in rows), end="\n")


def to_openhtf(
    verdict: Verdict,
    *,
    station: str = "",
    operator: str = "",
    begin: datetime | None = None,
    end: datetime | None = None,
) -> dict[str, Any]:
    """A test record as OpenHTF's JSON output has it, with one phase.

    ``operator`` goes into its metadata: OpenHTF has no field of its own for one.
    """
    start = _milliseconds(begin)
    stop = max(_milliseconds(end), start)
    measurements = {m.quantity: _openhtf(m) for m in verdict.measurements}
    outcome = OPENHTF_OUTCOME[verdict.outcome]
    phase = {
        "name": "motorid_check",
        "outcome": "PASS" if verdict.outcome is Outcome.PASS else outcome,
        "measurements": measurements,
        "attachments": {},
        "start_time_millis": start,
        "end_time_millis": stop,
        "options": {"name": None},
        "codeinfo": {"name": "motorid.quality", "docstring": None, "sourcecode": ""},
    }
    return {
        "dut_id": verdict.serial,
        "station_id": station,
        "start_time_millis": start,
        "end_time_millis": stop,
        "outcome": outcome,
        "outcome_details": [{"code": str(verdict.outcome), "description": r}
                            for r in verdict.reasons],
        "metadata": {
            "test_name": verdict.product,
            **({"operator": operator} if operator else {}),
            "versions": dict(verdict.versions),
            "captures": [str(i.get("sha256", "")) for i in verdict.inputs],
        },
        "phases": [phase],
        "log_records": [],
    }  # fmt: skip


def _measurement(m: Measurement) -> dict[str, Any]:
    return {
        "quantity": m.quantity,
        "meaning": m.meaning,
        "value": _finite(m.reading.value),
        "uncertainty": _finite(m.reading.uncertainty),
        "unit": m.reading.unit,
        "low": _finite(m.limit.low),
        "high": _finite(m.limit.high),
        "rule": m.limit.rule.name,
        "guard_band": _finite(m.guard_band),
        "conformance": _finite(m.conformance),
        "condition": m.limit.condition,
        "outcome": str(m.outcome),
        "marginal": m.marginal,
        "reason": m.reason,
    }


def _row(verdict: Verdict, m: Measurement, stamp: str) -> dict[str, Any]:
    plain = {k: "" if v is None else v for k, v in _measurement(m).items() if k in COLUMNS}
    return {
        **plain,
        "time": stamp,
        "product": verdict.product,
        "serial": verdict.serial,
        "verdict": str(verdict.outcome),
        "capture_sha256": " ".join(str(i.get("sha256", "")) for i in verdict.inputs),
    }


def _openhtf(m: Measurement) -> dict[str, Any]:
    ends = [f"{n} {b:g}" for n, b in (("low", m.limit.low), ("high", m.limit.high))
            if math.isfinite(b)]  # fmt: skip
    out: dict[str, Any] = {
        "name": m.quantity,
        "outcome": OPENHTF_MEASUREMENT[m.outcome],
        "measured_value": _finite(m.reading.value),
        "docstring": m.meaning,
        "validators": [f"{m.limit.rule.name}: {', '.join(ends)}"],
        "marginal": m.marginal,
    }
    return out | ({} if m.limit.unit == "1" else {"units": m.limit.unit})


def _sentence(m: Measurement) -> str:
    value = "not measured" if m.reading.value is None else f"{m.reading.value:.6g}"
    u = "" if m.reading.uncertainty is None else f" (u = {m.reading.uncertainty:.2g})"
    return f"{m.meaning}: {value} {m.reading.unit}{u}, limits {m.limit.low:g} to {m.limit.high:g}"


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _stamp(time: datetime | None) -> str:
    return (time or datetime.now(UTC)).isoformat(timespec="milliseconds")


def _milliseconds(time: datetime | None) -> int:
    return round((time or datetime.now(UTC)).timestamp() * 1000)


def _xml(text: str) -> str:
    """Without the characters that XML 1.0 cannot hold."""
    return "".join(
        c
        for c in text
        if c in "\t\n\r" or " " <= c <= "\ud7ff" or (c >= "\ue000" and c not in "\ufffe\uffff")
    )
