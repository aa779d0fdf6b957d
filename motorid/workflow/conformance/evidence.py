"""The guided run on a bench: what it takes, part by part; a part that fails ends no other.

Each part leaves its files in one folder. The folder becomes the bundle, also after Ctrl-C.
"""

from __future__ import annotations

import platform
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from motorid import json_text
from motorid.errors import DataError, MotoridError, RigError, UsageError
from motorid.program import Program, Step, StepKind
from motorid.version import __version__
from motorid.workflow.conformance import suite as conformance_suite
from motorid.workflow.conformance.bundle import pack

if TYPE_CHECKING:
    from motorid.acquire.record import Progress
    from motorid.rig import Rig
    from motorid.workflow.calibrate.bench import Settings
    from motorid.workflow.calibrate.person import Person

DONE, SKIPPED, FAILED = "done", "skipped", "failed"
GUIDED = ("rest", "terminal_voltage", "current", "disc")  # steps of a calibration
RUNS = 3
RESULTS = 2  # lines at the end of a step that say what it found
RIG_FILE = "rig.toml"
REST_S = 0.1  # before the drive of a coast


@dataclass(frozen=True)
class Part:
    """One part of the evidence: its outcome, and a sentence."""

    name: str
    outcome: str
    says: str = ""


@dataclass
class Evidence:
    """What is gathered of one board, and how. ``select``: which cases of the suite (pytest -k)."""

    rig: Rig
    rig_path: Path
    folder: Path
    person: Person
    settings: Settings
    say: Callable[[str], None]
    progress: Progress | None = None
    with_suite: bool = True
    select: str = ""
    serial: str = ""
    about: dict[str, str] = field(default_factory=dict)
    parts: list[Part] = field(default_factory=list)

    def gather(self) -> None:
        """All parts in order: the suite with a free motor, then what a person takes part in."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self._part("board", self._board)
        if self.parts[-1].outcome == FAILED:
            return  # nobody answers: nothing else can be done
        self._part("suite", self._suite)
        self._copy_rig()
        for name in GUIDED:
            self._part(name, partial(self._step, name))
        self._part("runs", self._runs)
        self._part("coast", self._coast)
        self._part("fit", self._fit)

    def bundle(self, target: Path, *, finished: bool, force: bool = False) -> Path:
        """Writes the bundle of what there is."""
        about = {
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
            "motorid": __version__,
            "device": self.rig.port,
            "motor": self.serial,
            **self.about,
            "finished": finished,
            "host": {"python": platform.python_version(), "system": platform.platform(terse=True)},
            "parts": [asdict(part) for part in self.parts],
        }
        (self.folder / "README.txt").write_text(_readme(about), encoding="utf-8")
        return pack(self.folder, target, about, force=force)

    def failed(self) -> list[str]:
        """Names of the parts that failed."""
        return [part.name for part in self.parts if part.outcome == FAILED]

    # ---------------------------------------------------------------- parts

    def _part(self, name: str, work: Callable[[], str]) -> None:
        if name not in GUIDED:  # which name themselves
            self.say(f"== {name.replace('_', ' ')}")
        try:
            part = Part(name, DONE, work())
        except _SkippedError as error:
            part = Part(name, SKIPPED, str(error))
        except MotoridError as error:
            part = Part(name, FAILED, str(error))
        self.parts.append(part)
        self.say(
            f"{name.replace('_', ' ')}: {part.outcome}" + (f"; {part.says}" if part.says else "")
        )

    def _board(self) -> str:
        from motorid.acquire.ports import describe

        found = describe(self.rig.port)
        self._write("board.json", found)
        return "; ".join(found["says"])

    def _suite(self) -> str:
        if not self.with_suite:
            raise _SkippedError("not asked for")
        if why := conformance_suite.why_not():
            raise _SkippedError(why)
        self.person.proceed("the suite, some minutes: the motor must turn freely, both ways")
        found = conformance_suite.run_suite(self.rig.port, self.folder, self.select)
        if found.failed:
            raise RigError(found.sentence())
        return found.sentence()

    def _copy_rig(self) -> None:
        """The rig as the bundle holds it: a calibration is written beside this copy alone."""
        from motorid.rig_calibration import path_beside

        copy = self.folder / RIG_FILE
        copy.write_text(self.rig.text, encoding="utf-8")
        beside = path_beside(self.rig_path)
        if beside.is_file():
            shutil.copyfile(beside, path_beside(copy))

    def _step(self, name: str) -> str:
        from motorid.workflow.calibrate import walk

        copy, heard = self.folder / RIG_FILE, _Heard(self.person)
        try:
            walk.calibrate(
                copy,
                self.rig,
                cast("Person", heard),
                steps=(name,),
                settings=self.settings,
                about=self.about,
                progress=self.progress,
            )
        except walk.NothingDoneError:
            raise _SkippedError("left out by whoever was at the bench") from None
        finally:
            for earlier in self.folder.glob("rig.calibration.*.toml"):
                earlier.unlink()  # each step keeps the one before: the last holds all of them
        return "; ".join(heard.lines[-RESULTS:])

    def _calibrated(self) -> Rig:
        from motorid.rig import load_rig

        return replace(load_rig(str(self.folder / RIG_FILE)), port=self.rig.port)

    def _runs(self) -> str:
        from motorid.workflow.record import capture_runs

        self.person.proceed(
            f"take disc and clamp off, the motor connected and free: {RUNS} runs of the rig's "
            "program; keep clear of it"
        )
        paths = capture_runs(
            self._calibrated(),
            self.folder / "run.h5",
            repeat=RUNS,
            serial=self.serial,
            note="conformance",
            progress=self.progress,
            say=self.say,
        )
        return f"{len(paths)} captures"

    def _coast(self) -> str:
        from motorid.workflow.record import capture_runs

        program = coast_program(self.rig.program)
        if program is None:
            raise _SkippedError("the rig's program has no drive that a coast ends")
        self.person.proceed("one drive and a coast, the motor as before; keep clear of it")
        rig = replace(self._calibrated(), program=program)
        capture_runs(
            rig, self.folder / "coast.h5", serial=self.serial, note="coast", progress=self.progress
        )
        return f"from {max(abs(step.level) for step in program.steps):g}"

    def _fit(self) -> str:
        from motorid.workflow import fit

        paths = sorted(self.folder.glob("run-*.h5"))
        if not paths:
            raise DataError("there is no run to fit")
        estimate = fit.fit_files(paths, fix={})
        fit.write_report(estimate, self.folder, force=True)
        (self.folder / "estimate.txt").write_text(fit.as_text(estimate), encoding="utf-8")
        told = {name: one.status.value for name, one in estimate.parameters.items()}
        return ", ".join(f"{name} {status.replace('_', ' ')}" for name, status in told.items())

    def _write(self, name: str, document: Any) -> None:
        text = json_text.dumps(document, indent=2) + "\n"
        (self.folder / name).write_text(text, encoding="utf-8")


class _Heard:
    """A person, and the lines that were said to them: what a step found are the last ones."""

    def __init__(self, person: Person) -> None:
        self._person, self.lines = person, list[str]()

    def say(self, text: str) -> None:
        self.lines.append(text.strip())
        self._person.say(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._person, name)


class _SkippedError(UsageError):
    """A part that was left out; its text says why."""


def coast_program(program: Program) -> Program | None:
    """Rest, the program's largest drive, and its longest coast; None where it has not both."""
    drives = [s for s in program.steps if s.kind in (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)]
    coasts = [s for s in program.steps[1:] if s.kind is StepKind.COAST]
    if not drives or not coasts:
        return None
    fastest = max(drives, key=lambda step: abs(step.level))
    longest = max(coasts, key=lambda step: step.duration_s)
    return Program((Step(StepKind.COAST, REST_S), fastest, longest))


def _readme(about: dict[str, Any]) -> str:
    lines = [
        "Evidence of one board on real or simulated hardware, gathered by `motorid conformance`.",
        "`motorid verify` of this zip says whether every file is still what was written.",
        "manifest.json lists the files; report.html shows the motor's fit; suite.txt the suite.",
        "",
        *(f"{key}: {about[key]}" for key in ("created", "motorid", "device", "motor", "by", "note")
          if about.get(key)),
        "" if about["finished"] else "Interrupted: what follows is all there is.",
        *(f"{one['name']:<18}{one['outcome']:<9}{one['says']}" for one in about["parts"]),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"
