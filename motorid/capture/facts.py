"""What the rig's file states of the motor, as numbers: the one place that reads them from its text.

A capture and its journal carry that text, so that both give the same numbers whenever they are
read.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from motorid.capture.model import Stated

NAMEPLATE = (
    "resistance_ohm", "inductance_h", "torque_constant_nm_a", "inertia_kg_m2", "no_load_current_a",
    "voltage_v",
)  # fmt: skip
THERMAL = (
    "winding_k_w", "winding_s", "copper_per_k", "copper_uncertainty_per_k", "magnet_per_k",
    "magnet_uncertainty_per_k",
)  # fmt: skip


def of_provenance(provenance: Mapping[str, Any]) -> Stated:
    """What the rig's text in a capture's provenance states; ``unread`` says what cannot be read."""
    text = provenance.get("rig", "")
    if not isinstance(text, str):
        return Stated(unread="the rig's file kept in the capture is no text")
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        return Stated(unread=f"the rig's file kept in the capture is no TOML ({error})")
    wrong: list[str] = []
    nameplate = dict(_numbers(tables, "nameplate", NAMEPLATE, wrong))
    thermal = dict(_numbers(tables, "thermal", THERMAL, wrong))
    said = f"the rig's file kept in the capture gives no number for {', '.join(wrong)}"
    return Stated(nameplate, thermal, said if wrong else "")


def _numbers(
    tables: Mapping[str, Any], section: str, names: tuple[str, ...], wrong: list[str]
) -> Iterator[tuple[str, float]]:
    """The finite numbers of a section; the others are added to ``wrong``."""
    table = tables.get(section, {})
    if not isinstance(table, dict):
        wrong.append(section)
        return
    for name in names:
        value = table.get(name)
        number = math.nan
        if isinstance(value, int | float) and not isinstance(value, bool):
            number = float(value)
        if math.isfinite(number):
            yield name, number
        elif value is not None:
            wrong.append(f"{section}.{name}")
