"""The bench's instruments, as a person wrote them down: who drives, who records, what is where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from motorid.acquire.port import INSTRUMENTS
from motorid.acquire.scpi.dialect import Dialect, load_dialect
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Channel
from motorid.capture.table_options import TableOptions, as_stated
from motorid.errors import RigError, UsageError
from motorid.rig_keys import Key, List, Number, Text, read_table, show
from motorid.rig_model import Rig
from motorid.toml_file import read_text, tables_of, unknown

SUPPLY = "supply"
CHANNELS = (CURRENT, VOLTAGE, SPEED, POSITION)
_SECONDS = Number(0.01, 600)
_SUPPLY: Mapping[str, Key] = {
    "resource": Text(),
    "dialect": Text(),
    "channel": Text(),
    "quadrants": Number(1, 4),
    "timeout_s": _SECONDS,
}
_RECORDER: Mapping[str, Key] = {
    "resource": Text(),
    "dialect": Text(),
    "timeout_s": _SECONDS,
    "lead_s": Number(0, 60),
    "clock_uncertainty": Number(0, 0.01),
}
_METER: Mapping[str, Key] = {"resource": Text(), "error": Text(), "timeout_s": _SECONDS}
_CHANNEL: Mapping[str, Key] = {
    "source": Text(),
    "sources": List(Text(), 2),
    "instrument": Text(),
    "query": Text(),
    "field": Number(0, 100),
    "scale": Number(-1e9, 1e9),
    "zero": Number(-1e9, 1e9),
    "sense": Text(("terminals", "bridge")),
    "gain_uncertainty": Number(0, 1),
    "offset_uncertainty": Number(0, 1e4),
    "nonlinearity": Text(),
    "delay": Text(),
    "delay_uncertainty": Text(),
    "filter": Text(),
    "aperture": Text(),
}
_TOP = ("visa", "supply", "recorder", "meters", "channels")


@dataclass(frozen=True)
class Place:
    """Where an instrument is, and how long its answers may take."""

    resource: str
    timeout_s: float
    error: str = "SYST:ERR?"


@dataclass(frozen=True)
class Source:
    """One quantity: an input of the recorder, or a query; and what is stated of its readings.

    Values in SI are ``scale`` (value - ``zero``). ``facts`` are import's, by their names.
    """

    name: str
    sources: tuple[str, ...] = ()  # of the recorder: one, or an encoder's two lines
    instrument: str = SUPPLY
    query: str = ""
    place: int = 0  # of several numbers in one answer
    scale: float = 1.0
    zero: float = 0.0
    sense: str = "bridge"  # of a voltage: the source's own terminals lie before the leads
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def options(self) -> dict[str, Any]:
        """The facts as import's options have them: by fact, then by quantity."""
        return {key: {self.name: value} for key, value in self.facts.items()}


@dataclass(frozen=True)
class BenchFile:
    """All instruments. ``recorder`` None: the others are asked in turn."""

    path: str
    text: str
    visa: str
    supply: Place
    supply_dialect: Dialect
    channel: str
    quadrants: int
    recorder: Place | None
    recorder_dialect: Dialect | None
    lead_s: float
    clock_uncertainty: float
    meters: Mapping[str, Place]
    channels: tuple[Source, ...]


def of_rig(rig: Rig) -> BenchFile:
    """The file that a rig's port names (scpi://FILE), from the rig's folder or from here.

    Raises RigError.
    """
    name = rig.port.removeprefix(INSTRUMENTS)
    if not name:
        raise RigError(
            f"port {INSTRUMENTS}: name the file of the instruments, such as {INSTRUMENTS}smu.toml"
        )
    beside = Path(rig.folder or ".") / name
    path = beside if beside.is_file() else Path(name)
    return parse(read_text(path, "a file of instruments", RigError), path)


def parse(text: str, path: Path) -> BenchFile:
    """The bench that ``text`` (TOML) describes. Raises RigError naming ``path`` and the key."""
    where = str(path)
    document = tables_of(text, where, RigError)
    if problem := unknown(document, _TOP):
        raise RigError(f"{where}: {problem}")
    top = read_table(
        {k: v for k, v in document.items() if k == "visa"}, {"visa": Text()}, "", where
    )
    supply = _section(document, "supply", _SUPPLY, where)
    recorder = _section(document, "recorder", _RECORDER, where) if "recorder" in document else {}
    dialect = load_dialect(supply.get("dialect", "scpi"), path.parent, "supply")
    meters = {
        name: _place(_table(table, _METER, f"meters.{name}", where))
        for name, table in _named(document, "meters", where).items()
    }
    recording = (
        load_dialect(recorder.get("dialect", ""), path.parent, "recorder") if recorder else None
    )
    channels = _channels(document, bool(recorder), dialect, meters, where)
    if recording is not None and "scan" in recording.tables:
        _check_scan(channels, where)
    return BenchFile(
        path=where,
        text=text,
        visa=_visa(top.get("visa", "@py"), path.parent),
        supply=_place(supply),
        supply_dialect=dialect,
        channel=supply.get("channel", "1"),
        quadrants=int(supply.get("quadrants", 1)),
        recorder=_place(recorder) if recorder else None,
        recorder_dialect=recording,
        lead_s=recorder.get("lead_s", 0.1),
        clock_uncertainty=recorder.get("clock_uncertainty", 5e-5),
        meters=meters,
        channels=channels,
    )


