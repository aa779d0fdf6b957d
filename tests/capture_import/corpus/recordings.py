"""Logs of signals: by other libraries, and WPILib's in the layout of its specification."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from asammdf import MDF, Signal
from mcap.writer import Writer
from mcap_ros2.writer import Writer as RosWriter
from nptdms import ChannelObject, TdmsWriter

from tests.capture_import.corpus.bench_log import PERIOD_S, RPM, columns, log

Maker = Callable[[Path], None]
STAMPS = [round(1e9 * t) for t in log()["time"]]  # ns


def tdms(path: Path) -> None:
    """Waveforms as LabVIEW's DAQmx writes them: units and increments in the properties."""
    signals = {"Voltage": ("voltage", "V"), "Current": ("current", "A")}
    with TdmsWriter(path) as file:
        file.write_segment(
            [
                ChannelObject(
                    "Motor", name, log()[q],
                    {"unit_string": unit, "wf_increment": PERIOD_S, "wf_start_offset": 0.0},
                )
                for name, (q, unit) in signals.items()
            ]
        )  # fmt: skip


def mdf(path: Path) -> None:
    signals = {"MotorVoltage": ("voltage", 1.0, "V"), "MotorCurrent": ("current", 1e3, "mA"),
               "MotorSpeed": ("speed", RPM, "rpm")}  # fmt: skip
    with MDF(version="4.10") as file:
        file.append(
            [
                Signal(log()[q] * scale, log()["time"], unit=unit, name=name)
                for name, (q, scale, unit) in signals.items()
            ]
        )
        file.save(path, overwrite=True)


def mcap_json(path: Path) -> None:
    rows = columns(voltage=1.0, current=1.0, speed=1.0)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("motor", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/motor", "json", schema)
        for stamp, (volts, amperes, speed) in zip(STAMPS, rows, strict=True):
            record = {"voltage_V": volts, "current_A": amperes, "omega_rad_s": speed}
            writer.add_message(channel, stamp, json.dumps(record).encode(), stamp)
        writer.finish()


def ros_2(path: Path) -> None:
    """A message of ROS 2 with lists; its units are nowhere in the file."""
    text = "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64 voltage\nfloat64 current"
    with path.open("wb") as file:
        writer = RosWriter(file)
        schema = writer.register_msgdef("bench_msgs/msg/Motor", text)
        rows = columns(position=1.0, speed=1.0, voltage=1.0, current=1.0)
        for stamp, (angle, speed, volts, amperes) in zip(STAMPS, rows, strict=True):
            writer.write_message(
                "/motor", schema, log_time=stamp, publish_time=stamp,
                message={"name": ["a"], "position": [angle], "velocity": [speed],
                         "voltage": volts, "current": amperes},
            )  # fmt: skip
        writer.finish()


def wpilog(path: Path) -> None:
    names = {"/shooter/voltage_V": "voltage", "/shooter/current_A": "current",
             "/shooter/velocity_rad_s": "speed"}  # fmt: skip
    path.write_bytes(wpilog_of({name: log()[q] for name, q in names.items()}))


def wpilog_of(
    table: dict[str, np.ndarray], *, first: int = 1, late_us: int = 0, last: bool = True
) -> bytes:
    """Doubles by name, with the log's stamps; beside them a text. ``last``: an entry is ended."""
    found = [struct.pack("<6sHI", b"WPILOG", 0x0100, 4), b"test"]

    def record(entry: int, stamp: int, data: bytes) -> None:
        found.append(struct.pack("<BBBI", 0x30, entry, len(data), stamp) + data)

    text = first + len(table)
    for number, (name, kind) in enumerate(
        [*((name, "double") for name in table), ("mode", "string")], first
    ):
        texts = b"".join(struct.pack("<I", len(t)) + t.encode() for t in (name, kind, ""))
        record(0, 0, struct.pack("<BI", 0, number) + texts)
    record(text, 10, b"auto")
    for row in range(max(map(len, table.values()))):
        for number, values in enumerate(table.values(), first):
            record(number, STAMPS[row] // 1000 + late_us, struct.pack("<d", values[row]))
    if last:
        record(0, 10**7, struct.pack("<BI", 1, first))
    return b"".join(found)
