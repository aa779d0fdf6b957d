"""Decimal marks and marks that group thousands: read right, or asked about; never a factor off."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motorid.capture.csv_marks import GROUPERS, Ambiguous, Marks, looks_marked, may_be_groups
from motorid.capture.model import SPEED
from motorid.capture.table import read_table
from motorid.errors import DataError, UsageError

MAPS = ["time=t:ms", "speed=n:rad/s"]
SPEEDS = [900.0 + 4 * k for k in range(60)]


def written(value: float, thousands: str, decimal: str, digits: int = 0) -> str:
    text = f"{value:,.{digits}f}"
    return text.translate({ord(","): thousands, ord("."): decimal})


def table(folder: Path, cells: list[str], between: str = ";", **options: Any) -> list[float]:
    """The speeds that an import finds in a file with that separator."""
    path = folder / "log.csv"
    lines = (f'{k}{between}"{cell}"' for k, cell in enumerate(cells))
    path.write_text(f"t{between}n\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return list(read_table(path, MAPS, **options).channels[SPEED].raw)


STYLES = [
    (".", ",", ";"), (",", ".", ";"), (",", ".", ","), (",", ".", "\t"), ("'", ".", ","),
    ("’", ".", ";"), (" ", ",", ";"), ("\N{NARROW NO-BREAK SPACE}", ",", ";"), ("_", ".", ","),
]  # fmt: skip


@pytest.mark.parametrize(("thousands", "decimal", "separator"), STYLES)
@pytest.mark.parametrize("digits", [0, 1, 3])
def test_a_mark_within_a_column_is_asked_about_by_its_cell(
    tmp_path: Path, thousands: str, decimal: str, separator: str, digits: int
) -> None:
    cells = [written(v, thousands, decimal, digits) for v in SPEEDS]
    with pytest.raises(DataError, match=r"log\.csv: line 27, column 'n' holds") as caught:
        table(tmp_path, cells, separator)
    assert "--thousands" in str(caught.value)
    with pytest.raises(DataError, match="--thousands"):
        table(tmp_path, cells, separator, drop_bad=True)
    found = table(tmp_path, cells, separator, thousands=thousands, decimal=decimal)
    assert found == SPEEDS


def test_any_kind_of_blank_or_apostrophe_is_meant(tmp_path: Path) -> None:
    for said, mark in ((" ", "\N{NO-BREAK SPACE}"), ("'", "’")):
        cells = [written(v, mark, ",", 1) for v in SPEEDS]
        assert table(tmp_path, cells, thousands=said, decimal=",") == SPEEDS


def test_a_mark_of_thousands_implies_the_other_for_decimals(tmp_path: Path) -> None:
    cells = [written(v + 0.5, ".", ",", 1) for v in SPEEDS]
    assert table(tmp_path, cells, thousands=".") == [v + 0.5 for v in SPEEDS]


def test_who_says_that_it_is_decimal_is_followed(tmp_path: Path) -> None:
    cells = [written(v, ".", ",") for v in SPEEDS]
    assert table(tmp_path, cells, decimal=".")[-1] == pytest.approx(1.136)


def test_millions_and_lakhs_are_asked_about_though_every_cell_has_them(tmp_path: Path) -> None:
    for first in ("1.000.000", "1,00,000", "1 000 000"):
        with pytest.raises(DataError, match="--thousands"):
            table(tmp_path, [first] * 20)


def test_groups_of_other_lengths_are_bad_cells(tmp_path: Path) -> None:
    cells = ["1.000", "1.00", *(str(k) for k in range(20))]
    with pytest.raises(DataError, match=r"line 3, column 'n' holds '1\.00', "):
        table(tmp_path, cells, thousands=".")


@pytest.mark.parametrize(
    "honest",
    [
        [f"{0.9 + 0.011 * k:.3f}" for k in range(40)],
        [f"{1.5 + 0.011 * k:.3f}" for k in range(40)],  # every cell has three digits
        [f"{12 + 0.003 * (k % 3):g}" for k in range(40)],  # 12, 12.003, 12.006
        [f"{0.125 * k:g}" for k in range(40)],
        [f"{1 + 0.25 * k:g}" for k in range(40)],
        [f"{50 * k}" for k in range(40)],
        ["0"] * 20 + [f"{1.125 * k:.4g}" for k in range(20)],
    ],
)
def test_decimals_are_no_thousands(tmp_path: Path, honest: list[str]) -> None:
    for text in (honest, [cell.replace(".", ",") for cell in honest]):
        found = table(tmp_path, text)
        assert found == pytest.approx([float(cell) for cell in honest])


@pytest.mark.parametrize("step", ["2", "0", "1"])
def test_a_step_over_the_thousands_is_asked_about(tmp_path: Path, step: str) -> None:
    """Rest near zero, then a thousand and more at once: as decimals they look alike."""
    with pytest.raises(DataError, match=r"say whether '\.' groups thousands"):
        table(tmp_path, [step, "0", step] * 10 + ["1.450", "1.398", "1.401"] * 10)


def test_two_decimal_marks_in_one_table_are_asked_about(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"line 22, .* has ',' for a decimal mark, where others"):
        table(tmp_path, [f"{k}.25" for k in range(20)] + ["20,25"], drop_bad=True)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"thousands": ";"}, "none of"),
        ({"thousands": ""}, "none of"),
        ({"thousands": "..", "decimal": ","}, "none of"),
        ({"thousands": ".", "decimal": "."}, "--decimal and --thousands are both"),
        ({"thousands": " ", "separator": " "}, "--separator and --thousands are both"),
    ],
)
def test_a_mark_that_cannot_be_is_said(tmp_path: Path, options: dict[str, str], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        table(tmp_path, ["1"] * 5, **options)


# -- whatever the numbers
@pytest.mark.slow
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.integers(-3_000_000, 3_000_000) | st.integers(0, 2000), min_size=3, max_size=12),
    st.sampled_from(STYLES),
    st.integers(0, 3),
)
def test_a_table_is_read_as_it_was_meant_or_asked_about(
    tmp_path: Path, whole: list[int], style: tuple[str, str, str], digits: int
) -> None:
    thousands, decimal, separator = style
    values = [n / 10**digits for n in whole]
    cells = [written(v, thousands, decimal, digits) for v in values]
    given_ = table(tmp_path, cells, separator, thousands=thousands, decimal=decimal)
    assert given_ == values
    try:
        found = table(tmp_path, cells, separator)
    except (DataError, UsageError):
        return
    if found == values:
        return
    # what no reader can tell: every cell in groups, or all of a size, as 12 and 12.003 are
    plain = [abs(v) for v, cell in zip(values, cells, strict=True) if thousands not in cell]
    groups = [abs(v) / 1000 for v, cell in zip(values, cells, strict=True) if thousands in cell]
    assert digits == 0
    assert not plain or max(plain + groups) < 2.0 * min(plain + groups)


@pytest.mark.slow
@given(st.text(alphabet="0123456789.,'’_ -+eE\N{NO-BREAK SPACE}", max_size=14))
def test_any_cell_is_a_number_in_one_way_at_most(cell: str) -> None:
    ways = {
        float(value)
        for decimal in ".,"
        if np.isfinite(value := Marks(decimal).numbers([cell])[0]) and "." not in cell
        if "," not in cell
    }
    assert len(ways) <= 1
    if "." in cell:
        assert np.isnan(Marks(",").numbers([cell])[0])
    if looks_marked(cell):
        assert any(mark in cell for mark in GROUPERS)


def test_only_whole_thousandths_are_looked_at_again() -> None:
    assert may_be_groups(np.array([989.0, 1.009]))
    assert not may_be_groups(np.array([989.0, 1.0095]))
    assert not may_be_groups(np.array([989.0, 0.5]))
    assert not may_be_groups(np.array([1.0, 2.0]))
    assert not may_be_groups(np.array([np.nan]))
    seen = Ambiguous("n", ".")
    seen.look(["989", "", "1.009"], 5)
    assert seen.first is not None
    assert (seen.first.row, seen.beside) == (7, "989")
    seen.look(["1.5"], 8)
    assert seen.question == ""
