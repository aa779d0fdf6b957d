"""Frames on the wire: COBS(payload + CRC-16, little-endian) and a zero byte. Pure.

COBS is Cheshire and Baker's, "Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on
Networking 7(2), 1999: after it no byte is zero, so a receiver that lost its place finds the next
frame at the next zero.
"""

from __future__ import annotations

from binascii import crc_hqx
from dataclasses import dataclass

from motorid.wire.spec import load

DELIMITER = b"\0"
CRC_SIZE = 2
GROUP = 254  # most bytes that one COBS code stands before


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame whose check held."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class BadFrame:
    """What stood between two delimiters and was no frame; ``data`` is as received, cut if long."""

    reason: str
    data: bytes


class CobsError(ValueError):
    """Bytes that no COBS encoder writes."""


def crc16(data: bytes) -> int:
    """CRC-16/IBM-3740 (polynomial 0x1021, initial 0xFFFF, not reflected) of ``data``."""
    return crc_hqx(data, load().crc.initial)


def cobs_encode(data: bytes) -> bytes:
    """``data`` without its zeros, one code byte before each run (no delimiter)."""
    out = bytearray()
    runs = data.split(DELIMITER)
    for run in runs:
        while len(run) >= GROUP:
            out.append(GROUP + 1)
            out += run[:GROUP]
            run = run[GROUP:]
        out.append(len(run) + 1)
        out += run
    if runs[-1] and len(runs[-1]) % GROUP == 0:
        del out[-1]  # a full group at the end says all: it stands for no zero
    return bytes(out)


def cobs_decode(data: bytes) -> bytes:
    """The bytes that ``cobs_encode`` was given. Raises CobsError."""
    out = bytearray()
    at, end = 0, len(data)
    while at < end:
        code = data[at]
        stop = at + code
        if not code or stop > end:
            raise CobsError("a COBS code that points past the frame's end")
        out += data[at + 1 : stop]
        if code <= GROUP and stop < end:
            out.append(0)
        at = stop
    return bytes(out)


def encode(payload: bytes) -> bytes:
    """The frame of a payload, its delimiter included. Raises ValueError when it is too long."""
    limit = load().max_payload
    if not 0 < len(payload) <= limit:
        raise ValueError(f"a payload has 1 to {limit} bytes, not {len(payload)}")
    check = crc16(payload).to_bytes(CRC_SIZE, "little")
    return cobs_encode(payload + check) + DELIMITER


class Decoder:
    """Finds the frames in a stream that arrives in pieces of any size.

    Holds at most one frame's bytes, whatever arrives. Empty frames are skipped: a sender may put
    a delimiter wherever it wants to end what a receiver may have half read.
    """

    def __init__(self) -> None:
        self._limit = load().max_frame - 1
        self._held = bytearray()
        self._skipping = False  # too long already, and said so: wait for the delimiter

    def feed(self, data: bytes) -> list[Frame | BadFrame]:
        """Frames that end in ``data``, and what was no frame, in the order of arrival."""
        found: list[Frame | BadFrame] = []
        first, *others = data.split(DELIMITER)
        self._hold(first, found)
        for part in others:
            self._end(found)
            self._hold(part, found)
        return found

    def _hold(self, part: bytes, found: list[Frame | BadFrame]) -> None:
        if self._skipping:
            return
        room = self._limit - len(self._held)
        self._held += part[:room]
        if len(part) > room:
            found.append(BadFrame("longer than any frame", bytes(self._held)))
            self._held.clear()
            self._skipping = True

    def _end(self, found: list[Frame | BadFrame]) -> None:
        if self._held:
            found.append(_open(bytes(self._held)))
            self._held.clear()
        self._skipping = False


def _open(data: bytes) -> Frame | BadFrame:
    """The frame in the bytes between two delimiters."""
    try:
        body = cobs_decode(data)
    except CobsError as error:
        return BadFrame(str(error), data)
    if len(body) <= CRC_SIZE:
        return BadFrame("shorter than any frame", data)
    payload, check = body[:-CRC_SIZE], body[-CRC_SIZE:]
    if crc16(payload) != int.from_bytes(check, "little"):
        return BadFrame("the check does not match", data)
    return Frame(payload)
