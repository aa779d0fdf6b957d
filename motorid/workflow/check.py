"""One motor at the end of the line: capture, fit, verdict, and their files, in that order.

The capture is on disk before it is fitted, and the records before anybody sees the verdict, so a
process that is killed at any moment loses nothing: ``resume`` finishes what it finds unfinished.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from motorid import json_text
from motorid.errors import DataError, LinkError, MotoridError, RigError, UsageError
from motorid.workflow import shift_folder

if TYPE_CHECKING:
    from motorid.acquire.port import Port
    from motorid.acquire.record import Progress
    from motorid.acquire.tap import Watch
    from motorid.capture.model import Capture
    from motorid.quality.product import Product
    from motorid.quality.verdict import Verdict
    from motorid.rig import Rig
    from motorid.storage.place import Place

CAPTURE, WARM_UP = "capture.h5", "warm-up.h5"
LONGEST_NAME = 200  # of a station or a person
VERDICT, JUNIT, TABLE, OPENHTF = "verdict.json", "junit.xml", "verdict.csv", "openhtf.json"
JOURNAL = CAPTURE + ".journal"


@dataclass(frozen=True)
class Inspection:
    """What came of one motor. ``exit_code`` is the command's; ``seconds`` of each stage."""

    verdict: Verdict
    folder: Path | None
    exit_code: int
    seconds: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Who:
    """Which station judged, and who worked there; they stand in the records.

    Raises UsageError for names that no record can carry.
    """

    station: str = ""
    operator: str = ""
    retest: str = ""  # why a motor that was judged before is tested again

    def __post_init__(self) -> None:
        for what, name in asdict(self).items():
            if len(name) > LONGEST_NAME or not name.isprintable():
                raise UsageError(f"{what}: write at most {LONGEST_NAME} printable characters")


NOBODY = Who()


class Line:
    """One rig and one product, kept warm: the port stays open from motor to motor.

    ``folder`` gets a folder for each inspection.
    """

    def __init__(self, rig: Rig, product: Product, folder: Path, who: Who = NOBODY) -> None:
        self.rig, self.product, self.folder, self.who = rig, product, folder, who
        self.watch: Watch | None = None  # is given the samples of each run
        self._port: Port | None = None
        folder.mkdir(parents=True, exist_ok=True)

    def __enter__(self) -> Line:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def warm(self) -> None:
        """Loads what the first motor would wait for; opens the link. Raises LinkError.

        The newest capture of the folder, if there is one, is judged once more as a rehearsal.
        """
        import scipy.special  # noqa: F401

        from motorid.acquire import record  # noqa: F401
        from motorid.estimate.fit import joint_fit  # noqa: F401
        from motorid.quality import judge, records  # noqa: F401

        captures = (one / CAPTURE for one in shift_folder.newest_first(self.folder))
        newest = next((one for one in captures if one.exists()), None)
        if newest is not None:
            with contextlib.suppress(MotoridError):  # what is wrong with it was said at its time
                judge_files([newest], self.product)
        self._open()

    def close(self) -> None:
        """Gives the link back; the next inspection opens it again."""
        if self._port is not None:
            self._port.close()
            self._port = None

    def inspect(
        self, serial: str, *, progress: Progress | None = None, retest: str = ""
    ) -> Inspection:
        """Measures and judges the motor in the rig; ``retest``: why it is tested again.

        Raises UsageError, before anything moves, for what is no serial number of this product. A
        rig, link or run that fails gives an INVALID verdict that says so.
        """
        refuse_serial(self.product, serial)
        who = replace(self.who, retest=retest)
        begin = datetime.now(UTC)
        folder = new_folder(self.folder, serial, begin)
        start = time.perf_counter()
        try:
            self._measure(folder, serial, progress)
        except (RigError, LinkError, DataError) as error:
            self.close()
            return self._not_run(folder, serial, begin, error, time.perf_counter() - start, who)
        seconds = time.perf_counter() - start
        return finish(folder, self.product, serial, begin, seconds, who)

    def _measure(self, folder: Path, serial: str, progress: Progress | None) -> None:
        from motorid.acquire.record import capture_over

        port = self._open()
        warm_up = self.product.warm_up
        if warm_up is not None:
            capture_over(
                port,
                self.rig,
                warm_up,
                folder / WARM_UP,
                serial=serial,
                note=f"warm-up, product {self.product.name}",
            )
        capture_over(
            port,
            self.rig,
            self.product.program,
            folder / CAPTURE,
            serial=serial,
            note=f"product {self.product.name}",
            progress=progress,
            checked=warm_up is not None,
            watch=self.watch,
        )

    def _open(self) -> Port:
        from motorid.acquire.port import open_port

        if self._port is None:
            self._port = open_port(self.rig.port)
        return self._port

    def _not_run(
        self,
        folder: Path,
        serial: str,
        begin: datetime,
        error: MotoridError,
        seconds: float,
        who: Who,
    ) -> Inspection:
        from motorid.quality.verdict import Outcome
        from motorid.workflow.not_running import verdict_of

        verdict = verdict_of(error, self.product, serial, self.folder)
        write_records(verdict, folder, begin, who)
        failed = verdict.outcome is not Outcome.INVALID
        code = verdict.exit_code if failed else error.exit_code
        return Inspection(verdict, folder, code, {"capture": seconds})


