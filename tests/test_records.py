"""What the rooms of captures hand on is a record that nobody rewrites."""

from __future__ import annotations

import pytest

from tests.estimate.test_immutable_records import records, writable

WORKING = {  # filled while they are used
    "capture": {"Ambiguous", "Entry", "Found"},
    "acquire": {"Stop", "_Run"},
    "segment": set(),
}


@pytest.mark.parametrize("room", WORKING)
def test_records_of_a_room_are_immutable(room: str) -> None:
    found = records(room, "motorid")
    assert len(found) >= 5
    assert {one.__name__ for one in found if writable(one)} == WORKING[room]
