"""What the rig's file or an import states of the motor, as numbers: the one place that reads them.

A capture and its journal carry the rig's text, so that both give the same numbers whenever they
are read. An import keeps its own statements.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from motorid.capture.model import Stated

IMPORTED = "stated"  # provenance: nameplate and thermal figures that an import's options gave
SAID = "what the import stated of the motor"
NAMEPLATE = (
    "resistance_ohm", "inductance_h", "torque_constant_nm_a", "inertia_kg_m2", "no_load_current_a",
    "rated_current_a",
    "voltage_v",
)  # fmt: skip
THERMAL = (
    "winding_k_w", "winding_s", "copper_per_k", "copper_uncertainty_per_k", "magnet_per_k",
    "magnet_uncertainty_per_k",
)  # fmt: skip


def of_provenance(provenance: Mapping[str, Any]) -> Stated:
    """What a capture's provenance states of the motor; ``unread`` says what cannot be read."""
    text = provenance.get("rig", "")
    rigs = "the rig's file kept in the capture"
    if not isinstance(text, str):
        return Stated(unread=f"{rigs} is no text")
    try:
        rig = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        return Stated(unread=f"{rigs} is no TOML ({error})")
    imported, by_rig = _tables(provenance.get(IMPORTED, {}), SAID), _tables(rig, rigs)
    return replace(imported.under(by_rig), unread=by_rig.unread or imported.unread)


def kept(stated: Stated) -> dict[str, dict[str, float]]:
    """What an import states of the motor, as its provenance keeps it for ``of_provenance``."""
    return {"nameplate": dict(stated.nameplate), "thermal": dict(stated.thermal)}


def _tables(tables: object, where: str) -> Stated:
    """[nameplate] and [thermal] of a document."""
    if not isinstance(tables, Mapping):
        return Stated(unread=f"{where} is no table")
    wrong: list[str] = []
    nameplate = dict(_numbers(tables, "nameplate", NAMEPLATE, wrong))
    thermal = dict(_numbers(tables, "thermal", THERMAL, wrong))
    said = f"{where} gives no number for {', '.join(wrong)}"
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
