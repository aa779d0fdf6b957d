"""Rig files and instruments' files of the mock bench."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.scpi.run import capture_all
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import LinkError
from motorid.rig import Rig, load_rig
from tests.scpi.bench import SHUNT_V_A, TACHO_V_RAD_S, Bench, SettableClock

RIG = """
name = "mock"
port = "scpi://instruments.toml"
[wiring]
lead_resistance_ohm = 0.0
lead_resistance_uncertainty_ohm = 0.001
[limits]
current_a = 4
speed_rad_s = 2000
supply_min_v = 0
supply_max_v = 9
[nameplate]
voltage_v = 6
resistance_ohm = 2.6
[sampling]
rate_hz = {rate_hz}
[program]
levels_v = {levels}
drive_s = {drive_s}
coast_s = {drive_s}
"""
SUPPLY = """
[supply]
resource = "{supply}"
timeout_s = {patience_s}
"""
SCOPE = f"""
[recorder]
resource = "{{scope}}"
dialect = "scope.toml"
timeout_s = {{patience_s}}
lead_s = 0.02

[channels.current]
source = "CHAN1"
scale = {1 / SHUNT_V_A}
gain_uncertainty = 0.005
offset_uncertainty = 0.01

[channels.terminal_voltage]
source = "CHAN2"
gain_uncertainty = 0.002
offset_uncertainty = 0.01

[channels.speed]
source = "CHAN3"
scale = {1 / TACHO_V_RAD_S}
gain_uncertainty = 0.005
offset_uncertainty = 0.5
"""
SCOPE_DIALECT = """
kind = "recorder"
error = ":SYST:ERR?"
[acquire]
start = [":ACQ:RATE {rate_hz}", ":ACQ:POIN {points}"]
done = ":OPER:COND?"
mask = 8
value = 0
stop = [":STOP"]
[waveform]
select = [":WAV:SOUR {source}"]
preamble = ":WAV:PRE?"
data = ":WAV:DATA?"
type = "H"
raw_min = 0
raw_max = 65535
"""


class MockLink:
    """A link that asks a mock bench directly."""

    def __init__(self, answer: Any) -> None:
        self._answer, self.closed = answer, False

    def write(self, text: str) -> None:
        self._answer(text)

    def ask(self, text: str) -> str:
        found = self._answer(text)
        if found is None:
            raise LinkError(f"mock: no answer to {text!r}")
        return str(found)

    def block(self, text: str, kind: str, big_endian: bool) -> NDArray[Any]:
        data = self._answer(text)
        return np.frombuffer(data[2 + int(data[1:2]) :], dtype="<u2")

    def close(self) -> None:
        self.closed = True


def rig(
    folder: Path,
    *,
    scope: bool = True,
    more: str = "",
    rate_hz: float = 5000,
    levels: str = "[[3, 6]]",
    drive_s: float = 0.1,
    supply: str = "supply",
    scope_at: str = "scope",
    top: str = "",
    patience_s: float = 5.0,
) -> Rig:
    """The mock rig, its files in ``folder``."""
    (folder / "scope.toml").write_text(SCOPE_DIALECT)
    text = SUPPLY.format(supply=supply, patience_s=patience_s) + more
    text += SCOPE.format(scope=scope_at, patience_s=patience_s) if scope else ""
    (folder / "instruments.toml").write_text(top + text)
    path = folder / "rig.toml"
    path.write_text(RIG.format(rate_hz=rate_hz, levels=levels, drive_s=drive_s))
    return load_rig(str(path))


def recorded(bench: Bench, clock: SettableClock, one: Rig, path: Path, **options: Any) -> Capture:
    """One run of the mock rig, read back."""

    def open_link(backend: str, resource: str, timeout_s: float, name: str) -> MockLink:
        return MockLink(bench.supply if resource == "supply" else bench.scope)

    capture_all(one, one.program, [path], open_link=open_link, clock=clock, **options)
    return store.load(path)


def mock(**options: Any) -> tuple[Bench, SettableClock]:
    """A bench on a clock that passes only where somebody waits."""
    clock = SettableClock()
    return Bench(clock.now, clock.sleep, **options), clock
