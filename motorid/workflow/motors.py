"""Several motors side by side: their parameters, which differences are real, and their curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from motorid import csv_text
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.results.estimate import PARAMETERS
from motorid.storage.captures import load
from motorid.storage.place import Place
from motorid.workflow.many import Fitted

REAL = 2.0  # standard uncertainties of a difference


@dataclass(frozen=True)
class Motor:
    """One capture's motor. ``rig``: digests of its rig and calibration, "" where it names none."""

    label: str
    fit: Fitted
    capture: Capture | None  # None: it could not be read
    rig: str


@dataclass(frozen=True)
class Difference:
    """Of a parameter to that of the first motor, a share of it, with its standard uncertainty."""

    share: float
    u: float

    @property
    def real(self) -> bool:
        """Beyond what the uncertainties explain."""
        return abs(self.share) > REAL * self.u


def motors(paths: Sequence[Place], fits: Sequence[Fitted]) -> list[Motor]:
    """Each fit with its capture, named by serial number or file, every name once."""
    found = [_read(path) for path in paths]
    names = [fit.serial or path.stem for path, fit in zip(paths, fits, strict=True)]
    return [
        Motor(name if names.count(name) == 1 else f"{name} ({path.stem})", fit, capture, rig)
        for name, path, fit, (capture, rig) in zip(names, paths, fits, found, strict=True)
    ]


def _read(path: Place) -> tuple[Capture | None, str]:
    try:
        capture = load(path)
    except DataError:
        return None, ""
    known = store.describe(capture)
    digests = (known.get("rig_sha256", ""), known.get("calibration", {}).get("sha256", ""))
    return capture, " ".join(digests).strip()


def difference(one: Motor, other: Motor, name: str) -> Difference | None:
    """Of ``one`` to ``other``; None where either is unknown.

    Two captures by one rig and one calibration share their instruments' errors: only what is
    statistical counts then.
    """
    a, b = (motor.fit.values.get(name, {}) for motor in (one, other))
    if not (_known(a) and _known(b)) or one is other:
        return None
    kind = "statistical" if one.rig and one.rig == other.rig else "total"
    u = math.hypot(a[kind] or 0.0, b[kind] or 0.0)
    size = abs(float(b["value"]))
    return Difference((a["value"] - b["value"]) / size, u / size) if size and u else None


def _known(found: Mapping[str, Any]) -> bool:
    return found.get("value") is not None and found.get("total") is not None


def table(found: Sequence[Motor]) -> str:
    """CSV, a row a motor and parameter: SI values, uncertainties, differences to the first."""
    head = [
        "motor",
        "path",
        "parameter",
        "value",
        "u",
        "status",
        "difference",
        "u_difference",
        "real",
    ]
    rows = []
    for motor in found:
        for name in PARAMETERS:
            value = motor.fit.values.get(name, {})
            apart = difference(motor, found[0], name)
            rows.append(
                [motor.label, motor.fit.path, name, value.get("value"), value.get("total")]
                + [value.get("status", motor.fit.failure)]
                + ([apart.share, apart.u, apart.real] if apart else [None, None, None])
            )
    return csv_text.table(head, rows)


def said(found: Sequence[Motor]) -> list[str]:
    """A line for each real difference, and for each capture that failed."""
    lines = []
    for motor in found:
        if motor.fit.failure:
            lines.append(f"{motor.label}: not fitted: {motor.fit.failure}")
        for name in PARAMETERS:
            apart = difference(motor, found[0], name)
            if apart and apart.real:
                words = "higher" if apart.share > 0 else "lower"
                lines.append(
                    f"{motor.label}: {name} is {100 * abs(apart.share):.2g} % {words} than in "
                    f"{found[0].label} (± {100 * REAL * apart.u:.2g} %)"
                )
    return lines or [f"no parameter differs from {found[0].label} beyond its uncertainty"]
