"""What a link loses when the board sends as fast as it can, which a run does not always show.

``identify`` changes nothing and is answered afresh each time, with the longest reply there is. A
few of them on their way at once keep the board's transmitter busy. A board's receiver holds 64
bytes at least.
"""

from __future__ import annotations

from dataclasses import dataclass

from motorid.acquire.link import Port
from motorid.wire.codec import BadPayload, Reply, decode, encode_command
from motorid.wire.framing import DELIMITER, BadFrame, Decoder, encode
from motorid.wire.spec import load

COMMANDS = 256  # about 23 kB of replies
AT_ONCE = 4  # 36 bytes
SILENT = 3  # times in a row that nothing is answered: the line is dead
READ_BYTES = 4096


@dataclass(frozen=True)
class LinkTest:
    """Commands sent and answered, and frames that came damaged."""

    sent: int
    answered: int
    damaged: int

    @property
    def clean(self) -> bool:
        """Nothing was lost and nothing damaged."""
        return self.answered == self.sent and not self.damaged

    def sentence(self) -> str:
        """For a person: the figures, and what to do where they are bad."""
        said = (
            f"link: {self.answered} of {self.sent} commands answered, {self.damaged} frames damaged"
        )
        if self.clean:
            return said
        return (
            f"{said}: it loses data under load; take a shorter cable, a port of the computer "
            "itself, or another USB bridge (docs/board-pins.md)"
        )


class _Test:
    def __init__(self, port: Port) -> None:
        spec = load()
        self.port = port
        self.patience_s = spec.limits.reply_deadline_ms * 1e-3
        self.version = {"host_major": spec.major, "host_minor": spec.minor}
        self.decoder = Decoder()
        self.waiting: list[int] = []  # requests, in the order of their sending
        self.sent = self.answered = self.damaged = 0

    def run(self, commands: int) -> LinkTest:
        self.port.write(DELIMITER)
        silent, heard_at = 0, self.port.now()
        while silent < SILENT and (self.sent < commands or self.waiting):
            self.fill(commands)
            before = self.answered
            self.hear()
            if self.answered > before:
                silent, heard_at = 0, self.port.now()
            elif self.port.now() - heard_at >= self.patience_s:
                self.waiting.clear()
                silent, heard_at = silent + 1, self.port.now()
        return LinkTest(self.sent, self.answered, self.damaged)

    def fill(self, commands: int) -> None:
        while len(self.waiting) < AT_ONCE and self.sent < commands:
            self.sent += 1
            self.waiting.append(self.sent)
            self.port.write(encode(encode_command("identify", self.sent, **self.version)))

    def hear(self) -> None:
        for frame in self.decoder.feed(self.port.read(READ_BYTES, self.patience_s / 4)):
            if isinstance(frame, BadFrame):
                self.damaged += 1
                continue
            try:
                message = decode(frame.payload)
            except BadPayload:
                self.damaged += 1
                continue
            if isinstance(message, Reply) and message.request in self.waiting:
                self.answered += 1
                # the board answers in order: what it should have answered before is lost
                del self.waiting[: self.waiting.index(message.request) + 1]


def measure_link(port: Port, commands: int = COMMANDS) -> LinkTest:
    """Sends ``commands`` of them to an identified board at rest, and counts what comes back."""
    return _Test(port).run(commands)
