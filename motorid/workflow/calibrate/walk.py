"""From a rig file to the calibration beside it: step after step, then one file, whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.calibration.toml import render
from motorid.capture.model import CURRENT, VOLTAGE
from motorid.capture.whole import check_writable, write_whole
from motorid.errors import MotoridError, RigError, UsageError, nearest
from motorid.rig_calibration import (
    APPLIED,
    FORMAT,
    parse_calibration,
    path_beside,
    read_calibration,
)
from motorid.rig_model import CalibrationFile
from motorid.workflow.calibrate.bench import Bench, Settings, Tables, now
from motorid.workflow.calibrate.person import Person
from motorid.workflow.calibrate.steps import STEPS

if TYPE_CHECKING:
    from motorid.acquire.record import Progress
    from motorid.rig import Rig


class NothingDoneError(UsageError):
    """Every step was left out by the person."""


@dataclass(frozen=True)
class Written:
    """Where a calibration went, and where the one before it was kept (None: there was none)."""

    path: Path
    archived: Path | None
    steps: tuple[str, ...]


def open_rig(
    name_or_path: str, *, port: str | None = None, speed: str | None = None
) -> tuple[Path, Rig]:
    """A rig file of one's own as it stands, without its calibration.

    Raises UsageError for a packaged rig, beside which nothing is written; RigError for a bad one.
    """
    from motorid.rig_file import find, load_plain
    from motorid.workflow.record import adjusted

    path = find(name_or_path)
    if str(path) != name_or_path and path.stem == name_or_path:
        raise UsageError(
            f"{name_or_path} is a packaged rig, beside which no calibration is written: make a "
            f"file of your own with `motorid rigs --show {name_or_path} > bench.toml`"
        )
    return path, adjusted(load_plain(path), port=port, speed=speed)


def calibrate(
    path: Path,
    rig: Rig,
    person: Person,
    *,
    steps: Sequence[str] = (),
    settings: Settings | None = None,
    about: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> Written:
    """Walks ``person`` through ``steps`` (all, if none) and writes the file beside ``path``.

    What an earlier file says of other parts of the same board stays, with its own dates; that file
    is kept under its date. What was done before an interrupt or an error is written all the same.
    Raises NothingDoneError where no step was done.
    """
    wanted = _wanted(steps)
    target = path.parent / rig.calibration_file if rig.calibration_file else path_beside(path)
    _refuse_doubles(rig, wanted)
    check_writable(target, force=True)
    before = read_calibration(target) if target.is_file() else None
    earlier = {n: dict(t) for n, t in before.tables.items() if n} if before else {}
    bench = Bench(rig, person, settings or Settings(), progress, earlier, {})
    done: list[str] = []
    written = None
    try:
        for name in wanted:
            if _step(bench, name):
                done.append(name)
    finally:
        if done:
            written = _write(target, bench, before, path.stem, dict(about or {}), tuple(done))
    if written is None:
        raise NothingDoneError("no step was done, so nothing is written")
    return written


def _wanted(steps: Sequence[str]) -> list[str]:
    for name in steps:
        if name not in STEPS:
            raise UsageError(
                f"{name!r} is no step of a calibration{nearest(name, STEPS)}: {', '.join(STEPS)}"
            )
    return [name for name in STEPS if name in steps] if steps else list(STEPS)


def _refuse_doubles(rig: Rig, steps: Sequence[str]) -> None:
    """The rig file's own gain would be applied on top of the one that is measured."""
    from motorid.rig import Calibration

    names = [*steps, CURRENT, VOLTAGE] if "rest" in steps else steps
    for name in names:
        own = rig.calibration.get(name)
        fields = [
            f for f in APPLIED.values() if own and getattr(own, f) != getattr(Calibration(), f)
        ]
        if fields:
            raise RigError(
                f"calibration.{name}.{fields[0]} stands in the rig file: take it out, as the "
                "calibration will say it"
            )


def _step(bench: Bench, name: str) -> bool:
    """One step, as often as the person wants; whether it was done."""
    work, setup = STEPS[name]
    while True:
        if not bench.person.ready(name, setup):
            return False
        before = bench.board
        try:
            tables = work(bench)
        except MotoridError as error:
            if not bench.person.again(name, str(error)):
                raise
            continue
        _start_anew(bench, before)
        for table, values in tables.items():
            bench.found[table] = bench.found.get(table, {}) | values
        if not bench.person.again(name, ""):
            return True


def _start_anew(bench: Bench, before: Mapping[str, str]) -> None:
    """What an earlier file says of another board does not hold for this one."""
    known = bench.found.get("board")
    if not before and known and bench.board and known.get("serial") != bench.board["serial"]:
        bench.person.say(
            f"the earlier calibration was of board {known.get('serial') or known.get('name')}: "
            "none of it is taken over"
        )
        bench.found.clear()
    if bench.board:
        bench.found["board"] = dict(bench.board)


def _write(
    target: Path,
    bench: Bench,
    before: CalibrationFile | None,
    rig_name: str,
    about: dict[str, Any],
    done: tuple[str, ...],
) -> Written:
    ambient = {
        "c": about.pop("ambient_c", bench.rig.ambient_c),
        "uncertainty_c": about.pop("ambient_uncertainty_c", bench.rig.ambient_uncertainty_c),
    }
    top = {"format": FORMAT, "date": now(), "rig": rig_name, **about}
    if before is not None:
        top["replaces_sha256"] = before.sha256
    tables: Tables = {"": top, "board": bench.found.get("board", {})}
    if ambient["c"] is not None:
        tables["ambient"] = ambient
    tables |= {n: t for n, t in bench.found.items() if n not in ("", "board", "ambient")}
    text = render(tables)
    parse_calibration(text, str(target))  # what is written can be read
    archived = _archive(target, before) if before is not None else None
    write_whole(target, text.encode(), force=True)
    return Written(target, archived, done)


def _archive(target: Path, before: CalibrationFile) -> Path:
    """Keeps the earlier file under its date; no file of the history is ever replaced."""
    stem = target.name.removesuffix(".toml")
    for count in range(1000):
        again = f"-{count}" if count else ""
        path = target.with_name(f"{stem}.{before.date:%Y%m%dT%H%M%SZ}{again}.toml")
        if path.exists() and path.read_bytes() == before.text.encode():
            return path
        if not path.exists():
            write_whole(path, before.text.encode())
            return path
    raise RigError(f"{target} has a thousand earlier versions of one second: clear some away")
