"""Nested gauge studies against published examples, and the interaction's alpha as an option."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.anova import nested_table
from motorid.quality.gauge import Study, analyse
from motorid.quality.study_file import nested_study_of
from tests.gauge.published import AIAG_GRR

# Montgomery, Design and Analysis of Experiments, the purity of 4 batches of each of 3 suppliers
PURITY = np.array(
    [
        [[1, -1, 0], [-2, -3, -4], [-2, 0, 1], [1, 4, 0]],
        [[1, -2, -3], [0, 4, 2], [-1, 0, -2], [0, 3, 2]],
        [[2, 4, 0], [-2, 0, 2], [1, -1, 2], [3, 2, 1]],
    ],
    float,
).transpose(1, 0, 2)


def study(values: np.ndarray) -> Study:
    parts, operators, _ = values.shape
    names = tuple(str(k) for k in range(parts)), tuple("ABCD"[:operators])
    return Study(values, *names)


def test_purity_of_batches_within_suppliers() -> None:
    rows = nested_table(PURITY)
    assert [round(row.squares, 2) for row in rows.values()] == [15.06, 69.92, 63.33, 148.31]
    assert [row.degrees for row in rows.values()] == [2, 9, 24, 35]
    assert [round(row.mean, 2) for row in rows.values()][:3] == [7.53, 7.77, 2.64]
    operator, part = rows["operator"], rows["part (operator)"]
    assert operator.f == pytest.approx(0.97, abs=5e-3)
    assert operator.p == pytest.approx(0.42, abs=5e-3)
    assert part.f == pytest.approx(2.94, abs=5e-3)
    assert part.p == pytest.approx(0.02, abs=5e-3)
    found = analyse(study(PURITY), method="nested")
    assert found.components["PV"].sigma ** 2 == pytest.approx(1.71, abs=5e-3)
    assert found.components["EV"].sigma ** 2 == pytest.approx(2.64, abs=5e-3)
    assert found.components["AV"].sigma == 0.0


def of_squares(operator: float, part: float, error: float) -> np.ndarray:
    """3 operators with 5 parts each, twice measured, of exactly these sums of squares."""
    rng = np.random.default_rng(1)
    first = rng.normal(size=(1, 3, 1))
    first -= first.mean()
    second = rng.normal(size=(5, 3, 1))
    second -= second.mean(axis=0)
    third = rng.normal(size=(5, 3, 2))
    third -= third.mean(axis=2, keepdims=True)
    first *= np.sqrt(operator / (10.0 * (first**2).sum()))
    second *= np.sqrt(part / (2.0 * (second**2).sum()))
    return first + second + third * np.sqrt(error / (third**2).sum())


def test_a_nested_study_as_minitab_prints_it() -> None:
    """Minitab's help, worksheet GAGENEST: its sums of squares give all the rest."""
    values = of_squares(0.0142, 22.0552, 19.3400)
    found = analyse(study(values), method="nested", tolerance=10.0)
    rows = {row.source: row for row in found.table}
    assert rows["operator"].f == pytest.approx(0.00385, abs=2e-5)  # 0.0142 has three digits
    assert rows["operator"].p == pytest.approx(0.996, abs=5e-4)
    assert rows["part (operator)"].f == pytest.approx(1.42549, abs=5e-6)
    assert rows["part (operator)"].p == pytest.approx(0.255, abs=5e-4)
    printed = {
        "GRR": (1.13549, 82.46, 90.81, 68.13),
        "EV": (1.13549, 82.46, 90.81, 68.13),
        "AV": (0.0, 0.0, 0.0, 0.0),
        "PV": (0.52374, 17.54, 41.88, 31.42),
        "TV": (1.25045, 100.0, 100.0, 75.03),
    }
    for name, (sigma, contribution, share, tolerance) in printed.items():
        one = found.components[name]
        assert one.sigma == pytest.approx(sigma, abs=1e-5)
        assert one.percent_contribution == pytest.approx(contribution, abs=5e-3)
        assert one.percent_study == pytest.approx(share, abs=5e-3)
        assert one.percent_tolerance == pytest.approx(tolerance, abs=5e-3)
    assert found.categories == 1


def test_a_nested_file_of_one_and_of_unlike_operators(tmp_path: Path) -> None:
    rows = [
        {"part": f"{'xyz'[o]}{p}", "operator": "ABC"[o], "R": str(PURITY[p, o, r])}
        for p in range(4) for o in range(3) for r in range(3)
    ]  # fmt: skip
    found = nested_study_of(rows, "R", "here")
    np.testing.assert_array_equal(found.values, PURITY)
    assert found.operators == ("A", "B", "C")
    alone = analyse(nested_study_of(rows[::3][:0] + [r for r in rows if r["operator"] == "A"],
                                    "R", "here"), method="nested")  # fmt: skip
    assert "AV" not in alone.components
    with pytest.raises(DataError, match="balanced"):
        nested_study_of(rows[:-1], "R", "here")
    path = tmp_path / "nested.csv"
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, ["part", "operator", "R"])
        writer.writeheader()
        writer.writerows(rows)
    assert run(["gauge", "nested", str(path), "-o", str(tmp_path / "out")]) == 0
    said = json.loads((tmp_path / "out" / "gauge.json").read_text(encoding="utf-8"))
    assert said["studies"][0]["method"] == "nested"
    assert "Averages by operator" in (tmp_path / "out" / "gauge.html").read_text(encoding="utf-8")
    assert run(["gauge", "nested", str(path), "--max-grr", "10"]) == 1


def test_alpha_decides_what_is_pooled() -> None:
    """The AIAG's interaction has p = 0.974."""
    values = study(AIAG_GRR)
    assert analyse(values).pooled
    assert analyse(values, alpha=0.0).pooled
    assert analyse(values, alpha=0.97).pooled
    full = analyse(values, alpha=0.98)
    assert not full.pooled
    assert full.components["INT"].sigma == 0.0
    assert full.components["EV"].sigma == pytest.approx(0.21443, abs=5e-6)  # sqrt(2.7589/60)
    with pytest.raises(UsageError, match="probability"):
        analyse(values, alpha=1.5)


def test_alpha_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [
        f"P{p},{'ABC'[o]},{AIAG_GRR[p, o, r]}"
        for p in range(10)
        for o in range(3)
        for r in range(3)
    ]
    path = tmp_path / "readings.csv"
    path.write_text("part,operator,R\n" + "\n".join(rows), encoding="utf-8")
    assert run(["gauge", "crossed", str(path)]) == 0
    assert "interaction pooled" in capsys.readouterr().out
    assert run(["gauge", "crossed", str(path), "--alpha", "1"]) == 0
    assert "interaction pooled" not in capsys.readouterr().out
