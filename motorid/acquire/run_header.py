"""What a journal says of the run that follows: all that its bytes do not."""

from __future__ import annotations

import platform
import random
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from motorid.acquire import clock_check
from motorid.acquire.ports import serial_of
from motorid.program import Program
from motorid.rig import Rig
from motorid.rig_calibration import citation
from motorid.version import __version__


def run_header(rig: Rig, program: Program, serial: str, note: str) -> dict[str, Any]:
    """A header that ``header.check_kinds`` accepts, of a run by ``rig``."""
    file = rig.calibrated
    calibrated = {"calibration_file": citation(rig), "calibration_text": file.text} if file else {}
    return calibrated | {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "motorid": __version__,
        "first_request": random.randrange(1, 0xFFFF),  # noqa: S311 - unlike the last session's
        "port": rig.port,
        "rig_name": rig.name,
        "rig": rig.text,
        "wiring": asdict(rig.wiring) | {"supply_voltage_v": rig.supply_voltage_v or 0.0},
        "voltage_sense": rig.voltage_sense,
        "calibration": {name: asdict(one) for name, one in rig.calibration.items()},
        "clock": {"rate": rig.clock_rate, "uncertainty": rig.clock_uncertainty},
        "board_serial": rig.board_serial or serial_of(rig.port),
        "program": program.to_dict(),
        "ambient_c": rig.ambient_c,
        "ambient_uncertainty_c": rig.ambient_uncertainty_c,
        "serial": serial,
        "note": note,
        **({"settings": dict(rig.settings)} if rig.settings else {}),
        "host": {
            "python": platform.python_version(),
            "system": platform.platform(terse=True),
            "clock_resolution_s": clock_check.resolution_s(),
        },
    }
