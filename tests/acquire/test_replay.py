"""A journal played back: each byte at its time, once what went before it was sent again."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.acquire.journal import MAGIC, Kind, encode_record
from motorid.acquire.port import open_port
from motorid.acquire.replay import ReplayPort
from motorid.errors import DataError, LinkError

Entry = tuple[Kind, float, bytes]
SENT, RECEIVED, MARK = Kind.SENT, Kind.RECEIVED, Kind.MARK


def replay(folder: Path, *entries: Entry) -> ReplayPort:
    path = folder / "run.h5.journal"
    records = (encode_record(*one) for one in ((Kind.HEADER, 0.0, b'{"note": "n"}'), *entries))
    path.write_bytes(MAGIC + b"".join(records))
    port = open_port(f"replay://{path}")
    assert isinstance(port, ReplayPort)
    assert port.name == f"replay://{path}"
    return port


def test_the_clock_begins_at_the_first_byte_and_the_last_end_counts(tmp_path: Path) -> None:
    ends = [(MARK, 9.0, b'{"end": "%s"}' % word) for word in (b"one", b"two", b"completed")]
    port = replay(tmp_path, (MARK, 3.0, b'{"measure": true}'), (SENT, 10.0, b"ask"), *ends)
    assert (port.now(), port.end, port.header) == (10.0, "completed", {"note": "n"})
    port.write(b"ask")
    with pytest.raises(LinkError, match=r"run\.h5\.journal: the journal ends here"):
        port.read(10, 1.0)
    port.write(b"more")


def test_a_journal_of_nothing_ends_at_once(tmp_path: Path) -> None:
    port = replay(tmp_path)
    assert (port.now(), port.end) == (0.0, None)
    with pytest.raises(LinkError, match="ends here"):
        port.read(10, 1.0)


def test_an_answer_comes_at_its_time_and_not_before_its_question(tmp_path: Path) -> None:
    port = replay(
        tmp_path, (SENT, 10.0, b"ask"), (RECEIVED, 10.5, b"first"), (RECEIVED, 10.75, b"second")
    )
    assert port.read(100, 0.125) == b""
    assert port.now() == 10.125
    port.write(b"as")
    assert port.read(100, 0.125) == b""
    port.write(b"k")
    assert port.read(100, 0.125) == b""  # it is not there yet
    assert port.now() == 10.375
    assert port.read(100, 0.125) == b"first"
    assert port.now() == 10.5
    assert port.read(100, 0.125) == b""
    assert port.read(100, 0.125) == b"second"
    assert port.now() == 10.75


def test_bytes_that_are_long_there_come_at_once_and_time_does_not_go_back(tmp_path: Path) -> None:
    port = replay(
        tmp_path, (RECEIVED, 5.0, b"a"), (SENT, 6.0, b"q"), (RECEIVED, 5.5, b"b"),
        (RECEIVED, 7.0, b"c"),
    )  # fmt: skip
    assert port.read(100, 0.0) == b"a"
    assert port.read(100, 0.75) == b""  # the question is still to come
    port.write(b"q")
    assert port.read(100, 0.0) == b"b"
    assert port.now() == 5.75
    assert port.read(100, 2.0) == b"c"


def test_what_is_sent_ahead_counts_for_the_questions_to_come(tmp_path: Path) -> None:
    port = replay(
        tmp_path, (SENT, 1.0, b"one"), (RECEIVED, 1.0, b"1"), (SENT, 1.0, b"two"),
        (RECEIVED, 1.0, b"2"), (SENT, 1.0, b"3"), (RECEIVED, 1.0, b"3"),
    )  # fmt: skip
    port.write(b"onetw")
    assert port.read(100, 0.0) == b"1"
    assert port.read(100, 0.0) == b""
    port.write(b"o")
    assert port.read(100, 0.0) == b"2"
    assert port.read(100, 0.0) == b""  # nothing is left over
    port.write(b"3")
    assert port.read(100, 0.0) == b"3"


@pytest.mark.parametrize("early", [b"", b"as"])
def test_a_client_that_asks_less_is_waited_for_a_second(tmp_path: Path, early: bytes) -> None:
    port = replay(
        tmp_path, (SENT, 2.0, b"ask"), (RECEIVED, 2.0, b"1"), (SENT, 3.0, b"?"),
        (RECEIVED, 3.0, b"2"),
    )  # fmt: skip
    port.write(early)
    assert [port.read(100, 0.5), port.read(100, 0.5)] == [b"", b""]
    assert port.read(100, 0.5) == b"1"
    assert port.now() == 3.0
    assert port.read(100, 0.0) == b""
    port.write(b"?")
    assert port.read(100, 0.0) == b"2"


def test_a_mark_of_another_kind_is_damage(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="a header or mark is damaged: end cannot be 3"):
        replay(tmp_path, (MARK, 1.0, b'{"end": 3}'))
