"""A shift at the end of the line: orders from scanner and controller, one motor after another.

The board is driven by one thread, the one that calls ``run``; others only bring orders.
"""

from __future__ import annotations

import contextlib
import queue
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, MotoridError
from motorid.report.screen import Screen, of_verdict
from motorid.workflow import station_words
from motorid.workflow.access import Caller, refuse_order
from motorid.workflow.behind import Behind
from motorid.workflow.check import Inspection, Line, Who, refuse_serial, resume
from motorid.workflow.history_worker import HistoryWorker
from motorid.workflow.kept_orders import KeptOrders
from motorid.workflow.second_tests import Judged, newest_first, refuse_repeat, together
from motorid.workflow.station_words import OUTCOMES, summary, with_line
from motorid.workflow.trail import OrderTrail
from motorid.workflow.uploads import Uploads, UploadWorker
from motorid.workflow.witness import Witness

if TYPE_CHECKING:
    from motorid.workflow.orders import Answer, Message
    from motorid.workflow.shift_history import ShiftHistory

MOST_WAITING = 100  # orders, the one that is measured among them
POLL_S = 0.2  # so that Ctrl-C is heard where a wait on a queue does not hear it
ASKING = ("reason", "release")  # rules of a product by which a second test may need a reason
NOBODY = Caller()
Show = Callable[[Screen], None]


@dataclass(frozen=True)
class Order:
    """A motor to inspect, and where its verdict goes."""

    serial: str
    answer: Callable[[dict[str, Any]], None]
    tag: Any = None
    retest: str = ""  # why it is tested again
    before: int = 0  # verdicts on it, here and in the history


@dataclass(frozen=True)
class Refusal:
    """Why a scan was not taken: said below what is shown, which stays."""

    why: str


