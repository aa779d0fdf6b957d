"""The lines of a table, handed to a parser piece by piece."""

from __future__ import annotations

from io import StringIO

import pytest

from motorid.capture.csv_text import Body

TEXT = "t,i\n0,1\n1,2\n2,3\n   \n"
LINES = len("t,i\n0,1\n1,2\n2,3\n")  # without what is blank at the end


@pytest.mark.parametrize("count", [1, 3, 4, 100])
def test_pieces_of_any_size_make_the_whole_without_the_blank_end(count: int) -> None:
    body = Body(StringIO(TEXT), 1, LINES)
    pieces = list(iter(lambda: body.read(count), ""))
    assert "".join(pieces) == "0,1\n1,2\n2,3\n"
    assert max(map(len, pieces)) <= count


def test_all_at_once_and_line_by_line_are_the_same() -> None:
    assert Body(StringIO(TEXT), 2, LINES).read() == "1,2\n2,3\n"
    assert list(Body(StringIO(TEXT), 2, LINES)) == ["1,2\n", "2,3\n"]
    body = Body(StringIO(TEXT), 0, LINES)
    assert body.read(4) + body.read(-1) == TEXT[:LINES]
    assert body.read(0) == body.read() == ""
    assert Body(StringIO(TEXT), 1, LINES).read(0) == ""
