"""What only MATLAB reads, as SciPy of one version or another presents it; structs and cells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from motorid.capture import mat_child
from motorid.capture.mat_child import Found
from motorid.capture.mat_reader import _said


def of_kind(name: str, value: Any, **facts: Any) -> Any:
    """An array of a class of that name, as SciPy's are."""
    kind = type(name, (np.ndarray,), facts)
    return np.asarray(value).view(kind)


def walked(value: Any, depth: int = 0) -> tuple[dict[str, list[float]], dict[str, str]]:
    found = Found()
    mat_child._walk_v5("x", value, found, depth)
    return {name: one.tolist() for name, one in found.arrays.items()}, found.objects


OLD = np.array([(b"own", b"MCOS", b"timetable")], dtype=[(n, "O") for n in ("s0", "s1", "s2")])
NEW = np.array([("MCOS", "duration")], dtype=[("_TypeSystem", "O"), ("_Class", "O")])
BARE = np.array([(1,)], dtype=[("other", "O")])


@pytest.mark.parametrize(
    ("value", "objects"),
    [
        (of_kind("MatlabFunction", OLD), {"x": "function handle"}),
        (of_kind("MatlabObject", OLD, classname="inline"), {"x": "inline"}),
        (of_kind("MatlabOpaque", OLD), {"own": "timetable"}),
        (of_kind("MatlabOpaque", NEW), {"x": "duration"}),
        (of_kind("MatlabOpaque", NEW[0:1].reshape(())), {"x": "duration"}),
        (of_kind("MatlabOpaque", BARE), {"x": "opaque"}),
    ],
)
def test_an_object_is_named_with_its_class(value: Any, objects: dict[str, str]) -> None:
    assert walked(value) == ({}, objects)


def test_a_sparse_matrix_is_named() -> None:
    from scipy.sparse import csc_matrix

    assert walked(csc_matrix(np.eye(2))) == ({}, {"x": "sparse matrix"})


def cell(*items: Any) -> Any:
    found = np.empty(len(items), dtype=object)
    found[:] = items
    return found


def test_structs_and_cells_are_walked_by_dots_and_numbers() -> None:
    one, two = np.array([1.0, 2.0]), np.array([[3.0], [4.0]])
    struct = np.array([(one, two)], dtype=[("a", "O"), ("b", "O")])
    assert walked(struct)[0] == {"x.a": [1.0, 2.0], "x.b": [3.0, 4.0]}
    several = np.array([(one,), (two,)], dtype=[("a", "O")])
    assert walked(several)[0] == {"x[1].a": [1.0, 2.0], "x[2].a": [3.0, 4.0]}
    assert walked(cell(one, two))[0] == {"x[1]": [1.0, 2.0], "x[2]": [3.0, 4.0]}
    assert walked(cell(struct))[0] == {"x.a": [1.0, 2.0], "x.b": [3.0, 4.0]}
    assert walked("text")[0] == walked(np.array("text"))[0] == {}


def test_what_is_nested_deeper_than_twelve_is_left_out() -> None:
    deep: Any = np.array([1.0, 2.0])
    for _ in range(12):
        inner = np.empty(1, dtype=object)
        inner[0] = deep
        deep = inner
    assert walked(deep)[0] == {"x": [1.0, 2.0]}
    assert walked(deep, depth=1)[0] == {}


def test_matrices_give_columns_and_rows_and_more_dimensions_are_pressed_flat() -> None:
    columns, _ = walked(np.array([[1, 2, 3], [4, 5, 6]]))
    assert columns == {
        "x[1]": [1, 4], "x[2]": [2, 5], "x[3]": [3, 6], "x[1,:]": [1, 2, 3], "x[2,:]": [4, 5, 6],
    }  # fmt: skip
    assert walked(np.array([[[1.0, 2.0]]]))[0] == {"x": [1.0, 2.0]}
    assert walked(np.array([[1.0, 2.0]]))[0] == walked(np.array([[1.0], [2.0]]))[0]
    assert walked(np.zeros((2, 2, 2)))[0] == walked(np.zeros(0))[0] == {}
    assert walked(np.array([1j]))[0] == {}
    assert walked(np.array([True, False]))[0] == {"x": [1.0, 0.0]}


@pytest.mark.parametrize(
    ("objects", "said"),
    [
        ({}, ""),
        ({"x": "timetable"}, "x is a timetable, which only MATLAB reads: there, "
                             "writetimetable(x, 'plain.csv')"),
        ({"y": "odd", "x": "Table"}, "y is a odd, x is a Table, which only MATLAB reads: there, "
                                     "writetable(x, 'plain.csv')"),
        ({"y": "odd"}, "y is a odd, which only MATLAB reads: there, "
                       "save its arrays as plain variables"),
        (dict.fromkeys("abcd", "odd"), "a is a odd, b is a odd, c is a odd, d is a odd, which only "
                                     "MATLAB reads: there, save its arrays as plain variables"),
        (dict.fromkeys("abcdef", "odd"), "a is a odd, b is a odd, c is a odd, d is a odd, and 2 "
                                       "more, which only MATLAB reads: there, save its arrays as "
                                       "plain variables"),
    ],
)  # fmt: skip
def test_what_to_do_in_matlab_is_said(objects: dict[str, str], said: str) -> None:
    assert _said(objects) == said


def test_references_that_lead_nowhere_or_too_deep_are_left_out(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["x"] = np.array([[1.0, 2.0]])
        cells = file.create_dataset("c", (2, 1), dtype=h5py.ref_dtype)
        cells[1, 0] = file["x"].ref
        for name, path in (("c", "c[2]"), ("s.c", "s[2].c")):
            found = Found()
            mat_child._walk_references(name, cells, found, 11)
            assert {n: a.tolist() for n, a in found.arrays.items()} == {path: [1.0, 2.0]}
        found = Found()
        mat_child._walk_references("c", cells, found, 12)
        assert found.arrays == {}


def test_a_cell_that_holds_itself_ends(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["x"] = np.array([1.0, 2.0])
        cells = file.create_dataset("c", (2,), dtype=h5py.ref_dtype)
        cells[:] = [cells.ref, file["x"].ref]
        found = Found()
        mat_child._walk_references("c", cells, found, 8)
    assert len(found.arrays) == 4  # x, at each of the depths that are left


@pytest.mark.parametrize(
    ("kind", "said", "found"),
    [("u1", "", {"x": "block of raw bytes"}), ("i1", "", {"x": "block of raw bytes"}),
     ("u1", "uint8", {}), ("u2", "", {}), ("f4", "", {}), ("f8", "odd", {"x": "odd"})],
)  # fmt: skip
def test_bytes_without_a_class_are_no_readings(
    kind: str, said: str, found: dict[str, str], tmp_path: Path
) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["x"] = np.array([1, 2], dtype=kind)
        if said:
            file["x"].attrs["MATLAB_class"] = np.bytes_(said)
        seen = Found()
        mat_child._walk_node("x", file["x"], seen, 0)
    assert seen.objects == found
    assert {n: a.tolist() for n, a in seen.arrays.items()} == ({} if found else {"x": [1.0, 2.0]})
