"""A stored capture under another rig: the raw readings stay, their meaning is computed anew."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from motorid.capture.model import POSITION, Capture, Channel
from motorid.errors import DataError, RigError

if TYPE_CHECKING:
    from motorid.rig import Rig

CAPTURED = ("identity", "descriptors", "configuration")  # provenance of a run of a board


def recalibrated(capture: Capture, rig: Rig) -> Capture:
    """``capture`` as ``rig`` (its wiring, calibration, ambient) would have scaled it.

    Raw integers, ticks, program and SHA-256 are the capture's. Offsets are the run's own zero; how
    uncertain that was stays too, unless the rig says. Raises DataError for a capture that was not
    taken from a board, RigError for a rig of another board or with channels that the capture lacks.
    """
    known = capture.provenance
    where = capture.path or "the capture"
    if any(name not in known for name in CAPTURED):
        raise DataError(
            f"{where} was imported, not taken from a board, so no rig explains its columns: import "
            "it again with other units or facts"
        )
    try:
        _refuse_other(capture, rig, where)
        return _under(capture, rig)
    except (KeyError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise DataError(
            f"{where}: what it keeps of its board's channels is damaged ({error!r}), so no rig can "
            "explain it"
        ) from None


def _under(capture: Capture, rig: Rig) -> Capture:
    from motorid.acquire.clock import Clock
    from motorid.acquire.clock_check import of_identity

    known = capture.provenance
    seen = Clock(**known["clock"]) if "clock" in known else None
    clock_hz, clock_uncertainty, _ = of_identity(
        known["identity"], rig.clock_rate, rig.clock_uncertainty, seen
    )
    return replace(
        capture,
        clock_hz=clock_hz,
        clock_uncertainty=clock_uncertainty,
        channels={name: _channel(capture, c, rig) for name, c in capture.channels.items()},
        wiring=replace(
            rig.wiring,
            supply_voltage_v=rig.supply_voltage_v or 0.0,
            pwm_hz=capture.wiring.pwm_hz,
            dead_time_s=capture.wiring.dead_time_s,
        ),
        ambient_c=capture.ambient_c if rig.ambient_c is None else rig.ambient_c,
        ambient_uncertainty_c=(
            capture.ambient_uncertainty_c if rig.ambient_c is None else rig.ambient_uncertainty_c
        ),
        stated=capture.stated.under(rig.stated),
        provenance={**known, "reanalysed": cited(rig)},
    )


def cited(rig: Rig) -> dict[str, Any]:
    """What an estimate cites of a rig: its name, the digest of its file, and its calibration."""
    from motorid.rig_calibration import citation

    calibration = citation(rig)
    return {
        "rig_name": rig.name,
        "rig_sha256": hashlib.sha256(rig.text.encode()).hexdigest(),
        **({"calibration": calibration} if calibration else {}),
    }


def _refuse_other(capture: Capture, rig: Rig, where: str) -> None:
    from motorid.rig_calibration import refuse_other_board

    known = capture.provenance
    serial = str(known.get("board_serial", ""))
    if rig.board_serial and serial and rig.board_serial != serial:
        raise RigError(
            f"{where} was taken with board {serial}, and the rig {rig.name} is of board "
            f"{rig.board_serial}: name the rig of that board"
        )
    if rig.calibrated is not None:
        try:
            refuse_other_board(rig.calibrated, str(known["identity"].get("board", "")), serial)
        except RigError as error:
            raise RigError(f"{where}: {error}") from None
    missing = [name for name in rig.sampling.channels if name not in capture.channels]
    if missing:
        raise RigError(
            f"{where} holds no {missing[0]}, which the rig {rig.name} samples (sampling.channels): "
            f"it holds {', '.join(capture.channels)}; name its own rig, corrected"
        )


def _channel(capture: Capture, channel: Channel, rig: Rig) -> Channel:
    from motorid.acquire import channels
    from motorid.rig import Calibration

    known = capture.provenance
    fact = known["descriptors"][channel.name]
    if channel.name == POSITION:
        new = channels.position(channel.raw, fact, rig.wiring.counts_per_turn)
        turned = bool(known["configuration"]["encoder_reversed"]) != rig.encoder_reversed
        return replace(new, scale=-new.scale, offset=channel.offset) if turned else new
    says = rig.calibration.get(channel.name, Calibration())
    size = abs(channel.scale)
    offset = channel.offset
    if says.offset is not None and not channels.zeroed(channel.name, known.get("zero", {})):
        offset = says.offset
    counts = (offset, channel.offset_uncertainty / size, channel.noise / size)
    new = channels.analogue(channel.name, channel.raw, fact, says, counts, rig.voltage_sense)
    return replace(new, ratiometric=channel.ratiometric)
