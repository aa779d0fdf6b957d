"""Which datasets and trees of an HDF5 file are read at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from motorid.capture.content_digest import MAX_DEPTH, MAX_OBJECTS, content_sha256
from motorid.capture.store_guard import Guard
from motorid.errors import DataError


@pytest.mark.parametrize(
    ("how", "read"),
    [
        ({}, True),
        ({"compression": "gzip"}, True),
        ({"shuffle": True}, True),
        ({"fletcher32": True}, True),
        ({"compression": "lzf"}, False),
        ({"scaleoffset": 0}, False),
    ],
)
def test_a_column_is_read_with_the_filters_of_captures_alone(
    how: dict[str, Any], read: bool, tmp_path: Path
) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        made = file.create_dataset("x", data=np.arange(64), chunks=(64,), **how)
        guard = Guard(file, 10_000)
        if read:
            guard.readable(made, "x")
        else:
            with pytest.raises(DataError, match="compressed in a way"):
                guard.readable(made, "x")


@pytest.mark.parametrize(
    ("deep", "wide", "refused"),
    [
        (MAX_DEPTH, 0, False),
        (MAX_DEPTH + 1, 0, True),
        (0, MAX_OBJECTS - 1, False),  # the root is one of them
        (0, MAX_OBJECTS, True),
    ],
)
def test_a_tree_larger_than_a_capture_has_is_refused(
    deep: int, wide: int, refused: bool, tmp_path: Path
) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        if deep:
            file.create_group("/".join("g" * deep))
        for n in range(wide):
            file.create_group(f"{n // 50}/{n}" if n % 50 else str(n // 50))
        if refused:
            with pytest.raises(DataError, match="more than a motorid capture"):
                content_sha256(file, 10**6)
        else:
            assert len(content_sha256(file, 10**6)) == 64
