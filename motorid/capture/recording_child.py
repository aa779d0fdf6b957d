"""Run as a program: a log of signals with stamps -> columns of numbers. See capture/child.py.

Each signal keeps its own stamps: ``NAME.time`` in seconds beside ``NAME.value`` or its members.
Nothing is resampled or held.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motorid.capture import wpilog
from motorid.capture.child import serve
from motorid.errors import DataError
from motorid.limits import RECORDING, beyond

DEEPEST = 6


class Signal(NamedTuple):
    """``values`` None: no numbers."""

    name: str
    values: Any
    unit: str = ""


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``. Raises what the libraries raise."""
    with open(source, "rb") as file:
        head = file.read(8)
    kind = next(kind for begins, kind in KINDS.items() if head.startswith(begins))
    found: dict[str, Any] = {}
    units, others, numbers = [], [], 0
    for signal in kind(source):
        array = None if signal.values is None else np.asarray(signal.values)
        if array is None or array.dtype.kind not in "iufb" or array.ndim != 1 or not array.size:
            others.append(signal.name)
            continue
        numbers += array.size
        refuse(len(found) + 1, array.size, numbers)
        name = signal.name
        while name in found:
            name += "_"
        found[name] = array.astype(np.float64)
        units.append(signal.unit)
    named = {f"a{index}": array for index, array in enumerate(found.values())}
    objects = np.array([(name, "no numbers") for name in others], dtype=str).reshape(-1, 2)
    np.savez(
        target, names=np.array(list(found), dtype=str), units=np.array(units, dtype=str),
        objects=objects, **named,
    )  # fmt: skip


def refuse(columns: int, rows: int, numbers: int) -> None:
    """Raises DataError beyond the limits."""
    most = RECORDING
    counts = (columns, most.columns), (rows, most.rows), (numbers, most.numbers)
    if any(beyond(count, limit) for count, limit in counts):
        raise DataError(
            f"it holds more than {most.columns:,} signals, {most.rows:,} readings of one or "
            f"{most.numbers:,} in all, the most that it may: save a part of it"
        )


def _wpilog(source: str) -> Iterator[Signal]:
    found, others = wpilog.entries(Path(source).read_bytes(), RECORDING.numbers)
    for entry in found:
        yield Signal(f"{entry.name}.time", np.array(entry.stamps), "s")
        yield Signal(f"{entry.name}.value", np.array(entry.values))
    yield from (Signal(name, None) for name in others)


def _tdms(source: str) -> Iterator[Signal]:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise DataError("TDMS needs the package npTDMS: pip install 'motorid[tdms]'") from None
    for group in TdmsFile.read(source).groups():
        for channel in group.channels():
            name = f"{group.name}.{channel.name}"
            unit = channel.properties.get("unit_string") or channel.properties.get(
                "NI_UnitDescription", ""
            )
            values = channel[:]
            if values.dtype.kind == "M":  # moments, in seconds since the first
                values, unit = (values - values[:1]) / np.timedelta64(1, "s"), "s"
            yield Signal(name, values, str(unit))
            if channel.properties.get("wf_increment"):
                yield Signal(f"{name}.time", channel.time_track(), "s")


def _mdf(source: str) -> Iterator[Signal]:
    try:
        from asammdf import MDF
    except ImportError:
        raise DataError("MDF needs the package asammdf: pip install 'motorid[mdf]'") from None
    with MDF(source) as file:
        groups: Any = file.groups
        for number, group in enumerate(groups):
            stamped = False
            for index in range(len(group.channels)):
                if index == file.masters_db.get(number):
                    continue
                signal = file.get(group=number, index=index)
                if not stamped:
                    yield Signal(f"group{number + 1}.time", signal.timestamps, "s")
                stamped = True
                yield Signal(f"group{number + 1}.{signal.name}", signal.samples, signal.unit or "")


def _mcap(source: str) -> Iterator[Signal]:
    try:
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        raise DataError(
            "MCAP needs the packages mcap and mcap-ros2-support: pip install 'motorid[mcap]'"
        ) from None
    columns: dict[str, list[float]] = defaultdict(list)
    others: dict[str, None] = {}
    numbers, first = 0, None
    ros = DecoderFactory()
    with open(source, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            first = message.log_time if first is None else first
            record = _decoded(ros, schema, channel.message_encoding, message.data)
            members = dict(_members(record, channel.topic, 0))
            if not members:
                others[channel.topic] = None
                continue
            columns[f"{channel.topic}.time"].append((message.log_time - first) * 1e-9)
            for name, value in members.items():
                columns[name].append(value)
            numbers += 1 + len(members)
            refuse(len(columns), 1, numbers)
    for name, values in columns.items():
        yield Signal(name, values, "s" if name.endswith(".time") else "")
    yield from (Signal(f"{name} (no JSON or ROS 2 message)", None) for name in others)


def _decoded(ros: Any, schema: Any, encoding: str, data: bytes) -> Any:
    """A message as an object with members; None where its encoding is another."""
    if encoding == "json":
        from motorid import json_text

        try:
            return json_text.loads(data.decode("utf-8", "replace"))
        except json_text.JsonError:
            raise DataError("a message is no JSON: is it damaged?") from None
    decode = ros.decoder_for(encoding, schema)
    return decode(data) if decode is not None else None


def _members(value: Any, name: str, depth: int) -> Iterator[tuple[str, float]]:
    """Numbers of a message by dotted names; elements of lists from 1."""
    if isinstance(value, bool | int | float | np.number):
        yield name, float(value)
    elif isinstance(value, list | tuple | np.ndarray) and depth < DEEPEST:
        for index, one in enumerate(value):
            yield from _members(one, f"{name}[{index + 1}]", depth + 1)
    elif depth < DEEPEST and not isinstance(value, str | bytes | None):
        slots = value if isinstance(value, dict) else {
            slot: getattr(value, slot) for slot in getattr(value, "__slots__", ())
        }  # fmt: skip
        for key, one in slots.items():
            yield from _members(one, f"{name}.{key}", depth + 1)


KINDS = {
    wpilog.MAGIC: _wpilog,
    b"TDSm": _tdms,
    b"MDF     ": _mdf,
    b"\x89MCAP0\r\n": _mcap,
}


if __name__ == "__main__":
    serve(main, ("numpy",))
