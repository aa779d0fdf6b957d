"""The corpus: small captures and logs, and how each is fitted."""

from __future__ import annotations

import hashlib
import lzma
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

# ``against`` runs this on other commits too: few names, and such as stay where they are.
from motorid.capture.store_read import read
from motorid.capture.table import read_table
from motorid.workflow.fit import fit_captures

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from motorid.estimate.results.estimate import Estimate

FOLDER = Path(__file__).resolve().parent
CAPTURES, LOGS, ANSWERS = FOLDER / "captures", FOLDER / "logs", FOLDER / "answers"
PACKED = ".h5.xz"  # raw integers shrink to a quarter


@dataclass(frozen=True)
class Case:
    """Files, and the options of their fit.

    ``files``: captures by their name, or logs with ``maps`` and the import's ``options``. ``fit``:
    keywords of ``fit_captures``. ``dear``: more than half a second of the processor.
    """

    name: str
    files: tuple[str, ...]
    maps: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    fit: Mapping[str, Any] = field(default_factory=dict)
    dear: bool = False

    def captures(self) -> list[Capture]:
        """The runs, as a person's files give them."""
        if self.maps:
            return [read_table(LOGS / name, self.maps, **self.options) for name in self.files]
        return [unpacked(name) for name in self.files]


def unpacked(name: str) -> Capture:
    """A stored capture."""
    data = lzma.decompress((CAPTURES / f"{name}{PACKED}").read_bytes())
    return read(data, name, hashlib.sha256(data).hexdigest())


def estimate(case: Case, captures: Sequence[Capture]) -> Estimate:
    """What the case's fit says of these captures."""
    return fit_captures(list(captures), **case.fit)


MAPS = {
    "v": "voltage=v:V", "i": "current=i:A", "w": "speed=w:rad/s", "p": "position=p:rad",
}  # fmt: skip


def log(
    name: str,
    columns: str,
    options: Mapping[str, Any] | None = None,
    dear: bool = False,
    **fit: Any,
) -> Case:
    """A log of time t and some of v, i, w and p (V, A, rad/s, rad)."""
    maps = ("time=t:s", *(MAPS[c] for c in columns))
    return Case(f"log-{name}", (f"{name}.csv",), maps, options or {}, fit, dear)


def runs(name: str, files: int = 1, of: str = "", dear: bool = False, **fit: Any) -> Case:
    """The first captures of a rig, which has another name where it is fitted in two ways."""
    return Case(name, tuple(f"{of or name}-{k}" for k in range(files)), fit=fit, dear=dear)


CASES = (
    runs("sim"),
    runs("sim-re35"),
    runs("sim-qube"),
    runs("sim-pittman"),
    runs("sim-line"),
    runs("three-runs", 3),
    runs("emulated-uno"),
    runs("no-resistance-on-the-plate", dear=True),
    runs("diode-decay"),
    runs("fast-decay"),
    runs("thermal-figures"),
    runs("wrong-counts"),
    runs("supply-sense-by-duty"),
    runs("brushes-and-cogging", dear=True),
    runs("terms-asked", of="sim", dear=True, model="brush-drop+quadratic-load"),
    runs("fixed-and-left-out", of="sim", fix={"K": 7.68e-3}, without=("B",), model="six"),
    runs("steiglitz-mcbride", of="sim", dear=True, method="steiglitz-mcbride"),
    runs("steady-state", of="sim", method="steady-state"),
    runs("nls", of="sim-line", method="nls"),
    runs("pso", of="sim-line", method="pso-ciw", budget=2000, seed=2),
    runs("drawn-12", dear=True, model="six"),
    runs("drawn-526", 3, dear=True),
    runs("drawn-903", 3, dear=True, model="six"),
    runs("drawn-930", dear=True),
    runs("drawn-1123", dear=True, model="six"),
    runs("drawn-1449", dear=True),
    log("steps", "viw"),
    log("position", "vip"),
    log("means", "viw", {"aperture": {"current": 1e-3, "voltage": 1e-3, "speed": 1e-3}}),
    log("random-stamps", "viw"),
    log("drop-outs", "viw"),
    log("motionless", "vi"),
    log("motionless-random-stamps", "vi", dear=True),
    log("locked-rotor", "viw"),
    log("mechanical", "iw"),
    log("no-current", "vw"),
    log("coast-down", "w"),
    log("tachometer", "v", fix={"K": 0.05}),
)