def _check_scan(channels: Sequence[Source], where: str) -> None:
    """Raises RigError on what no scan can read."""
    for one in channels:
        if one.name == POSITION:
            raise RigError(
                f"{where}: channels.{POSITION}: a scan reads an encoder's lines one after the "
                "other, and so counts no edges; a tacho gives the speed"
            )
        if not one.sources[0].isdecimal():
            raise RigError(
                f"{where}: channels.{one.name}.source: a scan's input is the number of a channel, "
                f'such as "101", not {show(one.sources[0])}'
            )


def _visa(backend: str, folder: Path) -> str:
    """A simulation's file is found beside the instruments' file, wherever one stands."""
    file, at, kind = backend.rpartition("@")
    return f"{folder / file}{at}{kind}" if file and kind == "sim" else backend


def _table(table: Any, keys: Mapping[str, Key], section: str, where: str) -> dict[str, Any]:
    found = read_table(table, keys, section, where)
    if not found.get("resource"):
        raise RigError(
            f"{where}: {section}.resource is missing: write the VISA name of the instrument, such "
            'as "TCPIP0::192.168.1.20::5025::SOCKET"'
        )
    return found


def _section(document: Any, name: str, keys: Mapping[str, Key], where: str) -> dict[str, Any]:
    if name not in document:
        raise RigError(f"{where}: [{name}] is missing: name the instrument that drives the motor")
    return _table(document[name], keys, name, where)


def _named(document: Any, section: str, where: str) -> Mapping[str, Any]:
    found = document.get(section, {})
    if not isinstance(found, dict):
        raise RigError(f"{where}: [{section}] must be a table, not {show(found)}")
    return found


def _place(table: Mapping[str, Any]) -> Place:
    return Place(table["resource"], table.get("timeout_s", 5.0), table.get("error", "SYST:ERR?"))


def _channels(
    document: Any, recorded: bool, dialect: Dialect, meters: Mapping[str, Place], where: str
) -> tuple[Source, ...]:
    """What is measured; where nothing is said, what the supply itself reads."""
    named = _named(document, "channels", where)
    if problem := unknown(named, CHANNELS, "channels"):
        raise RigError(f"{where}: {problem}")
    if not named and recorded:
        raise RigError(
            f"{where}: [channels.current] and the like are missing: what is on which input?"
        )
    if not named:
        named = {name: {} for name in (CURRENT, VOLTAGE) if dialect.get("measure", name)}
    found = tuple(
        _channel(
            name, read_table(table, _CHANNEL, f"channels.{name}", where), recorded, dialect, where
        )
        for name, table in named.items()
    )
    for one in found:
        _check(one, recorded, dialect, meters, where)
    if CURRENT not in named or VOLTAGE not in named:
        raise RigError(f"{where}: channels needs {CURRENT} and {VOLTAGE}: a fit rests on both")
    return found


def _channel(
    name: str, table: Mapping[str, Any], recorded: bool, dialect: Dialect, where: str
) -> Source:
    facts = (
        *("gain_uncertainty", "offset_uncertainty", "nonlinearity"),
        *("delay", "delay_uncertainty", "filter"),
    )
    sources = tuple(table.get("sources", ())) or ((table["source"],) if "source" in table else ())
    if (len(sources) == 2) != (name == POSITION) and (sources or recorded):
        raise RigError(
            f"{where}: channels.{name}: {POSITION} takes sources = [A, B], an encoder's two lines, "
            "and any other quantity takes one source"
        )
    return Source(
        name=name,
        sources=sources,
        instrument=table.get("instrument", SUPPLY),
        query=table.get("query", ""),
        place=int(table.get("field", dialect.get("measure", f"{name}_field") or 0)),
        scale=table.get("scale", 1.0),
        zero=table.get("zero", 0.0),
        sense=table.get("sense", "bridge"),
        facts={key: table[key] for key in (*facts, "aperture") if key in table},
    )


def _check(
    one: Source, recorded: bool, dialect: Dialect, meters: Mapping[str, Place], where: str
) -> None:
    said = f"{where}: channels.{one.name}"
    if recorded != bool(one.sources):
        raise RigError(
            f"{said}: "
            + (
                "name the recorder's input (source)"
                if recorded
                else "source needs a [recorder]; without one, write query"
            )
        )
    try:  # now, and not when the run is over
        as_stated(Channel(one.name, "", np.empty(0)), TableOptions(**one.options))
    except UsageError as error:
        raise RigError(f"{said}: {str(error).replace('--', '')}") from None
    if not one.scale:
        raise RigError(f"{said}.scale is 0: nothing would be measured")
    if recorded:
        return
    if one.name == POSITION:
        raise RigError(f"{said}: only a recorder can count an encoder; a tacho gives the speed")
    if one.instrument != SUPPLY and one.instrument not in meters:
        raise RigError(f"{said}: there is no [meters.{one.instrument}]")
    if not one.query and not (one.instrument == SUPPLY and dialect.get("measure", one.name)):
        raise RigError(f"{said}.query is missing: which query reads it?")
