"""Attribute studies and comparisons of stations against published examples."""

from __future__ import annotations

import json
import math
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import ttest_rel

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.agreement import Share, agreement, cohen, fleiss, ratings_of
from motorid.quality.history import open_history
from motorid.quality.history.records import MeasurementRecord, ResultRecord
from motorid.quality.stations import Reading, compare
from motorid.report.agreement import stations_text

# AIAG MSA 4th edition, chapter III section C: cross tabulations of 150 decisions, and kappa
AIAG_TABLES = {
    "A with B": ([[44, 6], [3, 97]], 0.86),
    "B with C": ([[42, 5], [9, 94]], 0.79),
    "A with C": ([[43, 7], [8, 92]], 0.78),
    "A with the reference": ([[45, 5], [3, 97]], 0.88),
    "B with the reference": ([[45, 2], [3, 100]], 0.92),
    "C with the reference": ([[42, 9], [6, 93]], 0.77),
}
# Fleiss' kappa as Wikipedia works it out: 14 raters, 10 subjects, 5 categories
FLEISS = [
    [0, 0, 0, 0, 14], [0, 2, 6, 4, 2], [0, 0, 3, 5, 6], [0, 3, 9, 2, 0], [2, 2, 8, 1, 1],
    [7, 7, 0, 0, 0], [3, 2, 6, 3, 0], [2, 5, 3, 2, 2], [6, 5, 2, 1, 0], [0, 2, 2, 3, 7],
]  # fmt: skip
# Agresti, Categorical Data Analysis: two pathologists, 118 slides; kappa 0.493, standard error
# 0.057
PATHOLOGISTS = [[22, 2, 2, 0], [5, 7, 14, 0], [0, 2, 36, 0], [0, 1, 17, 10]]
# Bland and Altman 1986: peak flow by two meters, l/min
WRIGHT = (494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427)
MINI = (512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451)


@pytest.mark.parametrize("name", AIAG_TABLES)
def test_kappa_of_the_aiag(name: str) -> None:
    table, printed = AIAG_TABLES[name]
    assert round(float(cohen(np.array([table]))[0]), 2) == printed


def test_effectiveness_of_the_aiag() -> None:
    """Right of 50 parts, with the exact interval: A, B and C."""
    printed = {42: (84, 71, 93), 45: (90, 78, 97), 40: (80, 66, 90)}
    for found, expected in printed.items():
        share = Share(found, 50)
        low, high = share.interval_95
        assert [round(100 * x) for x in (share.value, low, high)] == list(expected)
    # of 1 in 20 every table of Clopper and Pearson has 0.13 % to 24.87 %
    assert Share(1, 20).interval_95 == pytest.approx((0.0013, 0.2487), abs=5e-5)
    assert Share(19, 20).interval_95 == pytest.approx((0.7513, 0.9987), abs=5e-5)
    assert Share(0, 50).interval_95[0] == 0.0
    assert Share(50, 50).interval_95[1] == 1.0


def test_kappa_of_many_raters() -> None:
    assert round(float(fleiss(np.array(FLEISS))[0]), 3) == 0.210


def rows_of(table: list[list[int]]) -> tuple[list[str], list[str], list[str]]:
    """A part a count of the table, each rated once by x and once by y."""
    parts, who, called = [], [], []
    for a, row in enumerate(table):
        for b, count in enumerate(row):
            for k in range(count):
                parts += [f"{a}{b}{k}"] * 2
                who += ["x", "y"]
                called += ["abcd"[a], "abcd"[b]]
    return parts, who, called


def test_the_interval_of_kappa() -> None:
    """By resampled parts; Fleiss, Cohen and Everitt's standard error gives 0.38 to 0.60."""
    found = agreement(ratings_of(*rows_of(PATHOLOGISTS))).pairs[0]
    assert round(found.value, 3) == 0.493
    assert found.interval_95 == pytest.approx(
        (0.493 - 1.96 * 0.057, 0.493 + 1.96 * 0.057), abs=0.02
    )


