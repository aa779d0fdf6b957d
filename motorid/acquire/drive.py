"""One run of a loaded program: start, heartbeats as samples are consumed, and the end."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from motorid.acquire.board import AskedToStopError, Board, Fields
from motorid.acquire.interrupt import Asked
from motorid.acquire.plan import WireProgram
from motorid.acquire.resets import reset_error
from motorid.errors import DataError, LinkError
from motorid.wire.codec import Event, SampleBlock, name_of
from motorid.wire.enums import Channel, EndReason, Fault, Input, Mode, State
from motorid.wire.spec import load as load_spec

POLL_S = 0.02
BEATS = 10  # in the time after which the board gives the host up: a busy computer skips some
SILENCE_S = 1.0
LULL_S = 1.0  # without news when some was due: ask
LATEST_S = 120.0  # after its end a slow link may still bring what the board kept
MOST_KEPT = 1 << 16  # samples that a board keeps
SPARE = 1000
EARLY = 0.5  # of the program, which no clock runs that fast
STOPPED = "stopped"


def load(board: Board, program: WireProgram) -> None:
    """Puts a program on the board. Raises LinkError when it did not arrive as sent."""
    board.ask("clear_program")
    replies = [board.ask("add_step", **step) for step in program.steps]
    if replies[-1]["program_hash"] != program.hash:
        raise LinkError(f"{board.port.name}: the program did not arrive as sent: try again")


def drive(
    board: Board,
    program: WireProgram,
    config: Fields,
    stop: Asked,
    consume: Callable[[SampleBlock], None],
) -> str:
    """Runs the loaded program; returns why it ended: completed, stopped, or fault: NAME.

    Raises LinkError when the board resets or goes silent. Every way out asks for an open bridge.
    """
    if stop.requested:
        return STOPPED  # before anything moved
    run = _Run(board, program, config, stop, consume)
    reason = ""
    board.hasten = run.must_stop
    try:
        board.news.clear()
        board.trip = ""
        if run.begin(program, config):
            reason = run.follow()
    finally:
        board.hasten = None
        if not reason:
            with contextlib.suppress(LinkError, DataError):  # courtesy: the board stops by itself
                board.tell("stop")
    return reason or STOPPED


class _Run:
    def __init__(
        self,
        board: Board,
        program: WireProgram,
        config: Fields,
        stop: Asked,
        consume: Callable[[SampleBlock], None],
    ) -> None:
        self.board, self.stop, self.consume = board, stop, consume
        most_s = load_spec().limits.heartbeat_period_ms / 1e3
        self.silence_s = config["host_silence_ms"] / 1e3
        self.beat_s = min(most_s, self.silence_s / BEATS)
        self.patience_s = max(SILENCE_S, self.silence_s)
        self.start_s = self.pause_s = 0.0  # that start took, and between two heartbeats at most
        self.duration_s = program.ticks / board.identity["clock_hz"]
        period_s = config["sample_period_ticks"] / board.identity["clock_hz"]
        self.lull_s = LULL_S + 2 * period_s
        if config["mode"] == Mode.BURST:  # which says nothing until the run is over
            self.lull_s += self.duration_s
        self.sequence = 0
        self.fault = ""
        self.stopping = False
        self.earliest_s = 0.0  # of the port's clock, when the program can be over
        # what a board may say of one run: more is no run, and would never end
        planned = program.ticks // config["sample_period_ticks"]
        self.left = 2 * planned + 2 * len(program.steps) + SPARE

    def must_stop(self) -> bool:
        """Whether a stop was asked for, and the board does not know yet."""
        return self.stop.requested and not self.stopping

    def begin(self, program: WireProgram, config: Fields) -> bool:
        """Starts the run; False where a stop was asked for before the board's reply came."""
        hashes = {"config_hash": config["config_hash"], "program_hash": program.hash}
        asked_at = self.board.port.now()
        try:
            self.board.ask("start", **hashes)
        except AskedToStopError:
            return False
        self.start_s = self.board.port.now() - asked_at
        return True

    def follow(self) -> str:
        """Consumes until the board is done."""
        board, now = self.board, self.board.port.now
        beat_at = beaten_at = began = now()
        self.earliest_s = began + EARLY * self.duration_s
        board.heard_at = progressed = began
        over_at = began + self.duration_s + LULL_S
        while True:
            board.hear(POLL_S)
            self.expect_life()  # just after listening: this computer's own delays are no silence
            while board.news:
                progressed = now()
                reason = self.take(board.news.popleft())
                if reason is not None:
                    return reason
            if self.must_stop():
                self.stopping = True
                self.left = min(self.left, MOST_KEPT + SPARE)
                over_at = min(over_at, now())
                board.tell("stop")
            if now() >= beat_at:
                self.pause_s, beaten_at = max(self.pause_s, now() - beaten_at), now()
                beat_at = beaten_at + self.beat_s
                board.tell("heartbeat", sequence=self.sequence)
            if now() > over_at + LATEST_S:
                raise self.endless()
            if now() - progressed > (LULL_S if self.stopping else self.lull_s):
                if reason := self.ended_unheard(now() > over_at):
                    return reason
                progressed = now()

    def expect_life(self) -> None:
        """Raises LinkError when nothing has come for too long."""
        port = self.board.port
        if port.now() - self.board.heard_at > self.patience_s:
            raise LinkError(
                f"{port.name}: the board went silent in mid-run; it stops the motor by itself: "
                "check the cable and the board's power"
            )

    def ended_unheard(self, should: bool) -> str:
        """Why the run ended when the word of it was lost on the link; "" when it goes on.

        Raises LinkError when the board was reset, or says that it still runs when it should not.
        """
        try:
            status = self.board.ask("read_status")
            if self.board.news:
                return ""  # it was only late
            if status["state"] == State.RUNNING:
                if should:
                    raise self.endless()
                return ""
            self.board.check_same()
        except AskedToStopError:
            return ""
        if status["fault"]:
            self.board.trip = self.told_of(status["fault"])
            return f"fault: {name_of(Fault, status['fault'])}"
        return STOPPED if self.stop.requested else "completed"

    def told_of(self, fault: int) -> str:
        """How the board came to hear no heartbeat, as far as this side can tell; "": another trip.

        None goes out before the reply to start has come.
        """
        if fault != Fault.HOST_SILENCE:
            return ""
        none = f"no heartbeat came for {self.silence_s:g} s"
        if self.start_s > self.silence_s / 2:
            return f"{none}; its reply to start was lost on the link, or {self.start_s:.2g} s late"
        if self.pause_s > self.silence_s / 2:
            return f"{none}; this computer sent none for {self.pause_s:.2g} s"
        return f"{none}; they were sent, and lost on the link"

    def endless(self) -> LinkError:
        """A board that goes on and on."""
        return LinkError(f"{self.board.port.name}: the run does not end: reset the board")

    def take(self, news: Event | SampleBlock) -> str | None:
        """Acts on one piece of news; the reason when the run is over."""
        self.left -= len(news.samples) if isinstance(news, SampleBlock) else 1
        if self.left < 0:
            raise self.endless()
        if isinstance(news, SampleBlock):
            self.sequence = news.sequence
            self.consume(news)
            return None
        match news.name:
            case "fault":
                self.fault = name_of(Fault, news.fields["fault"])
                self.board.trip = self.told_of(news.fields["fault"]) or of_fault(news.fields)
            case "hello":
                raise reset_error(self.board.port.name, news.fields["reset_cause"], "in mid-run")
            case "done":
                return self.done(news.fields["reason"])
        return None

    def done(self, reason: int) -> str:
        """The board's word on the end; a stop goes out where it cannot be so."""
        if reason == EndReason.COMPLETED and self.board.port.now() < self.earliest_s:
            self.board.tell("stop")
        if reason != EndReason.FAULT:
            return name_of(EndReason, reason)
        if not self.fault:  # its own event was lost
            found = self.board.ask("read_status")["fault"]
            self.fault, self.board.trip = name_of(Fault, found), self.told_of(found)
        return f"fault: {self.fault}"


