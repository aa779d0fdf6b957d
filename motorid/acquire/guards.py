"""What a board of minor 3 guards beyond its older limits: a voltage ceiling, contacts, signs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from motorid.capture.model import CURRENT, VOLTAGE
from motorid.errors import RigError
from motorid.rig import Rig
from motorid.wire.enums import ChannelKind, Feature, Input

SIGN_SHARE = 0.25  # of a limit: what passes it against the drive's sign is no offset and no noise
SIGN_TURN = 0.125  # of the encoder: play and a detent move it less
SIGN_COUNTS = 8  # at least: an edge under a line flickers
SIGMAS = 6.0
U16, U32 = (1 << 16) - 1, (1 << 32) - 1
ASK = "install newer firmware, or leave this key out and guard otherwise"
Fields = dict[str, Any]
INPUTS = {one.name.lower(): one for one in Input}


def has(identity: Mapping[str, Any], feature: Feature) -> bool:
    """Whether the board says that it has that feature; older boards have none."""
    return bool(identity.get("features", 0) >> feature & 1)


def lacking(identity: Mapping[str, Any]) -> list[str]:
    """Names of the features that the board has not."""
    return [one.name.lower() for one in Feature if not has(identity, one)]


def guards(rig: Rig, identity: Mapping[str, Any], known: Mapping[str, Any]) -> Fields:
    """Fields of ``configure`` for the ceiling and the contacts. Raises RigError where it cannot."""
    limits, fields = rig.limits, Fields()
    if limits.voltage_v is not None:
        _need(identity, Feature.VOLTAGE_LIMIT, "limits.voltage_v")
        if known.get(VOLTAGE, {}).get("kind") != ChannelKind.MEAN:
            raise RigError(
                "limits.voltage_v needs a terminal voltage that is read as a mean over the PWM, "
                f"and the board {identity['board']} reads instants: leave this key out"
            )
        fields["voltage_limit_mv"] = min(round(limits.voltage_v * 1e3), U32)
    if limits.inputs:
        _need(identity, Feature.INPUTS, "limits.inputs")
        wanted = sum(1 << INPUTS[name] for name in limits.inputs)
        for name in limits.inputs:
            if not identity["inputs"] >> INPUTS[name] & 1:
                raise RigError(
                    f"limits.inputs names {name}, and the board {identity['board']} has no pin for "
                    "it: leave it out"
                )
        fields["inputs_required"] = wanted
    return fields


def signs(rig: Rig, identity: Mapping[str, Any], known: Mapping[str, Any]) -> Fields:
    """Fields of ``configure`` for the sign check; none where board or rig do without it."""
    limits = rig.limits
    if not limits.sign_check_s or not has(identity, Feature.SIGN_CHECK):
        return {}
    current, voltage = known.get(CURRENT), known.get(VOLTAGE)
    amps = max(SIGN_SHARE * limits.current_a, _doubtful(current)) if current else U32 * 1e-3
    volts = U32 * 1e-3  # instants of a switching terminal have either sign
    if voltage and voltage["kind"] == ChannelKind.MEAN:
        supply = rig.supply_voltage_v or limits.supply_min_v
        volts = max(SIGN_SHARE * supply, _doubtful(voltage))
    counts = max(SIGN_COUNTS, round(SIGN_TURN * rig.wiring.counts_per_turn))
    return {
        "sign_check_ms": max(1, min(round(limits.sign_check_s * 1e3), U16)),
        "sign_check_ma": max(1, min(round(amps * 1e3), U32)),
        "sign_check_mv": max(1, min(round(volts * 1e3), U32)),
        "sign_check_counts": min(counts, U16),
    }


def brown_out(identity: Mapping[str, Any]) -> str:
    """A sentence where the processor may run on less voltage than its clock needs; else ""."""
    least, level = identity.get("brown_out_least_mv", 0), identity.get("brown_out_mv", 0)
    if level >= least:
        return ""
    detects = f"resets it below {level / 1e3:g} V" if level else "is off"
    return (
        f"the brown-out detector of {identity['board']} {detects}, and its clock needs "
        f"{least / 1e3:g} V: when its supply sags it may do anything; give it a supply apart from "
        "the motor's, or set its fuse (docs/firmware.md)"
    )


def _doubtful(fact: Mapping[str, Any]) -> float:
    """A reading in SI units that noise and offset alone may show."""
    return SIGMAS * abs(float(fact["scale"])) * float(fact["noise"] + fact["offset_uncertainty"])


def _need(identity: Mapping[str, Any], feature: Feature, key: str) -> None:
    if not has(identity, feature):
        raise RigError(
            f"the rig sets {key}, and the board {identity['board']} (protocol "
            f"{identity['protocol_major']}.{identity['protocol_minor']}) cannot hold it: {ASK}"
        )
