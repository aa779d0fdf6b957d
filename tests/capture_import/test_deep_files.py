"""Structs within structs of a MAT file, and what a person is asked about marks."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from motorid.capture import mat_child
from motorid.capture.csv_marks import Marks


def names(path: Path) -> list[str]:
    target = path.with_name("out.npz")
    mat_child.main(str(path), str(target))
    with np.load(target) as found:
        assert found["objects"].shape[1] == 2
        return [str(name) for name in found["names"]]


@pytest.mark.parametrize(("depth", "read"), [(12, True), (13, False)])
@pytest.mark.parametrize("kind", ["v5", "hdf5"])
def test_structs_are_followed_twelve_deep(
    kind: str, depth: int, read: bool, tmp_path: Path
) -> None:
    path = tmp_path / "a.mat"
    dotted = "x" + ".s" * depth
    if kind == "hdf5":
        with h5py.File(path, "w") as file:
            file[dotted.replace(".", "/")] = np.arange(3.0)
    else:
        value: object = np.arange(3.0)
        for _ in range(depth):
            value = {"s": value}
        savemat(path, {"x": value})
    assert names(path) == ([dotted] if read else [])


@pytest.mark.parametrize(
    ("cell", "thousands", "says"),
    [
        ("1 234", "", "give --thousands ' '"), ("1'234", "", 'give --thousands "\'"'),
        ("1,234", "", "give --thousands ,"), ("12,34,567", "", "group thousands by ','"),
        ("1,234", " ", "is no number in groups of three by ' '"),
        ("1,5", "", "has ',' for a decimal mark, where others have '.'"),
    ],
)  # fmt: skip
def test_what_is_asked_about_a_mark(cell: str, thousands: str, says: str) -> None:
    assert says in Marks(".", thousands).question(cell)
