"""Blocks of samples: how stretches are cut into them."""

from __future__ import annotations

import pytest

from motorid.segment.blocks import _edges


@pytest.mark.parametrize(
    ("size", "starts", "stops", "joined"),
    [
        (1, [0, 1, 2, 7, 9, 10], [1, 2, 3, 8, 10, 11], [1, 1, 0, 0, 1]),
        (2, [0, 7, 9], [3, 8, 11], [0, 0]),  # a rest of half a block or less goes with the last
    ],
)
def test_each_stretch_is_covered_by_blocks_of_its_own(
    size: int, starts: list[int], stops: list[int], joined: list[int]
) -> None:
    found = _edges([(0, 3), (7, 8), (9, 11)], size)
    assert [part.tolist() for part in found] == [starts, stops, joined]