def finish(
    folder: Path,
    product: Product,
    serial: str,
    begin: datetime,
    capture_s: float = 0.0,
    who: Who = NOBODY,
) -> Inspection:
    """Fit, verdict and records of the capture in ``folder``."""
    start = time.perf_counter()
    verdict, fit_s = judge_files([folder / CAPTURE], product, serial)
    judged = time.perf_counter()
    write_records(verdict, folder, begin, who)
    seconds = {
        "capture": capture_s,
        "fit": fit_s,
        "verdict": judged - start - fit_s,
        "records": time.perf_counter() - judged,
    }
    return Inspection(verdict, folder, verdict.exit_code, seconds)


def judge_files(
    paths: Sequence[Place], product: Product, serial: str = "", *, rig: Rig | None = None
) -> tuple[Verdict, float]:
    """The verdict on stored captures of one motor, and the seconds that loading and fit took.

    ``rig``: re-analyse them under this one, with its calibration, in place of their own.
    Captures that cannot be fitted give INVALID; a file that is none raises DataError.
    """
    from motorid.storage.captures import load

    start = time.perf_counter()
    captures = [load(path) for path in paths]
    loaded_s = time.perf_counter() - start
    verdict, fit_s = judge_captures(captures, product, serial, rig=rig)
    return verdict, loaded_s + fit_s


def judge_captures(
    captures: Sequence[Capture], product: Product, serial: str = "", *, rig: Rig | None = None
) -> tuple[Verdict, float]:
    """As ``judge_files``, for captures that are loaded already."""
    from motorid.estimate.results.estimate import SIX
    from motorid.quality.judge import judge, not_measured
    from motorid.workflow.fit import fit_captures

    start = time.perf_counter()
    stored = next((str(s) for c in captures if (s := c.provenance.get("serial"))), "")
    if serial and stored and serial != stored:
        raise UsageError(
            f"{captures[0].path} is of motor {stored}, not of {serial}: name the right one"
        )
    try:
        estimate = fit_captures(captures, rig=rig, model=SIX)  # limits are on these
    except DataError as error:
        verdict = not_measured(product, serial or stored, str(error))
        return verdict, time.perf_counter() - start
    fit_s = time.perf_counter() - start
    return judge(estimate, product, serial=serial or stored), fit_s


def judge_stored(
    paths: Sequence[Place],
    product: Product,
    serial: str,
    output: Path | None,
    *,
    rig: Rig | None = None,
) -> Inspection:
    """The verdict on stored captures; its records go into a folder under ``output``, if given."""
    verdict, fit_s = judge_files(paths, product, serial, rig=rig)
    folder = None
    if output is not None:
        begin = datetime.now(UTC)
        folder = new_folder(output, verdict.serial or paths[0].stem, begin)
        write_records(verdict, folder, begin)
    return Inspection(verdict, folder, verdict.exit_code, {"fit": fit_s})


def refuse_serial(product: Product, serial: str) -> None:
    """Raises UsageError for what the product's rule does not take, or what no file can carry."""
    from motorid.quality.product import LONGEST_SERIAL

    problem = product.serial.problem(serial) if product.serial else ""
    if not problem and not (serial and serial.isprintable() and len(serial) <= LONGEST_SERIAL):
        problem = f"a serial number is 1 to {LONGEST_SERIAL} printable characters"
    if problem:
        raise UsageError(problem)


def new_folder(parent: Path, serial: str, begin: datetime) -> Path:
    """A folder of its own for this inspection: serial number and time, and a count if need be."""
    stem = shift_folder.name_of(serial, begin)
    for count in range(1000):
        folder = parent / (stem if count == 0 else f"{stem}-{count}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        return folder
    raise DataError(f"{parent} holds a thousand inspections of {serial} in one second")


def write_records(verdict: Verdict, folder: Path, begin: datetime, who: Who = NOBODY) -> None:
    """The verdict's four files, each whole; verdict.json comes last and says all are there."""
    from motorid.capture.whole import write_whole
    from motorid.quality import records

    folder.mkdir(parents=True, exist_ok=True)
    name = who.station or "motorid"  # OpenHTF wants one
    station = records.to_openhtf(verdict, station=name, operator=who.operator, begin=begin)
    pages = {
        JUNIT: records.to_junit(verdict, time=begin),
        TABLE: records.to_csv([verdict], time=begin),
        OPENHTF: json_text.dumps(station, indent=2) + "\n",
        VERDICT: records.to_json(verdict, time=begin, who=asdict(who)),
    }
    for name, text in pages.items():
        write_whole(folder / name, text.encode(), force=True)


def unfinished(folder: Path) -> Iterator[Path]:
    """Inspections under ``folder`` that were cut short: measured, at least in part, not judged."""
    for one in shift_folder.unsettled(folder, "judged", lambda one: (one / VERDICT).exists()):
        if (one / CAPTURE).exists() or (one / JOURNAL).exists():
            yield one


def resume(folder: Path, product: Product, who: Who = NOBODY) -> list[Inspection]:
    """Judges every inspection under ``folder`` that a killed process left unfinished.

    Its operator is not known any more.
    """
    from motorid.acquire.record import recover
    from motorid.quality.judge import not_measured

    done, there = [], Who(who.station)
    for one in unfinished(folder):
        begin = datetime.fromtimestamp(one.stat().st_mtime, UTC)
        try:
            if not (one / CAPTURE).exists():
                recover(one / CAPTURE)
            done.append(finish(one, product, "", begin, who=there))
        except UsageError:
            continue  # its journal still grows: another process measures it
        except DataError as error:
            verdict = not_measured(
                product, shift_folder.serial_of(one), f"the run was cut short ({error})"
            )
            write_records(verdict, one, begin, there)
            done.append(Inspection(verdict, one, verdict.exit_code))
    return done
