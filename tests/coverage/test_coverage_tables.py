"""Shares, their intervals and the tables of the coverage study."""

from __future__ import annotations

from typing import Any

import pytest
from scipy.stats import binomtest

from bench.bench_coverage import merged, stored
from bench.coverage.tables import causes, coverage, interval_of_share, standing, summary


def row(seed: int, z: float, *, power: float = 10.0, status: str = "estimated") -> dict[str, Any]:
    """A record whose R is off by ``z`` standard uncertainties of 1 %."""
    p = {
        "status": status,
        "off": 0.01 * z,
        "total": 0.01,
        "interval": [0.01 * (z - 1.96), 0.01 * (z + 1.96)],
        "holds": abs(z) <= 1.96,
    }
    if status == "not_identifiable":
        p = {"status": status}
    names = ("R", "L", "K", "B", "J", "T0")
    return {
        "seed": seed,
        "power_w": power,
        "bound": dict.fromkeys(names, 0.01),
        "fit": {"parameters": dict.fromkeys(names, p)},
        "feature": {"brush drop": z, "bits": (seed * 7) % 5},
    }


@pytest.mark.parametrize(("held", "count"), [(0, 5), (93, 100), (1900, 2000)])
def test_interval_of_a_share_is_wilsons(held: int, count: int) -> None:
    expected = binomtest(held, count).proportion_ci(method="wilson")
    assert interval_of_share(held, count) == pytest.approx((expected.low, expected.high), abs=1e-9)


def test_coverage_counts_intervals_that_hold() -> None:
    rows = [row(k, z) for k, z in enumerate((0.0, 1.0, -1.5, 3.0))]
    assert coverage(rows, "fit", "R") == (3, 4)
    assert coverage(rows, "naive", "R") == (0, 0)
    assert "| R | 75.0%" in summary(rows)


def test_not_identifiable_is_held_against_the_bound() -> None:
    rows = [row(0, 0.0), row(1, 0.0, status="not_identifiable")]
    rows.append(row(2, 0.0, status="not_identifiable"))
    rows[2]["bound"] = dict.fromkeys(rows[2]["bound"], 0.5)
    assert standing(rows, "fit", "L") == (2, 1)


def test_the_cause_of_misses_comes_first() -> None:
    rows = [row(k, 0.2 * (k - 15)) for k in range(31)]
    assert causes(rows, "R")[0][:2] == ("brush drop", pytest.approx(1.0))


def test_refusals_and_crashes_are_counted() -> None:
    rows = [{"seed": 1, "refused": "RigError: no"}, {"seed": 2, "fit": {"crashed": "x\nKeyError"}}]
    text = summary(rows)
    assert "without a fit: 2" in text
    assert "fit crashed: KeyError" in text


def test_a_torn_line_does_not_end_a_study(tmp_path: Any) -> None:
    path = tmp_path / "study.jsonl"
    path.write_text('{"seed": 1}\n{"seed": 2}\n{"seed":')
    assert [r["seed"] for r in stored(path)] == [1, 2]


def test_files_of_one_study_add_up_rig_by_rig(tmp_path: Any) -> None:
    (tmp_path / "a").write_text('{"seed": 1, "bound": 2, "fit": 3}\n{"seed": 2}\n')
    (tmp_path / "b").write_text('{"seed": 1, "fit": 4}\n')
    rows = merged([tmp_path / "a", tmp_path / "b"])
    assert rows == [{"seed": 1, "bound": 2, "fit": 4}, {"seed": 2}]