class Station:
    """``show`` draws the operator's screen; it is called from the thread of ``run`` only.

    ``depth`` orders are in work at most, the one that is measured among them. One, the default,
    makes each order the confirmation that the next motor is in.
    """

    def __init__(
        self,
        line: Line,
        show: Show,
        history: ShiftHistory | None = None,
        depth: int = 1,
        witnesses: Sequence[Witness] = (),
        uploads: Uploads | None = None,
    ) -> None:
        self.line, self.depth, self._draw = line, depth, show
        self.history = HistoryWorker(history, line.folder, self.note) if history else None
        self.uploads = UploadWorker(uploads, line.folder, self.note) if uploads else None
        self._behind: list[Behind] = [one for one in (self.history, self.uploads) if one]
        self.witnesses = witnesses
        self.counts: Counter[str] = Counter()
        self.first: Counter[str] = Counter()  # of motors that were never judged before
        self.ignored = 0  # scans that came while a motor was in work
        self._in_work: list[str] = []
        self._lock = threading.Lock()
        self.measuring = ""
        self._settled, self._finished = False, 0  # of an earlier shift: judged, and how many
        self._orders: queue.Queue[Order | Refusal | str | None] = queue.Queue()
        self.kept = KeptOrders(line.folder)
        self.trail = OrderTrail(line.folder, line.who.station)
        self._shown = station_words.ready(line.product)

    # ---- any thread

    def scan(self, lines: Iterable[str], *, ends: bool) -> None:
        """Takes serial numbers from a scanner or a keyboard until it ends, and then the station."""
        for line in lines:
            if serial := line.strip():
                self.scanned(serial)
        if ends:
            self.end()

    def scanned(self, typed: str, caller: Caller | None = None) -> None:
        """One serial number from the operator; behind a space, why the motor is tested again."""
        serial, retest = self._parts(typed)
        caller = caller or Caller(self.line.who.operator)
        who = caller.who
        try:
            with self._noting(serial, who):
                refuse_order(caller, "inspect")
                refuse_serial(self.line.product, serial)
                if self._enter(serial):
                    self.ignored += 1  # a scanner that bounced, or a hand before the verdict
                    return
                before = self._keep(serial, retest, who)
        except MotoridError as error:
            self._orders.put(Refusal(str(error)))
            return
        self._orders.put(Order(serial, lambda message: None, retest=retest, before=before))

    def _parts(self, typed: str) -> tuple[str, str]:
        """Serial number and reason; all of it is the number where the product asks for none."""
        rule = self.line.product.serial
        if rule is None or rule.repeat not in ASKING or not rule.problem(typed):
            return typed, ""
        serial, _, retest = typed.partition(" ")
        return serial, retest.strip()

    @contextlib.contextmanager
    def _noting(self, serial: str, who: str) -> Iterator[None]:
        """Keeps a refusal in the trail, where the disk takes it, and lets it through."""
        try:
            yield
        except MotoridError as error:
            with contextlib.suppress(DataError):
                self.trail.refused(serial, who, str(error))
            raise

    def take(self, order: Message, answer: Answer, caller: Caller = NOBODY) -> None:
        """One order from a line controller; see docs/line-controller.md."""
        tag = {"id": order["id"]} if "id" in order else {}
        serial, retest = str(order.get("serial", "")), str(order.get("reason", ""))
        try:
            name = order["order"]
            with self._noting(serial, caller.who):
                refuse_order(caller, name)
                if name == "inspect":
                    self._accept(serial, retest, answer, tag, caller.who)
                    return
            answer({**self._told(name, serial, caller), **tag})
        except MotoridError as error:
            answer({"event": "error", **tag, "message": str(error)})

    def _told(self, name: str, serial: str, caller: Caller) -> dict[str, Any]:
        """The answer to an order that moves nothing. Raises MotoridError."""
        match name:
            case "status":
                return {"event": "status", **self.status()}
            case "last":
                return {"event": "verdict", **self.last(serial)}
            case "history":
                if self.history is None:
                    raise DataError("this station has no history: it was begun without --history")
                return {"event": "history", "serial": serial, **self.history.shift.story(serial)}
        self.trail.accepted("", caller.who, "the end of the shift")
        self.end()
        return {"event": "ends"}

    def _accept(
        self, serial: str, retest: str, answer: Answer, tag: dict[str, Any], who: str
    ) -> None:
        refuse_serial(self.line.product, serial)
        if problem := self._enter(serial):
            raise DataError(problem)
        before = self._keep(serial, retest, who)
        waiting = self._orders.qsize()
        answer({"event": "accepted", **tag, "serial": serial, "waiting": waiting})
        self._orders.put(Order(serial, answer, tag, retest, before))

    def _keep(self, serial: str, retest: str, who: str) -> int:
        """The order on disk, before anybody is told that it is accepted; how often it was tested.

        The motor is in work already: so a verdict that just came counts as one before. Raises
        DataError or UsageError, and then the motor is in work no more.
        """
        try:
            Who(retest=retest)  # raises for what no record can carry
            before = self._before(serial)
            refuse_repeat(self.line.product, serial, retest, before)
            self.trail.accepted(serial, who, retest)
            self.kept.accepted(serial)
        except Exception:
            self._leave(serial)
            raise
        return len(before)

    def _enter(self, serial: str) -> str:
        """Takes a motor into work; else why not, and what to do."""
        with self._lock:
            if serial in self._in_work:
                return f"{serial} is in work already: its verdict comes"
            if len(self._in_work) >= self.depth:
                return (
                    f"{', '.join(self._in_work[:3])} is in work: order the next motor after its "
                    "verdict, when it is in the rig"
                )
            self._in_work.append(serial)
            return ""

    def _before(self, serial: str) -> list[Judged]:
        """What was judged of a motor, the newest first: here, and by all whose history this is."""
        elsewhere: list[Judged] | None = []
        if self.history is not None:
            elsewhere = self.history.judged(serial)
            if elsewhere is None:
                self.note(f"The history does not answer: who else tested {serial} is unknown.")
        return together(newest_first(self.line.folder, serial), elsewhere or [])

    def status(self) -> dict[str, Any]:
        """What the station does and has done since it began."""
        return {
            "state": "measuring" if self.measuring else "ready",
            "serial": self.measuring,
            "waiting": self._orders.qsize(),
            "not_judged": self._not_judged(),
            "product": self.line.product.name,
            "product_sha256": self.line.product.digest,
            "rig": self.line.rig.name,
            "counts": {name: self.counts[name] for name in OUTCOMES},
            "first_tests": {name: self.first[name] for name in OUTCOMES},
            **self._of_behind(),
            **{name: part for one in self.witnesses for name, part in one.status().items()},
        }

    def _not_judged(self) -> list[str]:
        """Ordered before this shift began, without a verdict since."""
        return [one for one in self.kept.waiting() if one not in self._in_work]

    def _of_behind(self) -> dict[str, Any]:
        named = {"history": self.history, "store": self.uploads}
        return {
            name: {"waiting": one.waiting(), "trouble": one.trouble}
            for name, one in named.items()
            if one is not None
        }

    def last(self, serial: str) -> dict[str, Any]:
        """The newest verdict on a motor, from disk. Raises DataError where there is none."""
        refuse_serial(self.line.product, serial)
        newest = next(newest_first(self.line.folder, serial), None)
        if newest is None:
            raise DataError(f"{self.line.folder} holds no verdict on {serial}")
        return newest

    def end(self) -> None:
        """Ends ``run`` once what waits is done."""
        self._orders.put(None)

    def note(self, said: str) -> None:
        """A sentence for the operator, below what is shown when nothing is measured."""
        self._orders.put(said)

    # ---- the thread of the board

    def settle(self) -> None:
        """Judges what an earlier shift left unfinished, once; best before the first order comes.

        Else a motor whose verdict is still to be made would count as one that was never judged.
        """
        if self._settled:
            return
        for one in resume(self.line.folder, self.line.product, self.line.who):
            self._finished += 1
            self.kept.done(one.verdict.serial)
            self._witness(one)
        self._settled = True

    def run(self) -> None:
        """Inspects until ``end``. First it finishes what an earlier shift left unfinished."""
        self.settle()
        self.line.warm()
        left = station_words.left_over(self._finished, self._not_judged())
        self.show(station_words.ready(self.line.product, left))
        for worker in self._behind:
            worker.start()
        try:
            self._serve()
        finally:
            for worker in self._behind:
                if left := worker.close():
                    self._add_line(left)

    def _serve(self) -> None:
        while True:
            try:
                job = self._orders.get(timeout=POLL_S)
            except queue.Empty:
                continue
            match job:
                case None:
                    return
                case Refusal():  # the next one takes its place
                    self._draw(with_line(self._shown, job.why))
                case str():
                    self._add_line(job)
                case Order():
                    self._inspect(job)

    def _inspect(self, order: Order) -> None:
        self.measuring = order.serial
        serial = order.serial
        self.show(station_words.running(serial))
        tag = {**(order.tag or {}), "ends": True}
        try:
            done = self.line.inspect(order.serial, retest=order.retest)
        except MotoridError as error:  # the disk: nothing can be kept, so nothing is said of it
            self._leave(order.serial)
            order.answer({"event": "error", **tag, "message": str(error)})
            self.show(station_words.not_kept(serial, error))
            return
        finally:
            self.measuring = ""
        self._leave(order.serial)
        with contextlib.suppress(DataError):  # its verdict is on disk: a later shift sees that
            self.kept.done(order.serial)
        outcome = str(done.verdict.outcome)
        self.counts[outcome] += 1
        if not order.before:
            self.first[outcome] += 1
        order.answer({"event": "verdict", **tag, **summary(done), "test": order.before + 1})
        self._witness(done)
        for one in self._behind:
            one.take(done.folder)
        tally = station_words.tally(self.counts, self.ignored, self._behind, done)
        self.show(of_verdict(done.verdict, tally))

    def show(self, screen: Screen) -> None:
        """Draws a screen, and keeps it for what is to be added."""
        self._shown = screen
        self._draw(screen)
        for witness in self.witnesses:
            witness.shown(screen)

    def _witness(self, done: Inspection) -> None:
        for witness in self.witnesses:
            witness.judged(done)

    def _add_line(self, said: str) -> None:
        self.show(with_line(self._shown, said))

    def _leave(self, serial: str) -> None:
        with self._lock:
            if serial in self._in_work:
                self._in_work.remove(serial)


def reader(station: Station, lines: Iterable[str], *, ends: bool) -> threading.Thread:
    """A thread that brings the scanner's lines to the station."""
    thread = threading.Thread(
        target=station.scan, args=(lines,), kwargs={"ends": ends}, name="scanner", daemon=True
    )
    thread.start()
    return thread
