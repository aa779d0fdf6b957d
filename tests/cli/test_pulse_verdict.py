"""What a weak pulse says of signs, counts and scales, by its figures alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from motorid.rig import Rig
from motorid.workflow.kit import Answers, kit
from motorid.workflow.pulse_verdict import Verdict, verdicts

OHM, CONSTANT, COUNTS = 6.0, 0.01, 2048  # of a motor of 12 V
SAID = Answers(
    "other", "sim://", "drv8871", "acs712-05", COUNTS, 12.0, "x", 12.0, resistance_ohm=OHM
)
GOOD: dict[str, Any] = {  # 1.2 V: 0.2 A at the start, 100 rad/s at its end
    "duty": 0.1,
    "volts": 1.2,
    "counts": 2000,
    "counts_per_s": 100.0 * COUNTS / 6.2832,
    "current_a": 0.05,
    "peak_a": 0.17,
    "voltage_v": 1.15,
    "coast_v": 0.95,
    "zero_a": 0.01,
    "zero_uncertainty_a": 0.02,
    "supply_v": 12.1,
}


def rig(**changes: Any) -> Rig:
    return kit(replace(SAID, **changes), "bench", "").rig


def of(what: str, seen: dict[str, Any], wired: Rig, constant: float | None = CONSTANT) -> Verdict:
    (found,) = (one for one in verdicts(wired, GOOD | seen, constant) if one.of == what)
    return found


def test_everything_of_a_good_bench_is_right() -> None:
    found = list(verdicts(rig(), GOOD, CONSTANT))
    assert [one.of for one in found] == ["signs", "counts", "current", "zero", "voltage", "supply"]
    assert {one.word for one in found} == {"right"}
    assert found[0].line().startswith("signs    right: +1.2 V")


@pytest.mark.parametrize(
    ("what", "seen", "word", "told"),
    [
        ("counts", {"counts_per_s": 4 * GOOD["counts_per_s"]}, "wrong", "by hand and count"),
        ("counts", {"counts_per_s": GOOD["counts_per_s"] / 4}, "wrong", "by hand and count"),
        ("counts", {"coast_v": 0.4}, "cannot be told", "by hand and count"),
        ("counts", {"coast_v": 0.1}, "cannot be told", "hardly turned"),
        ("counts", {"coast_v": None}, "cannot be told", "shaft turned so far"),
        ("current", {"current_a": 0.4, "peak_a": 1.3}, "wrong", "volts per ampere"),
        ("current", {"current_a": 0.005, "peak_a": 0.03}, "cannot be told", "with a meter"),
        ("current", {"current_a": 0.01, "peak_a": 0.03, "coast_v": 0.6}, "wrong", "volts per"),
        ("zero", {"zero_a": -0.2}, "wrong", "the right sensor"),
        ("voltage", {"voltage_v": 0.6}, "wrong", "divider"),
        ("voltage", {"voltage_v": 2.4}, "wrong", "divider"),
        ("supply", {"supply_v": 6.0}, "wrong", "divider"),
    ],
)
def test_what_is_off_is_named_with_what_to_do(
    what: str, seen: dict[str, Any], word: str, told: str
) -> None:
    found = of(what, seen, rig())
    assert found.word == word
    assert told in found.said


def test_what_nobody_stated_cannot_be_told() -> None:
    unknown = rig(resistance_ohm=None)
    assert of("current", {}, unknown).word == "cannot be told"
    assert "--resistance" in of("current", {}, unknown).said
    assert "--rpm" in of("counts", {}, rig(), None).said
    unstated = replace(rig(), supply_voltage_v=None)
    assert of("supply", {}, unstated).word == "cannot be told"


def test_a_bipolar_bridge_keeps_what_it_drops_and_no_more() -> None:
    l298n = rig(driver="l298n")
    assert of("voltage", {"voltage_v": 0.3, "volts": 2.4}, l298n).word == "right"
    assert of("voltage", {"voltage_v": 2.0, "volts": 6.0}, l298n).word == "wrong"


def test_without_a_voltage_at_the_motor_the_bridge_counts() -> None:
    """It and what it drops are between supply and motor."""
    blind = {"voltage_v": None, "coast_v": None, "volts": 3.0}
    assert of("current", blind | {"peak_a": 0.2}, rig(driver="l298n")).word == "right"
    assert of("current", blind | {"peak_a": 0.2}, rig()).word == "cannot be told"