ADVICE = {
    Fault.OVER_CURRENT: "lower the level, and check the motor for a short",
    Fault.OVER_SPEED: "check wiring.counts_per_turn and gear_ratio, then lower the level",
    Fault.SUPPLY_LOW: "the supply sagged or is off: use a stronger one, or lower supply_min_v",
    Fault.SUPPLY_HIGH: "braking pumped the supply up, or it is set too high: check it",
    Fault.RUN_TIME: "shorten the program",
    Fault.HOST_SILENCE: "check the cable, and where this computer was late, close other programs",
    Fault.ENCODER_EDGES: "edges came faster than the board can count: lower the level",
    Fault.DRIVER: "the bridge reports a fault: check its wiring, heat and supply",
    Fault.OVER_VOLTAGE: "the terminals had more than limits.voltage_v: lower the level",
    Fault.WRONG_SIGN: "that reading went against the drive: check the "
    "wires of motor, sensors and encoder, or whether a load turns the motor",
    Fault.INPUT_OPENED: "a contact of limits.inputs opened: close guard and fixture",
    Fault.WATCHDOG: "the firmware hung and was restarted: please report it",
}


def of_fault(fault: Fields) -> str:
    """Which channel or contacts a fault is of, by its value; "" for those whose name says it."""
    value = fault["value"]
    match fault["fault"]:
        case Fault.WRONG_SIGN:
            return name_of(Channel, value)
        case Fault.INPUT_OPENED:
            return " and ".join(one.name.lower() for one in Input if value >> one & 1)
    return ""


def tripped(reason: str, told: str = "") -> str:
    """A trip ("fault: NAME") in a sentence, with what the board told of it (``Board.trip``)."""
    name = reason.removeprefix("fault: ")
    advice = {name_of(Fault, key): text for key, text in ADVICE.items()}
    return (
        f"the board tripped ({name}{f': {told}' if told else ''}) and opened the bridge: "
        f"{advice.get(name, 'see the documentation of its firmware')}"
    )
