"""The client of a board over a wire made by hand: tries, refusals, resets, and who is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from motorid.acquire.board import AskedToStopError, Board
from motorid.acquire.resets import BoardResetError
from motorid.errors import LinkError, MotoridError, RigError
from motorid.wire.codec import Command, decode, encode_event, encode_reply
from motorid.wire.enums import Channel, Mode, ResetCause, Status
from motorid.wire.framing import Decoder, Frame, encode
from motorid.wire.hashes import layout_hash
from motorid.wire.spec import load

SPEC = load()
IDENTITY = {
    "protocol_major": SPEC.major, "protocol_minor": SPEC.minor, "layout_hash": layout_hash(),
    "board": "bench", "boot_id": 7, "clock_hz": 1000, "min_sample_period_ticks": 10,
    "channel_count": 2,
}  # fmt: skip
FACTS = (
    {"channel": Channel.CURRENT, "scale": 0.5},
    {"channel": Channel.POSITION, "scale": 1.0},
)
Answer = Callable[[Command], list[bytes]]


def reply(command: Command, status: Status = Status.OK, **fields: Any) -> bytes:
    """The payload that answers a command, its other fields 0."""
    blank = {
        one.name: "" if one.type == "text16" else 0 for one in SPEC.commands[command.name].reply
    }
    return encode_reply(command.name, command.request, status, **(blank | fields))


def hello(cause: ResetCause = ResetCause.BROWN_OUT) -> bytes:
    return encode_event("hello", boot_id=8, reset_cause=cause)


class Wire:
    """A port whose board answers by ``answer``; time passes where nothing comes."""

    name = "wire"

    def __init__(self, answer: Answer = lambda command: []) -> None:
        self.answer, self.time, self.coming = answer, 100.0, b""
        self.raw, self.heard, self.waits = b"", list[Command](), list[float]()
        self._decoder = Decoder()

    def write(self, data: bytes) -> None:
        self.raw += data
        for frame in self._decoder.feed(data):
            assert isinstance(frame, Frame)
            command = decode(frame.payload)
            assert isinstance(command, Command)
            self.heard.append(command)
            said = b"".join(map(encode, self.answer(command)))
            self.coming += said

    def read(self, size: int, timeout_s: float) -> bytes:
        self.waits.append(timeout_s)
        if not self.coming:
            self.time += timeout_s
        data, self.coming = self.coming[:size], self.coming[size:]
        return data

    def now(self) -> float:
        return self.time

    def close(self) -> None:
        """Nothing is held."""


def whole(command: Command) -> list[bytes]:
    """A board that is well, of two channels."""
    match command.name:
        case "identify":
            return [reply(command, **IDENTITY)]
        case "describe_channel":
            return [reply(command, **FACTS[command.fields["index"]])]
    return [reply(command, tick=5)] if command.name == "read_status" else [reply(command)]


def known(answer: Answer = whole) -> tuple[Board, Wire]:
    """A board that was identified when it was well."""
    wire = Wire(whole)
    board = Board(wire)
    board.identify()
    wire.answer = answer
    wire.heard.clear()
    wire.waits.clear()
    return board, wire


# -- one question
@pytest.mark.parametrize(("first", "request_id"), [(1, 2), (9, 10), (0xFFFE, 0xFFFF), (0xFFFF, 1)])
def test_requests_go_on_from_the_first(first: int, request_id: int) -> None:
    wire = Wire()
    Board(wire, first).tell("stop")
    assert wire.heard == [Command("stop", request_id, {})]
    wire = Wire()
    Board(wire).tell("stop")
    assert wire.heard[0].request == 2


def test_a_question_is_sent_four_times_under_one_number() -> None:
    board, wire = known(lambda command: [])
    with pytest.raises(LinkError, match="wire: the board does not answer read_status any more"):
        board.ask("read_status")
    assert len({one.request for one in wire.heard}) == 1
    assert len(wire.heard) == 4
    assert wire.waits == pytest.approx([0.3] * 4)
    wire.heard.clear()
    with pytest.raises(LinkError, match="does not answer zero"):
        board.ask("zero", timeout_s=2.0, samples=16)
    assert wire.waits[4:] == pytest.approx([2.0] * 4)
    assert {one.fields["samples"] for one in wire.heard} == {16}


def test_an_answer_to_a_later_try_counts() -> None:
    board, wire = known(lambda command: [reply(command, tick=9)] * (len(wire.heard) == 3))
    assert board.ask("read_status")["tick"] == 9
    assert len(wire.heard) == 3


def test_the_first_answer_to_this_question_counts() -> None:
    def answers(command: Command) -> list[bytes]:
        late = Command(command.name, command.request - 1, {})
        other = Command("stop", command.request, {})
        return [
            reply(late, tick=1), reply(other), reply(command, tick=2), reply(command, tick=3)
        ]  # fmt: skip

    board, wire = known(answers)
    before = board.good_frames
    assert board.ask("read_status")["tick"] == 2
    assert (board.good_frames, board.bad_frames, len(wire.heard)) == (before + 4, 0, 1)


@pytest.mark.parametrize(
    ("status", "kind", "says"),
    [
        (Status.BAD_VALUE, RigError, "compare rig and board"),
        (Status.BAD_STATE, LinkError, "a state that does not allow it"),
        (Status.NOT_CONFIGURED, LinkError, "has lost what it was sent"),
        (Status.NOT_AT_REST, RigError, "let it come to rest first"),
        (Status.UNKNOWN_COMMAND, LinkError, "this is a fault of the firmware"),
    ],
)
def test_a_refusal_says_why(status: Status, kind: type[MotoridError], says: str) -> None:
    def refuses(command: Command) -> list[bytes]:
        return [reply(command, status)] if command.name == "stop" else whole(command)

    board, wire = known(refuses)
    with pytest.raises(
        kind, match=rf"wire: the board refused stop \({status.name.lower()}\): "
    ) as e:
        board.ask("stop")
    assert says in str(e.value)
    assert [one.name for one in wire.heard] == ["stop", "identify"]  # whether it is the same


def test_a_board_that_was_reset_says_so_rather_than_refuses() -> None:
    def anew(command: Command) -> list[bytes]:
        other = IDENTITY | {"boot_id": 8, "reset_cause": ResetCause.EXTERNAL}
        if command.name == "identify":
            return [reply(command, **other)]
        return [reply(command, Status.NOT_CONFIGURED)]

    board, _ = known(anew)
    with pytest.raises(BoardResetError, match=r"was reset while it was in use \(external\)"):
        board.ask("start", config_hash=1, program_hash=2)


def test_a_greeting_in_use_is_a_reset_at_once() -> None:
    board, wire = known(lambda command: [hello()])
    with pytest.raises(BoardResetError, match=r"in use \(brown_out\)"):
        board.ask("read_status")
    assert len(wire.heard) == 1
    with pytest.raises(BoardResetError):
        board.check_same()
    wire = Wire()
    early = Board(wire)
    wire.coming = encode(hello())
    early.hear(0.1)
    assert early.reset is None  # nobody has met it yet


def test_the_same_board_is_that_of_the_same_boot() -> None:
    board, wire = known()
    board.check_same()
    wire.answer = lambda command: [reply(command, **(IDENTITY | {"boot_id": 8}))]
    with pytest.raises(BoardResetError, match="was reset while it was in use"):
        board.check_same()
    wire.answer = lambda command: [reply(command, Status.BAD_STATE)]
    board.check_same()  # it does not say
    wire.heard.clear()
    wire.answer = lambda command: []
    board.check_same()
    assert len(wire.heard) == 4


# -- listening
def test_what_comes_is_counted_and_kept() -> None:
    board, wire = Board(Wire()), Wire()
    board.port = wire
    wire.coming = b"\x03ab\0" + encode(encode_event("phase", index=1, tick=2)) + encode(b"\x7e")
    wire.time = 102.0
    assert board.hear(0.25) is True
    assert (board.good_frames, board.bad_frames, board.heard_at) == (1, 2, 102.0)
    assert [one.name for one in board.news] == ["phase"]
    assert board.hear(0.25) is False
    assert (wire.waits, board.heard_at) == ([0.25, 0.25], 102.0)


def test_damage_is_no_sign_of_life() -> None:
    wire = Wire()
    board = Board(wire)
    wire.coming, wire.time = b"\x03ab\0", 103.0
    board.hear(0.25)
    assert board.heard_at == 100.0


def test_a_wait_hears_what_comes_and_ends_in_time() -> None:
    wire = Wire()
    board = Board(wire)
    wire.coming = encode(encode_event("phase", index=1, tick=2))
    board.wait(0.5)
    assert (len(board.news), wire.time) == (1, 100.5)
    assert wire.waits == [0.5, 0.5]


def test_a_host_that_may_be_asked_to_stop_waits_by_glances() -> None:
    board, wire = known(lambda command: [])
    asked: list[float] = []
    board.hasten = lambda: (asked.append(wire.time), len(asked) > 5)[1]
    with pytest.raises(AskedToStopError):
        board.ask("read_status")
    assert wire.waits == pytest.approx([0.02] * 5)
    assert len(wire.heard) == 1
    board.hasten = lambda: False
    with pytest.raises(LinkError, match="does not answer"):
        board.ask("read_status")
    assert sum(wire.waits[5:]) == pytest.approx(4 * 0.3)
    assert max(wire.waits[5:]) <= 0.02


def test_its_ticks_are_asked_for_so_often() -> None:
    board, wire = known()
    board.ask_ticks(3)
    assert [one.name for one in wire.heard] == ["read_status"] * 3


# -- who is there
def test_a_board_is_asked_who_it_is_and_what_it_measures() -> None:
    wire = Wire(whole)
    board = Board(wire)
    assert board.identify() is board.identity
    assert board.identity["board"] == "bench"
    assert wire.raw[:1] == b"\0"  # ends what it may have half read
    assert [one.name for one in wire.heard] == ["identify", *["describe_channel"] * 2]
    assert wire.heard[0].fields == {"host_major": SPEC.major, "host_minor": SPEC.minor}
    assert [one.fields for one in wire.heard[1:]] == [
        {"index": index, "mode": Mode.STREAM} for index in range(2)
    ]
    assert {name: fact["scale"] for name, fact in board.descriptors.items()} == {
        "current": 0.5, "position": 1.0,
    }  # fmt: skip
    board.describe(Mode.BURST)
    assert [one.fields["mode"] for one in wire.heard[3:]] == [Mode.BURST] * 2


def test_a_board_that_boots_is_waited_for_five_seconds() -> None:
    wire = Wire()
    with pytest.raises(LinkError, match="nothing answers: is the board powered"):
        Board(wire).identify()
    assert len(wire.heard) == 10
    assert wire.time == pytest.approx(105.0)


@pytest.mark.parametrize(
    ("status", "facts", "says"),
    [
        (Status.MAJOR_MISMATCH, {}, "speaks another version of the protocol than"),
        (Status.BAD_STATE, {}, "refused to identify itself: reset it"),
        (Status.OK, {"protocol_major": SPEC.major + 1}, r"speaks protocol \d+\.\d+, this motorid"),
        (Status.OK, {"layout_hash": 1}, "messages differ from this motorid's though both say"),
        (Status.OK, {"layout_hash": 1, "protocol_minor": SPEC.minor - 1}, None),
        (Status.OK, {"clock_hz": 0}, "the board says clock_hz = 0: its firmware is at fault"),
        (Status.OK, {}, None),
    ],
)
def test_a_board_that_cannot_be_used_says_why(
    status: Status, facts: dict[str, int], says: str | None
) -> None:
    def answers(command: Command) -> list[bytes]:
        if command.name != "identify":
            return whole(command)
        return [reply(command, status, **(IDENTITY | facts))]

    board = Board(Wire(answers))
    if says is None:
        assert board.identify()["board"] == "bench"
        return
    with pytest.raises(LinkError, match=f"^wire: .*{says}"):
        board.identify()
    assert board.identity == {}


def test_a_channel_that_none_can_be_is_the_firmware_s_fault() -> None:
    def answers(command: Command) -> list[bytes]:
        named = command.name == "describe_channel"
        return [reply(command, channel=Channel.CURRENT)] if named else whole(command)

    with pytest.raises(LinkError, match=r"describes its channel current with scale = 0\.0: its f"):
        Board(Wire(answers)).identify()


def test_something_that_sends_is_told_from_a_board_that_does_not_listen() -> None:
    def noise(command: Command) -> list[bytes]:
        wire.coming += b"text\r\n"
        return []

    wire = Wire(noise)
    with pytest.raises(LinkError, match=r"something sends there \(60 bytes\)"):
        Board(wire).identify()
    with pytest.raises(LinkError, match="a motorid board speaks there but does not answer"):
        Board(Wire(lambda command: [encode_event("phase", index=0, tick=0)])).identify()
