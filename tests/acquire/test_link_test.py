"""The test of a link, over a line made by hand that loses, spoils and delays what it is told to."""

from __future__ import annotations

from collections.abc import Collection

import pytest

from motorid.acquire import link_test
from motorid.acquire.link_test import LinkTest, measure_link
from motorid.wire.codec import Command, decode, encode_reply
from motorid.wire.enums import Status
from motorid.wire.framing import Decoder, Frame, encode
from motorid.wire.spec import load

PATIENCE_S = 0.5


class Line:
    """Answers each command ``late_s`` after it came, but those that are lost."""

    name = "line"

    def __init__(self, lost: Collection[int] = (), late_s: float = 0.0) -> None:
        self.lost, self.late_s, self.time = lost, late_s, 0.0
        self.first, self.heard, self.reads = b"", list[Command](), 0
        self.coming: list[tuple[float, bytes]] = []
        self.most = 0  # commands on their way at once
        self._decoder = Decoder()

    def write(self, data: bytes) -> None:
        self.first = self.first or data
        for frame in self._decoder.feed(data):
            assert isinstance(frame, Frame)
            command = decode(frame.payload)
            assert isinstance(command, Command)
            self.heard.append(command)
            if command.request not in self.lost:
                self.says(encode(encode_reply("identify", command.request, Status.BAD_STATE)))
        self.most = max(self.most, len(self.coming))

    def says(self, data: bytes) -> None:
        self.coming.append((self.time + self.late_s, data))

    def read(self, size: int, timeout_s: float) -> bytes:
        self.reads += 1
        if self.coming and self.coming[0][0] <= self.time + timeout_s:
            due, data = self.coming.pop(0)
            self.time = max(self.time, due)
            return data
        self.time += timeout_s
        return b""

    def now(self) -> float:
        return self.time

    def close(self) -> None:
        """Nothing is held."""


def run(line: Line, commands: int) -> LinkTest:
    test = link_test._Test(line)
    test.patience_s = PATIENCE_S
    return test.run(commands)


def test_a_whole_line_answers_all_with_four_on_their_way() -> None:
    line = Line()
    assert measure_link(line, 10) == LinkTest(10, 10, 0)
    assert (line.first, line.most, line.time) == (b"\0", 4, 0.0)
    assert [one.request for one in line.heard] == list(range(1, 11))
    spec = load()
    version = {"host_major": spec.major, "host_minor": spec.minor}
    assert all((one.name, one.fields) == ("identify", version) for one in line.heard)
    assert link_test._Test(line).patience_s == spec.limits.reply_deadline_ms / 1000


def test_what_is_lost_before_an_answer_is_not_waited_for() -> None:
    line = Line(lost={1, 2, 5})
    assert run(line, 8) == LinkTest(8, 5, 0)
    assert line.time == 0.0
    line = Line(lost={8})
    assert run(line, 8) == LinkTest(8, 7, 0)
    assert line.time == PATIENCE_S


@pytest.mark.parametrize(
    "bad",
    [b"\x05abcd\0", encode(b"\xff\xff\xff\xff"), b"\x01\x01\0"],
    ids=("wrong check", "no message", "no frame"),
)
def test_damaged_frames_are_counted(bad: bytes) -> None:
    line = Line()
    line.says(bad + bad)
    assert run(line, 4) == LinkTest(4, 4, 2)


def test_an_answer_to_nothing_asked_is_none() -> None:
    line = Line()
    for request in (99, 0):
        line.says(encode(encode_reply("identify", request, Status.BAD_STATE)))
    assert run(line, 4) == LinkTest(4, 4, 0)


def test_three_silences_in_a_row_end_it() -> None:
    line = Line(lost=range(1, 100))
    assert run(line, 40) == LinkTest(12, 0, 0)
    assert (line.time, line.reads) == (3 * PATIENCE_S, 12)


def test_an_answer_between_silences_lets_it_go_on() -> None:
    line = Line(lost={*range(1, 9), *range(13, 21)})
    assert run(line, 24) == LinkTest(24, 8, 0)
    assert line.time == 4 * PATIENCE_S


def test_silence_counts_from_the_last_answer() -> None:
    line = Line(lost=range(2, 100), late_s=0.375)
    assert run(line, 40) == LinkTest(13, 1, 0)
    assert line.time == 0.375 + 3 * PATIENCE_S


@pytest.mark.parametrize(
    ("found", "clean"),
    [(LinkTest(5, 5, 0), True), (LinkTest(5, 4, 0), False), (LinkTest(5, 5, 1), False)],
)
def test_a_link_is_clean_where_nothing_is_lost_or_damaged(found: LinkTest, clean: bool) -> None:
    said = found.sentence()
    assert found.clean is clean
    assert said.startswith(
        f"link: {found.answered} of 5 commands answered, {found.damaged} frames damaged"
    )
    assert ("it loses data under load" in said) is not clean