def small() -> tuple[list[str], list[str], list[str], list[str]]:
    """Five parts, two appraisers, two trials: known by hand."""
    called = {  # part: reference, x's two, y's two
        "1": ("PASS", "PASS PASS", "PASS PASS"),
        "2": ("FAIL", "FAIL FAIL", "FAIL PASS"),
        "3": ("FAIL", "PASS PASS", "FAIL FAIL"),
        "4": ("PASS", "PASS PASS", "FAIL PASS"),
        "5": ("FAIL", "PASS PASS", "PASS PASS"),
    }
    rows = [
        (part, who, one, known)
        for part, (known, *of) in called.items()
        for who, said in zip("xy", of, strict=True)
        for one in said.split()
    ]
    return tuple(list(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]


def test_shares_by_hand() -> None:
    parts, who, called, known = small()
    found = agreement(ratings_of(parts, who, called, known, "FAIL"))
    x, y = found.appraisers
    assert (x.consistent.found, x.right, x.missed, x.alarmed) == (
        5, Share(3, 5), Share(4, 6), Share(0, 4),
    )  # fmt: skip
    assert (y.consistent.found, y.right, y.missed, y.alarmed) == (
        3, Share(2, 5), Share(3, 6), Share(1, 4),
    )  # fmt: skip
    assert (found.all_agree.found, found.all_right) == (2, Share(1, 5))
    # x with y: both fail 1, both pass 5, x alone 1, y alone 3
    assert found.pairs[0].table is not None
    assert found.pairs[0].table.tolist() == [[1, 1], [3, 5]]
    assert found.pairs[0].value == pytest.approx((0.6 - 0.56) / 0.44)
    # x with the reference: both fail 2, both pass 4, the reference alone 4
    assert found.with_reference[0].value == pytest.approx((0.6 - 0.44) / 0.56)


def test_an_attribute_study_that_is_none() -> None:
    parts, who, called, known = small()
    with pytest.raises(DataError, match="crossed"):
        ratings_of(parts[:-1], who[:-1], called[:-1])
    with pytest.raises(DataError, match="in another"):
        ratings_of(parts, who, called, ["PASS", "FAIL", *known[2:]])
    with pytest.raises(UsageError, match="nothing"):
        ratings_of(parts, who, called, known, "BAD")
    with pytest.raises(DataError, match="good parts and bad"):
        ratings_of(parts, who, ["PASS"] * len(called))


def test_the_attribute_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "verdicts.csv"
    rows = "\n".join(",".join(row) for row in zip(*small(), strict=True))
    path.write_text("part,station,verdict,truth\n" + rows, encoding="utf-8")
    call = ["gauge", "attribute", str(path), "--rating", "verdict"]
    known = [*call, "--reference", "truth", "--bad", "FAIL"]
    assert run(known) == 0
    said = capsys.readouterr().out
    of_x = [re.split("  +", line) for line in said.splitlines() if line.startswith("x ")]
    words = {row[1]: row[-1] for row in of_x if "acceptable" in row[-1]}
    assert words == {
        "alike, and right": "not acceptable",
        "bad ones missed": "not acceptable",
        "false alarms": "acceptable",
    }
    assert run([*known, "--min-kappa", "0.75"]) == 1
    capsys.readouterr()
    assert run([*known, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["appraisers"][0]["missed"] == {
        "found": 4, "of": 6, "share": pytest.approx(2 / 3),
        "interval_95": pytest.approx([0.2228, 0.9567], abs=1e-4),
    }  # fmt: skip
    assert run([*call, "--bad", "FAIL"]) == 2


@pytest.mark.slow
def test_verdicts_of_a_history(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two stations judged four motors once each, and differ on one of them."""
    db, began = tmp_path / "line.db", datetime(2026, 11, 1, tzinfo=UTC)
    verdicts = {"left": "PPFF", "right": "PPFP", "": "PPPP"}
    with open_history(db) as history:
        for n, (station, said) in enumerate(verdicts.items()):
            for k, one in enumerate(said):
                outcome = {"P": "PASS", "F": "FAIL"}[one]
                at = began + timedelta(minutes=4 * n + k)
                history.add(
                    ResultRecord("check", f"M{k}", (), at=at, station=station, outcome=outcome)
                )
    assert run(["gauge", "attribute", str(db), "--json"]) == 0
    (pair,) = json.loads(capsys.readouterr().out)["kappa"]
    assert (pair["first"], pair["second"], pair["table"]) == ("left", "right", [[1, 1], [0, 2]])
    assert pair["kappa"] == pytest.approx(0.5)
    assert run(["gauge", "attribute", str(db), "--reference", "truth"]) == 2
    assert run(["gauge", "attribute", str(db), "--serial", "X*"]) == 4
    assert "names its station" in capsys.readouterr().err


def meters() -> list[Reading]:
    return [
        Reading(station, str(k), value)
        for station, values in (("wright", WRIGHT), ("mini", MINI))
        for k, value in enumerate(values)
    ]


def test_two_meters_of_bland_and_altman() -> None:
    """Difference -2.1, limits with 2 sd -79.7 and 75.5, interval -22.0 to 17.8 (1986)."""
    (found,) = compare(meters(), reference="mini")
    assert found.first == "wright"
    assert found.parts == 17
    assert round(found.difference, 1) == -2.1
    assert found.sd is not None
    assert found.limits is not None
    assert round(found.sd, 1) == 38.8
    # the paper takes 2 standard deviations of 38.8, and not 1.96
    assert [round(found.difference + k * found.sd, 1) for k in (-2, 2)] == [-79.6, 75.4]
    assert found.limits == pytest.approx((-78.0959, 73.8606), abs=5e-5)
    assert [round(x, 1) for x in found.interval_95] == [-22.0, 17.8]
    assert found.limits_95 is not None
    width = found.limits_95[1][1] - found.limits_95[1][0]
    assert width / 2 == pytest.approx(34.6, abs=0.15)  # the paper: 40.9 to 110.1
    assert not found.differ
    assert found.e_n is None


def test_a_station_that_is_off_is_found_and_others_are_not() -> None:
    rng = np.random.default_rng(12)
    motors = 2.6 + rng.normal(0, 0.05, 8)
    readings = [
        Reading(station, f"M{k}", value * gain + rng.normal(0, 5e-4), 2e-3)
        for station, gain in (("a", 1.0), ("b", 1.0), ("c", 1.004))
        for k, value in enumerate(motors)
    ]
    found = {(one.first, one.second): one for one in compare(readings)}
    assert not found["a", "b"].differ
    assert found["a", "c"].differ
    assert found["a", "c"].difference == pytest.approx(-0.0104, abs=8e-4)
    e_n = found["a", "c"].e_n
    assert e_n == pytest.approx(0.0104 / (2 * math.hypot(2e-3, 2e-3)), rel=0.08)
    assert e_n is not None
    assert e_n > 1.0


def test_holm_by_hand() -> None:
    """The smallest p times three, the next times two, none below the one before."""
    rng = np.random.default_rng(16)
    table = {name: rng.normal(off, 1.0, 8) for name, off in (("a", 0.0), ("b", 0.8), ("c", 2.0))}
    readings = [Reading(s, str(k), x) for s, values in table.items() for k, x in enumerate(values)]
    raw = sorted(
        float(ttest_rel(table[one], table[other]).pvalue) for one, other in ("ab", "ac", "bc")
    )
    expected, least = [], 0.0
    for p, times in zip(raw, (3, 2, 1), strict=True):
        least = max(least, min(1.0, p * times))
        expected.append(least)
    assert sorted(one.p for one in compare(readings)) == pytest.approx(expected, rel=1e-9)


def test_a_gain_that_differs_grows_with_the_value() -> None:
    rng = np.random.default_rng(17)
    motors = np.linspace(1.0, 3.0, 8)
    readings = [
        Reading(s, str(k), x * gain + rng.normal(0, 2e-3))
        for s, gain in (("a", 1.0), ("b", 1.02)) for k, x in enumerate(motors)
    ]  # fmt: skip
    (found,) = compare(readings)
    assert found.slope_p is not None
    assert found.slope_p < 1e-4
    assert "grows with the value" in stations_text([found], "R", "ohm")
    (few,) = compare([one for one in readings if int(one.part) < 4])
    assert few.slope_p is None


@pytest.mark.slow
def test_holm_keeps_chance_from_finding_a_pair() -> None:
    """Six equal stations have fifteen pairs: a difference is found in about one study of twenty."""
    rng = np.random.default_rng(13)
    false = 0
    for _ in range(100):
        readings = [Reading(s, str(k), rng.normal()) for s in "abcdef" for k in range(6)]
        false += any(one.differ for one in compare(readings))
    assert false <= 13  # 5 and four standard deviations


def test_one_golden_motor_is_compared_by_its_repeats() -> None:
    rng = np.random.default_rng(14)
    readings = [
        Reading(s, "GOLD", 2.6 + off + rng.normal(0, 1e-3)) for s, off in (("a", 0), ("b", 5e-3))
        for _ in range(10)
    ]  # fmt: skip
    (found,) = compare(readings)
    assert found.parts == 1
    assert found.limits is None
    assert found.differ
    assert found.interval_95[0] < -5e-3 < found.interval_95[1]


def test_stations_without_a_common_motor() -> None:
    with pytest.raises(DataError, match="same motors"):
        compare([Reading("a", "1", 1.0), Reading("b", "2", 1.0)])
    with pytest.raises(DataError, match="two stations"):
        compare([Reading("a", "1", 1.0)])
    with pytest.raises(UsageError, match="'z'"):
        compare(meters(), reference="z")


@pytest.mark.slow
def test_the_stations_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A history and a file of the same readings give the same comparison."""
    db, path = tmp_path / "line.db", tmp_path / "line.csv"
    began = datetime(2026, 11, 1, tzinfo=UTC)
    rng = np.random.default_rng(15)
    rows = ["part,station,R,u(R)"]
    with open_history(db) as history:
        for station, off in (("left", 0.0), ("right", 0.004)):
            for k in range(5):
                value = 2.5 + 0.02 * k + off + rng.normal(0, 2e-4)
                rows.append(f"M{k},{station},{value!r},0.001")
                measured = (MeasurementRecord("R", "ohm", value, 0.001),)
                at = began + timedelta(minutes=len(rows))
                history.add(ResultRecord("check", f"M{k}", measured, at=at, station=station))
    path.write_text("\n".join(rows), encoding="utf-8")
    call = ["--quantity", "R", "--reference", "left"]
    said = []
    for source in (db, path):
        assert run(["gauge", "stations", str(source), *call, "--json"]) == 0
        said.append(json.loads(capsys.readouterr().out)["pairs"])
    assert said[0] == said[1]
    assert said[0][0]["differ"]
    assert run(["gauge", "stations", str(db), *call, "--max-difference", "0.003"]) == 1
    assert "beyond the stated uncertainties" in capsys.readouterr().out
    call[-1] = "right"  # the difference is then a negative one
    assert run(["gauge", "stations", str(db), *call, "--max-difference", "0.003"]) == 1
    assert run(["gauge", "stations", str(db), *call, "--max-difference", "0.005"]) == 0
    assert run(["gauge", "stations", str(db), "--quantity", "X"]) == 2
