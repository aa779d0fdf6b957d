"""A study of detection power, for a terminal and for a script."""

from __future__ import annotations

from typing import Any

from motorid.quality.agreement import Share
from motorid.quality.detection import Found
from motorid.quality.power import Power, Study
from motorid.report.gauge import columns
from motorid.report.numbers import scaled_unit, significant

POWER_SCHEMA = "motorid-power-1"
HALF, MOST = 0.5, 0.95


def text(study: Study) -> str:
    """The study as a table, with the false rejects above it."""
    head = ["defect", "found in 50 %", "95 % interval", "found in 95 %", "95 % interval",
            "not passed", "by"]  # fmt: skip
    return "\n".join([f"{study.product} on {study.rig}", false_rejects(study), "",
                      *columns(head, [_row(one) for one in study.powers])])  # fmt: skip


def false_rejects(study: Study) -> str:
    """How many good motors did not pass, and why."""
    share = Share(study.rejected, study.good)
    low, high = share.interval_95
    said = (
        f"good motors: {study.rejected} of {study.good} did not pass, {100 * share.value:.1f} % "
        f"(95 % interval {100 * low:.1f} to {100 * high:.1f})"
    )
    if study.rejected:
        said += f"; {study.invalid} INVALID; by {', '.join(study.named)}"
    if 2 * study.rejected > study.good:
        said += (
            f"\nmost good motors do not pass, so the table says little: is {study.rig} the rig of "
            "this product, and --spread that of its motors?"
        )
    return said


def _row(one: Power) -> list[str]:
    unit, f = _unit(one)
    half, most = one.trials.severity(HALF), one.trials.severity(MOST)
    hits = sum(one.trials.found)
    invalid = f", {one.invalid} INVALID" if one.invalid else ""
    return [
        f"{one.title}, {unit}", *_found(one, half, f), *_found(one, most, f),
        f"{hits} of {len(one.trials.found)}{invalid}", ", ".join(one.named) or "—",
    ]  # fmt: skip


def _unit(one: Power) -> tuple[str, float]:
    if one.unit == "1":
        return "%", 100.0
    return scaled_unit(one.unit, one.trials.range.most)


def _found(one: Power, found: Found, factor: float) -> list[str]:
    """The value and its interval; what lies beyond the range is said as more than its end."""
    limits = one.trials.range
    beyond = f"above {significant(limits.most * factor, 2)}"

    def shown(value: float | None) -> str:
        if value is None:
            return beyond
        if value < limits.least:
            return f"below {significant(limits.least * factor, 2)}"
        return significant(value * factor, 2)

    if found.low >= limits.most:
        return [beyond, "—"]
    return [shown(found.value), f"{shown(found.low)} to {shown(found.high)}"]


def to_dict(study: Study) -> dict[str, Any]:
    """Plain data of the study, with every trial."""
    share = Share(study.rejected, study.good)
    return {
        "schema": POWER_SCHEMA,
        "product": study.product,
        "rig": study.rig,
        "spread": dict(study.spread),
        "false_rejects": {
            "good": study.good,
            "not_passed": study.rejected,
            "invalid": study.invalid,
            "share": share.value,
            "interval_95": list(share.interval_95),
            "by": list(study.named),
        },
        "defects": [_defect(one) for one in study.powers],
    }


def _defect(one: Power) -> dict[str, Any]:
    trials = one.trials
    return {
        "name": one.name,
        "title": one.title,
        "unit": one.unit,
        "option": one.option,
        "tried": [trials.range.least, trials.range.most],
        "found_in_50_percent": vars(trials.severity(HALF)),
        "found_in_95_percent": vars(trials.severity(MOST)),
        "not_passed": sum(trials.found),
        "invalid": one.invalid,
        "by": list(one.named),
        "trials": [
            {"severity": severity, "found": found}
            for severity, found in zip(trials.severities, trials.found, strict=True)
        ],
    }
