"""A board that is watched without a capture: its bridge open, or for one bounded program driven."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from motorid.acquire.board import Board, Fields
from motorid.acquire.check import check_signs, check_supply, check_zero
from motorid.acquire.contacts import check_inputs
from motorid.acquire.controls import Controls, Press
from motorid.acquire.drive import drive, load, tripped
from motorid.acquire.guards import signs
from motorid.acquire.held_program import refuse_held
from motorid.acquire.interrupt import Asked
from motorid.acquire.link import Port
from motorid.acquire.plan import WireProgram, sample_period, wire_program
from motorid.acquire.record import ZERO_S, configure, streaming
from motorid.acquire.safety import check_program
from motorid.acquire.tap import Watch, run_facts
from motorid.errors import LinkError, MotoridError, RigError
from motorid.program import Program, Step, StepKind
from motorid.rig import Rig
from motorid.wire.codec import SampleBlock

WATCH_S = 60.0  # of one run with the bridge open, after which the next begins
SHARE = 0.9  # of limits.run_time_s at most
SURE_S = 0.5  # of samples, after which a trouble is over
AGAIN_S = 1.0  # after a run that the board refused or ended
Say = Callable[[str, str], None]  # a state, and a sentence
WATCHING, DRIVING, STOPPED, DONE, REFUSED = "watching", "driving", "stopped", "done", "refused"


@dataclass(frozen=True)
class _Until:
    """A stop that several may ask for."""

    ask: Callable[[], bool]

    @property
    def requested(self) -> bool:
        return self.ask()


class Scope:
    """Streams a board's samples to ``watch`` until it is asked to end.

    The bridge is open except in the programs that ``controls`` brings. Each of them goes through
    the checks of a capture: the rig's limits, contacts, zero, supply, a weak pulse first.
    Raises LinkError when the board is lost, RigError where the rig does not suit it.
    """

    def __init__(self, port: Port, rig: Rig, watch: Watch, controls: Controls, say: Say) -> None:
        self.board = Board(port)
        self.board.identify()
        self.board.make_ready()
        self.rig = streaming(rig, self.board)
        if self.rig.sampling.mode != "stream":
            self.rig = replace(self.rig, sampling=replace(self.rig.sampling, mode="stream"))
        self.watch, self.controls, self.say = watch, controls, say
        self.config = configure(self.board, self.rig)
        self.zero = self._zeroed()
        self.said = ""
        self.trouble = ""  # why the last run with the bridge open ended early
        self.latest = ""  # what came of the latest press, as the beginning of a sentence

    def run(self, stop: Asked, until: Callable[[], bool] = lambda: False) -> None:
        """Watches, and drives what is asked for, until ``stop`` or ``until`` say so."""
        end = _Until(lambda: stop.requested or until())
        while not end.requested:
            press = self.controls.take()
            if press is None:
                self._look(end)
                continue
            try:
                self._obey(press, end)
            finally:
                self.controls.over()

    def _look(self, end: Asked) -> None:
        """One run with the bridge open; after one that the board does not allow, a moment's rest.

        The reason is said once, as long as it stays.
        """
        enough = _Until(lambda: end.requested or self.controls.waiting)
        sure_at = self.board.port.now() + (SURE_S if self.trouble else 0.0)
        try:
            reason = self._run(self._watching(), enough, lambda: self._seen(sure_at))
            if not reason.startswith("fault"):
                return
            self.trouble = tripped(reason, self.board.trip)
        except LinkError:
            raise
        except RigError as error:
            self.trouble = str(error)
        self._say_once(STOPPED, self.trouble)
        self.board.wait(AGAIN_S)
        self._restore()

    def _seen(self, sure_at: float) -> None:
        """Samples come; after a trouble, for long enough that it is over."""
        if self.trouble and self.board.port.now() < sure_at:
            return
        self.trouble = ""
        self._say_once(WATCHING, f"{self.latest}the bridge is open")

    def _restore(self) -> None:
        """Ready for the next run: no fault latched, no sign check, which is for drives."""
        self.board.unlatch()
        self.config = configure(self.board, self.rig)

    def _say_once(self, state: str, text: str) -> None:
        if text != self.said:
            self.said = text
            self.say(state, text)

    def _watching(self) -> Program:
        seconds = min(WATCH_S, SHARE * self.rig.limits.run_time_s)
        return Program((Step(StepKind.COAST, seconds),))

    def _obey(self, press: Press, end: Asked) -> None:
        """Drives one program; what comes of it is said, and the bridge is open again."""
        stop = _Until(lambda: end.requested or press.requested)
        try:
            reason = self._drive(press.program, stop)
            if stop.requested:
                said = STOPPED, f"stopped: {press.why or 'the scope ends'}"
            elif reason.startswith("fault"):
                said = REFUSED, tripped(reason, self.board.trip)
            else:
                said = DONE, "the program is over"
        except LinkError:
            raise
        except MotoridError as error:
            said = REFUSED, str(error)
        self.say(*said)
        self.said, self.latest = said[1], f"{said[1]}; "
        self._restore()

    def _drive(self, program: Program, stop: Asked) -> str:
        """As a capture does, without a file; why it ended."""
        board, rig = self.board, self.rig
        refuse_held(program, "the scope")
        check_program(rig, program)
        self.say(DRIVING, "checks, then the program")
        board.make_ready()
        self.config = configure(board, rig)
        check_inputs(board, rig)
        self.zero = self._zeroed()
        supply_v = check_supply(board, rig)
        pulse = check_signs(board, rig, self.config, self.zero, supply_v, stop)
        if stop.requested:
            return "stopped"
        bound = pulse.get("resistance_bound_ohm")
        check_program(rig, program, resistance_ohm=bound, supply_v=supply_v)
        self.config = configure(board, rig, **signs(rig, board.identity, board.descriptors))
        board.check_same()
        return self._run(program, stop)

    def _run(self, program: Program, stop: Asked, seen: Callable[[], None] = lambda: None) -> str:
        """``seen`` is called with each block: it shows that the board does run."""
        wire = self._wire(program)
        load(self.board, wire)
        watched = self.watch(run_facts(self.rig, self.board, self.config, self.zero))

        def consume(block: SampleBlock) -> None:
            watched(block)
            seen()

        return drive(self.board, wire, self.config, stop, consume)

    def _wire(self, program: Program) -> WireProgram:
        identity = self.board.identity
        return wire_program(program, identity, sample_period(self.rig, identity))

    def _zeroed(self) -> Fields:
        rate_hz = self.board.identity["clock_hz"] / self.config["sample_period_ticks"]
        zero = self.board.zero(int(min(max(ZERO_S * rate_hz, 16), 4096)))
        check_zero(zero, self.board.descriptors)
        return zero
