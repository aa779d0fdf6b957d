"""Lines of JSON objects: members within members, and where that ends."""

from __future__ import annotations

import pytest

from motorid.capture.record_lines import NoRecordError, json_record


def nested(depth: int) -> str:
    return '{"a": ' * depth + "1.5" + "}" * depth


@pytest.mark.parametrize("depth", [1, 2, 7])
def test_members_of_members_have_dotted_names(depth: int) -> None:
    assert json_record(nested(depth)) == {".".join("a" * depth): 1.5}


@pytest.mark.parametrize("depth", [8, 9, 50])
def test_an_object_within_more_than_seven_is_no_record(depth: int) -> None:
    with pytest.raises(NoRecordError):
        json_record(nested(depth))
