"""What the wire's decoder and codec promise of any bytes; replayed by the suite and fuzzed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from motorid.wire import codec, framing
from motorid.wire.spec import load

CORPUS = Path(__file__).with_name("wire_corpus.txt")


def corpus() -> list[bytes]:
    """The inputs kept, one a line in hexadecimal."""
    return [bytes.fromhex(line) for line in CORPUS.read_text(encoding="ascii").splitlines()]


def check(data: bytes) -> None:
    """Raises when some bytes break a promise: as a stream, as a payload, and around a frame."""
    check_stream(data)
    check_payload(data)
    check_recovery(data)


def check_stream(data: bytes) -> None:
    """Splits do not matter, and what comes out is bounded and was checked."""
    found = framing.Decoder().feed(data)
    half = len(data) // 2
    decoder = framing.Decoder()
    assert decoder.feed(data[:half]) + decoder.feed(data[half:]) == found
    for item in found:
        if isinstance(item, framing.Frame):
            assert framing.Decoder().feed(framing.encode(item.payload)) == [item]
            check_payload(item.payload)
        else:
            assert len(item.data) < load().max_frame


def check_payload(payload: bytes) -> None:
    """A payload decodes or is refused; what decodes is read the same after being written again."""
    try:
        message = codec.decode(payload)
    except codec.BadPayload:
        return
    again = encode(message)
    if again is not None:
        assert repr(codec.decode(again)) == repr(message)


def encode(message: codec.Command | codec.Reply | codec.Event | codec.SampleBlock) -> bytes | None:
    """The message's payload; None where a text on the wire was not ASCII."""
    if not isinstance(message, codec.SampleBlock) and any(
        isinstance(text, str) and "\N{REPLACEMENT CHARACTER}" in text
        for text in message.fields.values()
    ):
        return None
    match message:
        case codec.SampleBlock():
            return codec.encode_event(
                message.name,
                sequence=message.sequence,
                first_tick=message.first_tick,
                dropped=message.dropped,
                position=message.position,
                channels=codec.channel_mask(message.channels),
                samples=message.samples,
            )
        case codec.Event():
            return codec.encode_event(message.name, **message.fields)
        case codec.Command():
            return codec.encode_command(message.name, message.request, **message.fields)
    return codec.encode_reply(message.name, message.request, message.status, **message.fields)


def check_recovery(noise: bytes) -> None:
    """After any noise and a delimiter, the next frame is found."""
    payload = noise[: load().max_payload] or b"\0"
    found = framing.Decoder().feed(noise + framing.DELIMITER + framing.encode(payload))
    assert found[-1] == framing.Frame(payload)


def seeds() -> Iterator[bytes]:
    """The corpus, each input also as a frame where it fits one."""
    for data in corpus():
        yield data
        if 0 < len(data) <= load().max_payload:
            yield framing.encode(data)
