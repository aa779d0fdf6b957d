"""Studies as CSV: which columns are what, and each sentence of refusal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.errors import DataError, UsageError
from motorid.quality.study_file import (
    column,
    labels,
    nested_study_of,
    quantities_of,
    read_rows,
    study_of,
    texts,
)

TEXT = """\ufeffMotor, Fixture ,R,u,trial,note,K
a,x,1,0.1,1,,5
a,y,2,0.2,1,,
b,x,3,0.3,1,,7
b,y,4,0.4,1,,8
a,x,5,0.5,2,,5
a,y,6,0.6,2,,6
b,x,7,0.7,2,,7
b,y,8,0.8,2,,8
"""


def rows(tmp_path: Path, text: str = TEXT) -> list[dict[str, str]]:
    path = tmp_path / "s.csv"
    path.write_text(text, encoding="utf-8")
    return read_rows(path)


def test_a_crossed_study(tmp_path: Path) -> None:
    found = study_of(rows(tmp_path), "R", "s.csv", unit="ohm", stated="u")
    assert found.values.tolist() == [[[1, 5], [2, 6]], [[3, 7], [4, 8]]]
    assert (found.parts, found.operators) == (("a", "b"), ("x", "y"))
    assert (found.quantity, found.unit) == ("R", "ohm")
    assert found.stated == pytest.approx(found.values / 10.0)
    assert study_of(rows(tmp_path), "R", "s.csv").stated is None


def test_columns_that_are_quantities(tmp_path: Path) -> None:
    """Numbers in every row and no bookkeeping: K lacks one, trial counts."""
    assert quantities_of(rows(tmp_path)) == ["R", "u"]
    odd = "part,operator,R,X,Y,,Order\na,x,1,nan,inf,2,3\n"
    assert quantities_of(rows(tmp_path, odd)) == ["R"]


def test_one_column(tmp_path: Path) -> None:
    found = rows(tmp_path)
    assert column(found[:1], "u", "s.csv") == [0.1]
    assert column(found, "u", "s.csv")[2:4] == [0.3, 0.4]
    with pytest.raises(DataError, match=r"s\.csv, line 3: K is '', not a number"):
        column(found, "K", "s.csv")
    for read in (column, texts):
        with pytest.raises(UsageError, match=r"s\.csv has no column 'Motr'.*'Motor'"):
            read(found, "Motr", "s.csv")
    marked = rows(tmp_path, "part,operator,R\n'=a , b ,1\n-c,'d,2\n")
    assert texts(marked, "part", "s.csv") == ["=a", "-c"]
    assert texts(marked[:1], "part", "s.csv") == ["=a"]
    assert labels(marked, "part", "s.csv") == ["=a", "-c"]
    assert labels(marked, "operator", "s.csv") == ["b", "'d"]


@pytest.mark.parametrize("head", ["part", "SERIAL", " motor "])
@pytest.mark.parametrize("who", ["operator", "Appraiser", "fixture", "station"])
def test_names_of_a_part_and_of_an_operator(tmp_path: Path, head: str, who: str) -> None:
    found = rows(tmp_path, f"{head},{who},R\na,x,1\n")
    assert (labels(found, "part", "s"), labels(found, "operator", "s")) == (["a"], ["x"])
    with pytest.raises(DataError, match="no column that names the part: call one 'part'"):
        labels(rows(tmp_path, f"thing,{who}\na,x\n"), "part", "s")


@pytest.mark.parametrize(
    ("text", "says"),
    [("", "holds no readings"), ("a,b\n", "holds no readings"), ("a,b\n1,2,3\n", "more cells")],
)
def test_files_that_are_no_study(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(DataError, match=says):
        rows(tmp_path, text)
    (tmp_path / "bad.csv").write_bytes(b"a,b\n\xff,1\n")
    with pytest.raises(DataError, match="cannot be read as CSV"):
        read_rows(tmp_path / "bad.csv")
    assert rows(tmp_path, "a,b\n1\n") == [{"a": "1", "b": ""}]


def test_a_cell_that_lacks_a_reading_is_named(tmp_path: Path) -> None:
    short = TEXT.replace("b,x,7,0.7,2,,7\n", "")
    with pytest.raises(DataError, match="part b by x has 1 readings, another has 2"):
        study_of(rows(tmp_path, short), "R", "s.csv")
    gone = TEXT.replace("b,x,", "c,x,")
    with pytest.raises(DataError, match="part c by y has 0 readings"):
        study_of(rows(tmp_path, gone), "R", "s.csv")


NESTED = "part,operator,R\n1,x,1\n2,x,2\n3,y,3\n4,y,4\n1,x,5\n2,x,6\n4,y,8\n3,y,7\n"


def test_a_nested_study(tmp_path: Path) -> None:
    found = nested_study_of(rows(tmp_path, NESTED), "R", "s.csv", unit="ohm")
    assert found.values.tolist() == [[[1, 5], [3, 7]], [[2, 6], [4, 8]]]
    assert (found.parts, found.operators) == (("1 / 3", "2 / 4"), ("x", "y"))
    assert (found.unit, found.quantity, found.stated) == ("ohm", "R", None)
    assert np.array_equal(found.values.shape, (2, 2, 2))


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("5,y,9\n5,y,9\n", r"y has 3 parts, the first has 2 parts with 2 readings each"),
        ("4,y,9\n", r"y has 2 parts and 3 readings of part 4, the first has 2 parts"),
        ("5,y,9\n", r"y has 3 parts and 1 readings of part 5, the first has 2 parts"),
    ],
)
def test_a_nested_study_that_is_not_balanced(tmp_path: Path, more: str, says: str) -> None:
    with pytest.raises(DataError, match=says):
        nested_study_of(rows(tmp_path, NESTED + more), "R", "s.csv")
